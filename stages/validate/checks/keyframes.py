"""The keyframe `cad` is the saved pose, where loops and relations hold; `home` is the same within limits."""

import math
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from stages.robot.check import Check
from stages.robot.kinematics import link_poses, saved_configuration
from stages.robot.model import Array, Robot
from stages.robot.poses import inverse
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import (
    SAME,
    distance,
    every_saved,
    joint_index,
    joints_of,
    link_pose,
    root_pose,
)
from stages.validate.equalities import CLOSED, violation


def check(compiled: CompiledModel) -> Iterator[Check]:
    model = compiled.model
    if compiled.urdf:
        return
    key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, "cad")
    if key < 0:
        if model.nq:
            yield compiled.result("keyframe cad", False, "there is no keyframe cad")
        return
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, key)
    mujoco.mj_kinematics(model, data)
    off = _difference(model, data, compiled.robot)
    yield compiled.within("keyframe cad", off, SAME, "values and links against the saved pose")
    yield _home(compiled, data.qpos)
    mujoco.mj_forward(model, data)
    detail = "loops and relations in the saved pose, distance from closed [m, rad]"
    yield compiled.within("closed in keyframe cad", violation(model, data), CLOSED, detail)


def _home(compiled: CompiledModel, cad: Array) -> Check:
    """The keyframe `home` is the keyframe `cad`, clipped to the limits."""
    model = compiled.model
    expected = np.array(cad)
    for index in np.flatnonzero(model.jnt_limited):
        at = model.jnt_qposadr[index]
        expected[at] = np.clip(expected[at], *model.jnt_range[index])
    key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, "home")
    off = float(np.abs(model.key_qpos[key] - expected).max(initial=0.0)) if key >= 0 else math.inf
    return compiled.within("keyframe home", off, SAME, "values against the saved pose, clipped to the limits")


def _difference(model: Any, data: Any, robot: Robot) -> float:
    """The largest difference from the saved pose: of values [rad, m] and of links [m, rad]."""
    saved = every_saved(robot)
    scalars = [(name, saved[dof.name]) for name, _, dof in joints_of(robot, urdf=False)]
    off = [
        abs(float(data.qpos[model.jnt_qposadr[joint_index(model, name)]]) - value)
        for name, value in scalars
        if not isinstance(value, tuple)
    ]
    root_from_world = inverse(root_pose(model, data, robot))
    for name, pose in link_poses(robot, saved_configuration(robot)).items():
        off.append(distance(root_from_world @ link_pose(model, data, robot, name), pose))
    return max(off, default=0.0)
