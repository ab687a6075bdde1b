"""The keyframes: the saved pose as `cad`, where loops and relations hold, `home`, and the user's own."""

from collections.abc import Iterator
from typing import Any

import mujoco

from stages.robot.check import Check
from stages.robot.kinematics import link_poses
from stages.robot.model import Configuration, Robot
from stages.robot.poses import inverse
from stages.robot.start_pose import HOME, SAVED, keyframes
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

CODE = "C-KEYFRAME"

OWN = "the pose nearest to `home` with the values that the configuration gives"
MEANINGS = {
    HOME: "the pose nearest to the saved one within the limits, or with the values that are given",
    SAVED: "the saved pose",
}


def check(compiled: CompiledModel) -> Iterator[Check]:
    if compiled.urdf or not compiled.model.nq:
        return
    yield from (_keyframe(compiled, name, pose) for name, pose in keyframes(compiled.robot).items())
    if mujoco.mj_name2id(compiled.model, mujoco.mjtObj.mjOBJ_KEY, SAVED) >= 0:
        yield _closed(compiled)


def _keyframe(compiled: CompiledModel, name: str, pose: Configuration) -> Check:
    """The values and links of one keyframe against those that the robot says."""
    model = compiled.model
    key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, name)
    if key < 0:
        return compiled.result(f"keyframe {name}", False, f"there is no keyframe {name}")
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, key)
    mujoco.mj_kinematics(model, data)
    off = _difference(model, data, compiled.robot, pose)
    return compiled.within(
        f"keyframe {name}", off, SAME, f"values and links against {MEANINGS.get(name, OWN)}"
    )


def _closed(compiled: CompiledModel) -> Check:
    model, data = compiled.model, mujoco.MjData(compiled.model)
    mujoco.mj_resetDataKeyframe(model, data, mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, SAVED))
    mujoco.mj_forward(model, data)
    detail = "loops and relations in the saved pose, distance from closed [m, rad]"
    return compiled.within(f"closed in keyframe {SAVED}", violation(model, data), CLOSED, detail)


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
