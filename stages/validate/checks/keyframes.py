"""The keyframe `cad` is the saved pose, where loops and relations hold; `home` the nearest within limits."""

import math
from collections.abc import Iterator
from typing import Any

import mujoco

from stages.robot.check import Check
from stages.robot.kinematics import link_poses
from stages.robot.model import Configuration, Robot
from stages.robot.poses import inverse
from stages.robot.start_pose import home, saved
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import (
    SAME,
    distance,
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
    off = _difference(model, data, compiled.robot, saved(compiled.robot))
    yield compiled.within("keyframe cad", off, SAME, "values and links against the saved pose")
    mujoco.mj_forward(model, data)
    detail = "loops and relations in the saved pose, distance from closed [m, rad]"
    closed = compiled.within("closed in keyframe cad", violation(model, data), CLOSED, detail)
    yield _home(compiled, data)
    yield closed


def _home(compiled: CompiledModel, data: Any) -> Check:
    """The keyframe `home` is the pose nearest to the saved one within the limits."""
    model = compiled.model
    key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, "home")
    detail = "values and links against the pose nearest to the saved one within the limits"
    if key < 0:
        return compiled.within("keyframe home", math.inf, SAME, detail)
    mujoco.mj_resetDataKeyframe(model, data, key)
    mujoco.mj_kinematics(model, data)
    off = _difference(model, data, compiled.robot, home(compiled.robot))
    return compiled.within("keyframe home", off, SAME, detail)


def _difference(model: Any, data: Any, robot: Robot, pose: Configuration) -> float:
    """The largest difference from the values `pose`: of values [rad, m] and of links [m, rad]."""
    scalars = [(name, pose[dof.name]) for name, _, dof in joints_of(robot, urdf=False)]
    off = [
        abs(float(data.qpos[model.jnt_qposadr[joint_index(model, name)]]) - value)
        for name, value in scalars
        if not isinstance(value, tuple)
    ]
    root_from_world = inverse(root_pose(model, data, robot))
    for name, expected in link_poses(robot, pose).items():
        off.append(distance(root_from_world @ link_pose(model, data, robot, name), expected))
    return max(off, default=0.0)
