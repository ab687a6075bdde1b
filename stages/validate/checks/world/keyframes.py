"""Checks the keyframes: the saved pose as `cad`, where loops and relations hold, `home`, and the user's
own."""

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import joint_index
from linkwright.stages.mujoco.state import at_keyframe, at_keyframe_index, keyframe_index
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Configuration, Robot
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.start_pose import HOME, SAVED, keyframes
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import few, largest_error, named, shown, worst_first
from linkwright.stages.validate.model.coordinates import (
    ENGINE_TOLERANCE,
    distance,
    joints_of,
    link_pose,
    root_pose,
)
from linkwright.stages.validate.model.equalities import LOOP_TOLERANCE, open_equalities, violation
from linkwright.stages.validate.read.compiled import read_compiled
from linkwright.stages.validate.same.motion import kinematic_differences

USER_MEANING = "the pose nearest to `home` with the values that the configuration gives"
MEANINGS = {
    HOME: "the pose nearest to the saved one within the limits, or with the values that are given",
    SAVED: "the saved pose",
}
"""Keyframe → the pose that it must have, for messages; the others have `USER_MEANING`."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Checks the MJCF or the scene that has the robot's keyframes."""
    if compiled.urdf or not compiled.model.nq or not compiled.has_keyframes:
        return
    yield from (_keyframe_check(compiled, name, pose) for name, pose in keyframes(compiled.robot).items())
    yield _rest_check(compiled)
    if keyframe_index(compiled.model, SAVED) >= 0:
        yield _closed_check(compiled)


def _rest_check(compiled: CompiledModel) -> Check:
    """Checks that nothing moves in the robot's keyframes."""
    model, findings = compiled.model, list[Finding]()
    for name in keyframes(compiled.robot):
        key = keyframe_index(model, name)
        for at in np.flatnonzero(model.key_qvel[key]) if key >= 0 and not compiled.sets("qvel") else ():
            joint = model.joint(int(model.dof_jntid[at])).name
            message = f"moves {joint} at {shown(model.key_qvel[key][at])}, expected 0"
            findings.append(Finding(named("key", name), "qvel", message))
    moving = list(dict.fromkeys(finding.element for finding in findings))
    detail = f"something moves in {', '.join(moving)}" if moving else "nothing moves in the keyframes"
    return compiled.within("keyframes at rest", float(len(findings)), 0.0, detail, few(findings))


def _keyframe_check(compiled: CompiledModel, name: str, pose: Configuration) -> Check:
    """Compares the values and links at a keyframe with the robot's."""
    model = compiled.model
    key = keyframe_index(model, name)
    if key < 0:
        missing = Finding(named("key", name), "name", "there is no keyframe of this name")
        detail = f"there is no keyframe {name}"
        return compiled.result(f"keyframe {name}", False, detail, findings=(missing,))
    data = at_keyframe_index(model, key)
    mujoco.mj_kinematics(model, data)
    difference = _difference(model, data, compiled.robot, pose)
    detail = f"values and links against {MEANINGS.get(name, USER_MEANING)}"
    findings = () if difference <= ENGINE_TOLERANCE else _findings(compiled, key, name, pose)
    return compiled.within(f"keyframe {name}", difference, ENGINE_TOLERANCE, detail, findings)


def _findings(compiled: CompiledModel, key: int, name: str, pose: Configuration) -> tuple[Finding, ...]:
    """Returns findings on the joints whose values differ in the keyframe; if none does, on the links."""
    model, differences = compiled.model, []
    for joint, _, dof in joints_of(compiled.robot, urdf=False):
        value = pose[dof.name]
        if isinstance(value, tuple):
            continue
        position = float(model.key_qpos[key][model.jnt_qposadr[joint_index(model, joint)]])
        if not abs(position - value) <= ENGINE_TOLERANCE:
            message = f"puts {joint} at {shown(position)}, expected {shown(value)}"
            differences.append((abs(position - value), Finding(named("key", name), "qpos", message)))
    return (
        worst_first(differences)
        or kinematic_differences(read_compiled(compiled))
        or (_unnamed_difference(name),)
    )


def _unnamed_difference(name: str) -> Finding:
    """Returns the finding on a keyframe whose difference is in no scalar joint and in no link."""
    return Finding(named("key", name), "qpos", "puts a ball or a free body elsewhere than the robot's pose")


def _closed_check(compiled: CompiledModel) -> Check:
    model, data = compiled.model, at_keyframe(compiled.model, SAVED)
    mujoco.mj_forward(model, data)
    detail = "loops and relations in the saved pose, distance from closed [m, rad]"
    equalities = open_equalities(model, data)
    return compiled.within(
        f"closed in keyframe {SAVED}", violation(model, data), LOOP_TOLERANCE, detail, equalities
    )


def _difference(model: Any, data: Any, robot: Robot, pose: Configuration) -> float:
    """Returns the largest difference from the configuration `pose`, of values [rad, m] and links [m, rad]."""
    scalars = [(name, pose[dof.name]) for name, _, dof in joints_of(robot, urdf=False)]
    differences = [
        abs(float(data.qpos[model.jnt_qposadr[joint_index(model, name)]]) - value)
        for name, value in scalars
        if not isinstance(value, tuple)
    ]
    root_from_world = inverse(root_pose(model, data, robot))
    for name, expected in link_poses(robot, pose).items():
        differences.append(distance(root_from_world @ link_pose(model, data, robot, name), expected))
    return largest_error(differences)
