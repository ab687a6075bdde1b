"""Where the scene puts the robot."""

from typing import TYPE_CHECKING

import numpy as np

from stages.robot.model import Array
from stages.robot.poses import from_parts, rotation_from_rpy

if TYPE_CHECKING:
    from stages.export.keys import ExportKeys


def scene_pose(keys: "ExportKeys") -> Array:
    """world_from_root (4, 4): where the scene puts the robot."""
    return from_parts(rotation_from_rpy(keys.scene.pose.rpy), np.array(keys.scene.pose.xyz))
