"""Checks that the robot is where the build put it: its root, and the free base in each keyframe."""

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import body_index
from linkwright.stages.mujoco.state import keyframe_index
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import (
    few,
    largest_error,
    link,
    named,
    offset_and_angle,
    pose_findings,
    shown,
)
from linkwright.stages.validate.model.coordinates import CAD_ERROR, FREE, ORIENTATIONS, root_pose
from linkwright.stages.validate.model.poses import placed


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Compares the placement; yields nothing if the robot's scene is unknown."""
    if compiled.written.scene is None:
        return
    expected, root = compiled.written.scene.world_from_root, compiled.robot.root.name
    yield _at_start(compiled, root, expected)
    if not compiled.robot.base.fixed and not compiled.sets("qpos") and compiled.has_keyframes:
        yield from _in_keyframes(compiled, root, compiled.written.scene.keyframes)


def _at_start(compiled: CompiledModel, root: str, expected: Array) -> Check:
    """Compares the root at the start, where its pose is that of the file. Attributes that the user's own XML
    sets are not compared."""
    model, data = compiled.model, mujoco.MjData(compiled.model)
    mujoco.mj_kinematics(model, data)
    pose = root_pose(model, data, compiled.robot)
    has_body = body_index(model, root) > 0
    element = link(root, urdf=False) if has_body else named("site", root)
    user_sets = compiled.sets_of(f"{'body' if has_body else 'site'} {root}")
    findings = [
        finding
        for finding in pose_findings(element, pose, expected, ("pos", "quat"), CAD_ERROR)
        if not user_sets & (ORIENTATIONS if finding.attribute == "quat" else {finding.attribute})
    ]
    offset, angle = offset_and_angle(pose, expected)
    errors = {"pos": offset, "quat": angle}
    value = largest_error(errors[finding.attribute] for finding in findings)
    detail = "the root against the pose that the build gave it [m, rad]"
    return compiled.within("placement", value, CAD_ERROR, detail, findings)


def _in_keyframes(
    compiled: CompiledModel, root: str, keyframes: Sequence[tuple[str, Array]]
) -> Iterator[Check]:
    """Compares the free base in every keyframe with the build's placement."""
    model, body = compiled.model, body_index(compiled.model, root)
    joint = int(model.body_jntadr[body]) if body > 0 and model.body_jntnum[body] else -1
    if joint < 0 or model.jnt_type[joint] != FREE:
        return
    address, worst, findings = int(model.jnt_qposadr[joint]), 0.0, []
    for name, expected in keyframes:
        key = keyframe_index(model, name)
        # The check of keyframes reports a missing keyframe.
        if key < 0:
            continue
        numbers = model.key_qpos[key][address : address + 7]
        pose = placed(numbers[3:], numbers[:3])
        offset, angle = offset_and_angle(pose, expected)
        worst = largest_error((worst, offset, angle))
        if not offset <= CAD_ERROR:
            message = f"puts {root} at {shown(pose[:3, 3])}, expected {shown(expected[:3, 3])} [m]"
            findings.append(Finding(named("key", name), "qpos", message))
        if not angle <= CAD_ERROR:
            message = f"turns {root} by {shown(np.degrees(angle))} degrees from the expected orientation"
            findings.append(Finding(named("key", name), "qpos", message))
    detail = "the free base in the keyframes against the pose that the build gave it [m, rad]"
    yield compiled.within("placement in keyframes", worst, CAD_ERROR, detail, few(findings))
