"""What robot.json says of links: mass properties, the parts that CAD has, and the user's own shapes."""

from typing import Any

import numpy as np

from stages.export.json_values import as_float, as_floats, as_pose
from stages.formats.numbers import LENGTH
from stages.robot.model import Array, Inertial, Link, Part, Primitive


def link_record(link: Link) -> dict[str, Any]:
    return {
        "name": link.name,
        **_inertial(link.inertial),
        "given": link.given is not None,
        "cad": {"path": list(link.path)} if link.path or link.parts else None,
        "parts": [_part(part) for part in link.parts],
        "shapes": [_shape(shape) for shape in link.shapes],
    }


def primitive_record(shape: Primitive) -> dict[str, Any]:
    """Kind, size and pose."""
    return {
        "kind": shape.kind,
        "size": [as_float(length) for length in shape.size],
        "pose": as_pose(shape.link_from_shape),
    }


def colour_record(colour: tuple[float, ...] | None) -> list[float | None] | None:
    return None if colour is None else [as_float(part) for part in colour]


def _inertial(inertial: Inertial) -> dict[str, Any]:
    return {
        "mass": as_float(inertial.mass),
        "com": as_floats(inertial.com, LENGTH),
        "inertia": as_floats(inertial.inertia),
    }


def _part(part: Part) -> dict[str, Any]:
    mirrored = bool(np.linalg.det(part.link_from_part[:3, :3]) < 0)
    return {
        "name": part.name,
        "path": list(part.path),
        "part": part.part_id,
        **_inertial(part.inertial),
        "volume": as_float(part.volume),
        "pose": _part_pose(part.link_from_part, mirrored),
        "mirrored": mirrored,
        "world": _part_pose(part.world_from_part, mirrored),
        "visual": part.seen,
        "collision": part.collides,
        "standard": part.standard,
        "estimated": part.estimated,
    }


def _part_pose(pose: Array, mirrored: bool) -> dict[str, Any]:
    return as_pose(pose @ np.diag([1.0, 1.0, -1.0, 1.0]) if mirrored else pose)


def _shape(shape: Primitive) -> dict[str, Any]:
    return {
        **primitive_record(shape),
        "colour": colour_record(shape.colour),
        "visual": shape.visual,
        "collision": shape.collision,
    }
