"""Reads values in a URDF's elements: children, numbers, poses."""

from __future__ import annotations

import math

import numpy as np

from linkwright.stages.formats.urdf.diagnostics import FileDiagnostics
from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.model.poses import from_parts, rotation_from_quat, rotation_from_rpy
from linkwright.stages.robot.model.robot import Array, frozen


def child(element: Element, name: str, log: FileDiagnostics) -> Element | None:
    """Returns the child of that name, or None. Reports W-URDF-TWICE for several; the first counts."""
    children = [node for node in element if tag(node) == name]
    if len(children) > 1:
        log.report("W-URDF-TWICE", children[1], f"<{tag(element)}> has several <{name}>; the first counts")
    return children[0] if children else None


def number(
    element: Element, name: str, log: FileDiagnostics, default: float | None = None, *, infinite: bool = False
) -> float | None:
    """Returns a number in an attribute; `default` if it is missing, or invalid (reports E-URDF-NUMBER).

    `infinite`: whether it may be infinite.
    """
    values = numbers(element, name, 1, log, infinite=infinite)
    return default if values is None else values[0]


def numbers(
    element: Element, name: str, count: int, log: FileDiagnostics, *, infinite: bool = False
) -> tuple[float, ...] | None:
    """Returns `count` numbers in an attribute, with spaces or commas between them; None if the attribute is
    missing, empty or wrong (reports E-URDF-NUMBER)."""
    text = element.get(name)
    pieces = text.replace(",", " ").split() if text else []
    if not pieces:
        return None
    values = [_value(piece) for piece in pieces]
    good = [
        value
        for value in values
        if value is not None and (math.isfinite(value) or (infinite and not math.isnan(value)))
    ]
    if len(good) == count == len(values):
        return tuple(good)
    expected = "a finite number" if count == 1 else f"{count} finite numbers"
    if infinite:
        expected = expected.replace("finite ", "")
    value_text = " ".join(pieces)
    value_text = value_text if len(value_text) <= 60 else f"{value_text[:60]}…"
    log.report("E-URDF-NUMBER", element, f'<{tag(element)} {name}="{value_text}">: expected {expected}')
    return None


def _value(text: str) -> float | None:
    """Returns the number in a text, which may be infinite or NaN; None if the text is not a number."""
    # Python reads 1_000 as a number; readers of URDF do not.
    if "_" in text:
        return None
    try:
        return float(text)
    except ValueError:
        return None


def pose(element: Element, log: FileDiagnostics) -> Array:
    """Returns the transform (4, 4) of an element's <origin>; the identity without an <origin>."""
    origin = child(element, "origin", log)
    if origin is None:
        return frozen(np.eye(4))
    log.count_left_out(origin, (), ("xyz", "rpy", "quat_xyzw"))
    x, y, z = numbers(origin, "xyz", 3, log) or (0.0, 0.0, 0.0)
    quat = numbers(origin, "quat_xyzw", 4, log)
    # A quaternion of zeros is not a rotation: then `rpy` counts.
    if quat is not None and any(quat):
        rotation = rotation_from_quat(np.array([quat[3], *quat[:3]]))
    else:
        roll, pitch, yaw = numbers(origin, "rpy", 3, log) or (0.0, 0.0, 0.0)
        rotation = rotation_from_rpy((roll, pitch, yaw))
    return frozen(from_parts(rotation, np.array([x, y, z])))
