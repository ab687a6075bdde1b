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
    quat = spaced(quat_from_rotation(pose[:3, :3]))
    if quat != "1 0 0 0":
        out["quat"] = quat
    return out
