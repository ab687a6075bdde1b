"""Masses as CAD has them: part studio replies to one inertial per part.

Onshape gives each value as [nominal, min, max]; `inertia` is 27 numbers of which the first nine
are the nominal tensor, row by row, about the centroid, in the part studio's axes, with true signs.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import orjson

from stages.robot.bundle import Bundle, StudioKey
from stages.robot.errors import ProtocolError
from stages.robot.model import Inertial, frozen

PartKey = tuple[StudioKey, str]


def read_masses(bundle: Bundle) -> dict[PartKey, tuple[Inertial, float]]:
    """(inertial in the part's frame, volume [m³]) of every part in the bundle's replies.

    A part without material has mass 0 there, and its volume all the same.
    """
    found: dict[PartKey, tuple[Inertial, float]] = {}
    for studio in bundle.studios:
        for digest in studio.mass:
            for part, body in _bodies(bundle.body(digest)):
                found[studio.key, part] = _inertial(body), float(_first(body.get("volume")))
    return found


def _bodies(reply: bytes) -> Iterable[tuple[str, Mapping[str, Any]]]:
    try:
        bodies = orjson.loads(reply)["bodies"]
    except (orjson.JSONDecodeError, KeyError, TypeError) as error:
        msg = "the reply is not a mass-properties reply"
        raise ProtocolError(msg, hint="fetch it again") from error
    return ((part, body) for part, body in bodies.items() if part != "-all-")


def _inertial(body: Mapping[str, Any]) -> Inertial:
    centroid = (body.get("centroid") or [0.0] * 3)[:3]
    inertia = (body.get("inertia") or [0.0] * 9)[:9]
    tensor = frozen(inertia).reshape(3, 3)
    return Inertial(float(_first(body.get("mass"))), frozen(centroid), frozen((tensor + tensor.T) / 2))


def _first(values: object) -> float:
    if isinstance(values, list):
        return float(values[0]) if values else 0.0
    return float(values or 0.0)  # type: ignore[arg-type]
