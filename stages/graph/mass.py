"""Masses as CAD has them: part studio replies to one inertial per part.

Onshape gives each value as [nominal, min, max]; `inertia` is 27 numbers of which the first nine
are the nominal tensor, row by row, about the centroid, in the part studio's axes, with true signs.
"""

from collections.abc import Mapping
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
            try:
                bodies = orjson.loads(bundle.body(digest))["bodies"]
                for part in sorted(set(bodies) - {"-all-"}):
                    volume = _first(bodies[part].get("volume"))
                    found[studio.key, part] = _inertial(bodies[part]), volume
            except (KeyError, TypeError, ValueError, AttributeError) as error:
                msg = f"the mass properties are not in the shape of the API ({type(error).__name__}: {error})"
                hint = "fetch them again, or make the bundle again; if it stays so, the API has changed"
                raise ProtocolError(msg, f"part studio {studio.key.element}", hint) from error
    return found


def _inertial(body: Mapping[str, Any]) -> Inertial:
    centroid = (body.get("centroid") or [0.0] * 3)[:3]
    inertia = (body.get("inertia") or [0.0] * 9)[:9]
    tensor = frozen(inertia).reshape(3, 3)
    return Inertial(float(_first(body.get("mass"))), frozen(centroid), frozen((tensor + tensor.T) / 2))


def _first(values: object) -> float:
    if isinstance(values, list):
        return float(values[0]) if values else 0.0
    return float(values or 0.0)  # type: ignore[arg-type]
