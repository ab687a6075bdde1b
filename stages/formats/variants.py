"""Reads and writes `variants.npz`: randomized variants of a robot, as values of fields of MuJoCo's model."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.npz import Arrays, NotNpz, arrays_of, npz

KINDS = ("body", "joint", "geom", "actuator")
"""The kinds of elements whose names the file contains."""


@dataclass(frozen=True, eq=False)
class Variants:
    """Randomized variants of a robot, with the facts that tie them to its MJCF."""

    seed: int
    """The seed of the randomization."""

    mjcf: str
    """The SHA-256 of the MJCF that the arrays belong to."""

    names: Mapping[str, tuple[str, ...]]
    """The names of the model's elements, by kind."""

    geom_bodyid: npt.NDArray[np.int32]
    """(geoms,): MuJoCo's number of each geom's body."""

    geom_in_body: npt.NDArray[np.int32]
    """(geoms,): the index of each geom within its body."""

    fields: Mapping[str, npt.NDArray[np.float64]]
    """Name of a field of MuJoCo's model → its values in all variants, (n, ...)."""

    @property
    def n(self) -> int:
        """The number of variants that all fields have values for; 0 without fields."""
        return min((len(values) for values in self.fields.values()), default=0)

    def to_bytes(self) -> bytes:
        """Returns the variants as the bytes of a file."""
        arrays: dict[str, npt.NDArray[Any]] = {
            "fields": _string_array(self.fields),
            "seed": np.array(self.seed, np.uint64),
            "mjcf": np.array(self.mjcf),
            **{f"{kind}_names": _string_array(self.names[kind]) for kind in KINDS},
            "geom_bodyid": self.geom_bodyid,
            "geom_in_body": self.geom_in_body,
        }
        return npz(arrays | dict(self.fields))

    @classmethod
    def from_bytes(cls, data: bytes) -> "Variants":
        """Reads variants from a file. Raises NotNpz if an array is missing or has the wrong type."""
        arrays = arrays_of(data)
        try:
            fields = {str(name): _float_array(arrays, str(name)) for name in arrays["fields"]}
            return cls(
                int(arrays["seed"]),
                str(arrays["mjcf"]),
                {kind: tuple(map(str, arrays[f"{kind}_names"])) for kind in KINDS},
                arrays["geom_bodyid"].astype(np.int32),
                arrays["geom_in_body"].astype(np.int32),
                fields,
            )
        except (KeyError, TypeError, ValueError) as error:
            msg = f"it lacks an array, or has one of another kind: {error}"
            raise NotNpz(msg) from None


def digest_of(mjcf: bytes) -> str:
    """Returns the SHA-256 (hexadecimal) of an MJCF, by which the arrays identify it."""
    return hashlib.sha256(mjcf).hexdigest()


def _string_array(names: Any) -> npt.NDArray[np.str_]:
    return np.array(list(names), np.str_)


def _float_array(arrays: Arrays, name: str) -> npt.NDArray[np.float64]:
    array = arrays[name]
    if array.dtype != np.float64 or array.ndim < 1:
        msg = f"{name} is not an array of doubles"
        raise ValueError(msg)
    return array
