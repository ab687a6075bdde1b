"""Poses as MJCF attributes."""

from typing import TYPE_CHECKING

import numpy as np

from stages.formats.numbers import spaced
from stages.robot.model import Array
from stages.robot.poses import from_parts, quat_from_rotation, rotation_from_rpy

if TYPE_CHECKING:
    from stages.export.keys import ExportKeys


def placement(pose: Array) -> dict[str, str]:
    """`pos` and `quat` of a (4, 4) pose; identity is left out."""
    out = {}
    position = spaced(pose[:3, 3])
    if position != "0 0 0":
        out["pos"] = position
    quat = spaced(quat_from_rotation(pose[:3, :3]))
    if quat != "1 0 0 0":
        out["quat"] = quat
    return out


def scene_pose(keys: "ExportKeys") -> Array:
    """world_from_root (4, 4): where the scene puts the robot."""
    return from_parts(rotation_from_rpy(keys.scene.pose.rpy), np.array(keys.scene.pose.xyz))
