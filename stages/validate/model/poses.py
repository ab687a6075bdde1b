"""Converts MuJoCo's quaternions and positions to rotations and poses."""

import mujoco
import numpy as np

from linkwright.stages.robot.model.poses import from_parts
from linkwright.stages.robot.model.robot import Array


def rotation(quat: Array) -> Array:
    """Returns the rotation (3, 3) of MuJoCo's quaternion (w, x, y, z)."""
    flat = np.empty(9)
    mujoco.mju_quat2Mat(flat, np.array(quat))
    return flat.reshape(3, 3)


def placed(quat: Array, position: Array) -> Array:
    """Returns the pose (4, 4) of MuJoCo's quaternion and position."""
    return from_parts(rotation(quat), position)
