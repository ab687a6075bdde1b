"""Poses as MJCF attributes."""

from stages.formats.numbers import LENGTH, spaced
from stages.robot.model import Array
from stages.robot.poses import quat_from_rotation


def placement(pose: Array) -> dict[str, str]:
    """`pos` and `quat` of a (4, 4) pose; identity is left out."""
    out = {}
    position = spaced(pose[:3, 3], least=LENGTH)
    if position != "0 0 0":
        out["pos"] = position
    return out | orientation(pose[:3, :3])


def orientation(rotation: Array) -> dict[str, str]:
    """`quat` of a (3, 3) rotation; identity is left out."""
    quat = spaced(quat_from_rotation(rotation))
    return {} if quat == "1 0 0 0" else {"quat": quat}
