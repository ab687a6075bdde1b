"""Finds, in MuJoCo's compiled model, attributes and options of an MJCF that our robot model cannot represent.

The compiled model is compared with an empty model of the same MuJoCo, so it does not matter where a value
comes from (a default, an include), and values equal to MuJoCo's default are not reported. Fields that a later
MuJoCo adds are reported too, until they are listed here as carried over.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.fields import ARRAYS, bare
from linkwright.stages.mujoco.names import name_of


@dataclass(frozen=True, slots=True)
class Omission:
    """An attribute or option that is not carried over."""

    words: str
    """The name of the attribute or option, as in an MJCF."""

    affects_motion: bool
    """Whether the robot may move differently without it."""

    names: tuple[str, ...] = ()
    """The elements that set it: "" for an element without a name; empty for an option of the whole model."""


_STRUCTURE: Mapping[str, Collection[str]] = {
    "jnt": ("type", "pos", "axis", "limited", "range", "actfrclimited"),
    "dof": ("M0", "length"),
    "body": (
        *("pos", "quat", "ipos", "iquat", "mass", "inertia", "subtreemass", "simple", "sameframe"),
        *("conaffinity", "contype", "margin", "plugin"),
    ),
    "geom": (
        *("type", "pos", "quat", "size", "rgba", "matid", "dataid", "group", "fluid"),
        *("aabb", "rbound", "sameframe", "plugin"),
    ),
    "site": ("pos", "quat", "sameframe", "matid"),
    "cam": ("pos", "quat", "pos0", "poscom0", "mat0", "intrinsic", "sensorsize"),
    "light": ("pos", "dir", "pos0", "poscom0", "dir0"),
    "eq": ("type", "objtype", "data", "active0"),
    "mat": ("rgba",),
    "tendon": ("limited", "actfrclimited", "lengthspring", "length0", "matid", "treenum", "type"),
    "pair": ("signature", "geom1", "geom2"),
    "actuator": (
        *("trntype", "ctrllimited", "forcelimited", "actlimited", "length0", "acc0", "lengthrange"),
        *("ctrlspec", "plugin"),
    ),
    "sensor": ("type", "datatype", "needstage", "objtype", "reftype", "dim", "intprm", "plugin"),
}
"""Arrays, besides those of `stages.mujoco.fields`, that are carried over, that follow from other arrays, or
that `unsupported` reports."""

_INDEX_ENDINGS = ("id", "adr", "num", "invweight0")
_NOT_INDICES = ("fluid", "texid", "matid", "dataid")
"""Endings of the names of fields that are only indices or derived values, and the fields with such endings
that are not."""

_WORDS: Mapping[str, str] = {
    "mat_texid": "material texture",
    "site_dataid": "site mesh",
    "light_texid": "light texture",
    "actuator_history": "actuator nsample, interp",
    "sensor_history": "sensor nsample, interp",
}
"""Field of MuJoCo's model → the attribute of an MJCF, where their names differ."""

_ELEMENTS = {"jnt": "joint", "dof": "joint", "eq": "equality", "mat": "material", "cam": "camera"}

_HARMLESS_PREFIXES = ("sensor_", "site_", "mat_", "cam_", "light_", "tendon_matid")
"""Prefixes of arrays that do not change how the robot itself moves."""


def element_omissions(model: Any, textured: Collection[int]) -> Iterator[Omission]:
    """Yields the omissions of the elements of a model; the materials that are `textured` keep their
    textures."""
    omissions: dict[str, Omission] = {}
    for kind, (array, names_of) in _KINDS.items():
        numbers = range(1 if kind == "body" else 0, len(getattr(model, array)))
        for field in _fields(kind):
            array_name = f"{kind}_{field}"
            checked_numbers = [n for n in numbers if array_name != "mat_texid" or n not in textured]
            names = [names_of(model, n) for n in _differing(model, array_name, checked_numbers)]
            if names:
                words = _WORDS.get(array_name, f"{_ELEMENTS.get(kind, kind)} {field}")
                earlier_names = omissions[words].names if words in omissions else ()
                every_name = earlier_names + tuple(
                    name for name in names if not name or name not in earlier_names
                )
                omissions[words] = Omission(words, not array_name.startswith(_HARMLESS_PREFIXES), every_name)
    yield from omissions.values()


@cache
def _fields(kind: str) -> tuple[str, ...]:
    """Returns the fields of a kind of element that are not carried over, sorted by name."""
    names = (name.removeprefix(f"{kind}_") for name in dir(bare()) if name.startswith(f"{kind}_"))
    return tuple(
        name
        for name in names
        if name not in _STRUCTURE[kind]
        and f"{kind}_{name}" not in ARRAYS
        and (name in _NOT_INDICES or not name.endswith(_INDEX_ENDINGS))
    )


def _differing(model: Any, field: str, numbers: Sequence[int]) -> list[int]:
    """Returns the elements whose value of the field differs from that in an empty model."""
    if not numbers:
        return []
    values = getattr(model, field)[list(numbers)].reshape(len(numbers), -1)
    default = np.ravel(getattr(bare(), field)[-1])
    if values.shape[1] != default.size:  # the length of `user` differs between models
        default = np.zeros(1)
    differs = ~np.isclose(values, default, rtol=1e-6, atol=1e-12).all(axis=1)
    return [number for number, is_set in zip(numbers, differs, strict=True) if is_set]


def _name_finder(kind: Any) -> Callable[[Any, int], str]:
    return lambda model, number: name_of(model, kind, number)


def _name_of_dof(model: Any, dof: int) -> str:
    return name_of(model, mujoco.mjtObj.mjOBJ_JOINT, int(model.dof_jntid[dof]))


_KINDS: Mapping[str, tuple[str, Callable[[Any, int], str]]] = {
    "jnt": ("jnt_type", _name_finder(mujoco.mjtObj.mjOBJ_JOINT)),
    "dof": ("dof_jntid", _name_of_dof),
    "body": ("body_parentid", _name_finder(mujoco.mjtObj.mjOBJ_BODY)),
    "geom": ("geom_type", _name_finder(mujoco.mjtObj.mjOBJ_GEOM)),
    "site": ("site_type", _name_finder(mujoco.mjtObj.mjOBJ_SITE)),
    "cam": ("cam_mode", _name_finder(mujoco.mjtObj.mjOBJ_CAMERA)),
    "light": ("light_mode", _name_finder(mujoco.mjtObj.mjOBJ_LIGHT)),
    "eq": ("eq_type", _name_finder(mujoco.mjtObj.mjOBJ_EQUALITY)),
    "mat": ("mat_rgba", _name_finder(mujoco.mjtObj.mjOBJ_MATERIAL)),
    "tendon": ("tendon_adr", _name_finder(mujoco.mjtObj.mjOBJ_TENDON)),
    "pair": ("pair_dim", _name_finder(mujoco.mjtObj.mjOBJ_PAIR)),
    "actuator": ("actuator_trntype", _name_finder(mujoco.mjtObj.mjOBJ_ACTUATOR)),
    "sensor": ("sensor_type", _name_finder(mujoco.mjtObj.mjOBJ_SENSOR)),
}
"""Prefix of arrays → an array, and a function that returns the names of the elements."""


def viewer_omissions(model: Any) -> Iterator[Omission]:
    """Yields the parts of <visual> that are set, and their attributes."""
    for part in _members(model.vis):
        visual, default = getattr(model.vis, part), getattr(bare().vis, part)
        names = [n for n in _members(visual) if not np.array_equal(getattr(visual, n), getattr(default, n))]
        if names:
            yield Omission(f"visual {part.removesuffix('_')}", False, tuple(names))


_SIZES = ("memory", "nconmax", "njmax", "nkey", "nuser")
"""Prefixes of the attributes of <size>."""


def file_omissions(spec: Any) -> Iterator[Omission]:
    """Yields the settings of <size> and <statistic>; the compiled model does not separate these from derived
    values."""
    empty_spec = mujoco.MjSpec()
    for name in (name for name in dir(empty_spec) if name.startswith(_SIZES)):
        if getattr(spec, name) != getattr(empty_spec, name):
            yield Omission(f'size {name}="{getattr(spec, name)}"', False)
    for name in _members(spec.stat):
        value, default = (
            np.atleast_1d(getattr(struct.stat, name)).astype(float) for struct in (spec, empty_spec)
        )
        if not np.array_equal(value, default, equal_nan=True):
            yield Omission(f'statistic {name}="{_text(value)}"', False)


def _members(struct: Any) -> list[str]:
    return [name for name in dir(struct) if not name.startswith("_") and not callable(getattr(struct, name))]


def _text(value: Any) -> str:
    return " ".join(f"{float(number):g}" for number in value)
