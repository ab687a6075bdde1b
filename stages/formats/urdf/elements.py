"""Values in a URDF's elements: children, numbers, poses."""

from __future__ import annotations

import math

import numpy as np

from linkwright.stages.formats.urdf.diagnostics import FileDiagnostics
from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.model.poses import from_parts, rotation_from_quat, rotation_from_rpy
from linkwright.stages.robot.model.robot import Array, frozen


def child(element: Element, name: str, log: FileDiagnostics) -> Element | None:
    """The child of that name, None without one; W-URDF-TWICE for several, of which the first counts."""
    found = [one for one in element if tag(one) == name]
    if len(found) > 1:
        log.report("W-URDF-TWICE", found[1], f"<{tag(element)}> has several <{name}>; the first counts")
    return found[0] if found else None


def number(
    element: Element, name: str, log: FileDiagnostics, default: float | None = None, *, infinite: bool = False
) -> float | None:
    """A number in an attribute; `default` where it is missing or invalid (E-URDF-NUMBER).

    `infinite`: whether it may be infinite.
    """
    found = numbers(element, name, 1, log, infinite=infinite)
    return default if found is None else found[0]


def numbers(
    element: Element, name: str, count: int, log: FileDiagnostics, *, infinite: bool = False
) -> tuple[float, ...] | None:
    """`count` numbers in an attribute, with spaces or commas between them; None where the attribute is
    not there, empty or wrong (E-URDF-NUMBER)."""
    text = element.get(name)
    pieces = text.replace(",", " ").split() if text else []
    if not pieces:
        return None
    values = [_value(piece) for piece in pieces]
    good = [one for one in values if one is not None and (math.isfinite(one) or (infinite and one == one))]
    if len(good) == count == len(values):
        return tuple(good)
    wanted = "a finite number" if count == 1 else f"{count} finite numbers"
    if infinite:
        wanted = wanted.replace("finite ", "")
    shown = " ".join(pieces)
    shown = shown if len(shown) <= 60 else f"{shown[:60]}…"
    log.report("E-URDF-NUMBER", element, f'<{tag(element)} {name}="{shown}">: expected {wanted}')
    return None


def _value(text: str) -> float | None:
    if "_" in text:
        return None
    try:
        return float(text)
    except ValueError:
        return None


def pose(element: Element, log: FileDiagnostics) -> Array:
    """The (4, 4) transform of an element's <origin>, the identity without one."""
    origin = child(element, "origin", log)
    if origin is None:
        return frozen(np.eye(4))
    log.check(origin, (), ("xyz", "rpy", "quat_xyzw"))
    x, y, z = numbers(origin, "xyz", 3, log) or (0.0, 0.0, 0.0)
    quat = numbers(origin, "quat_xyzw", 4, log)
    if quat is not None and any(quat):
        rotation = rotation_from_quat(np.array([quat[3], *quat[:3]]))
    else:
        roll, pitch, yaw = numbers(origin, "rpy", 3, log) or (0.0, 0.0, 0.0)
        rotation = rotation_from_rpy((roll, pitch, yaw))
    return frozen(from_parts(rotation, np.array([x, y, z])))
