"""Whether a compiled model moves as the robot does: joints, limits, relations, frames, keyframes.

The robot's own kinematics is the measure: it is what was held against CAD at the saved pose.
"""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from stages.robot.check import Check
from stages.robot.kinematics import link_poses, saved_configuration
from stages.robot.model import Array, Joint, Robot
from stages.robot.poses import inverse

CLOSE = 1e-9
"""Poses [m, rad] and joint values [rad, m] that two engines compute from the same numbers."""

KINDS = {"revolute": mujoco.mjtJoint.mjJNT_HINGE, "prismatic": mujoco.mjtJoint.mjJNT_SLIDE}


def check_motion(file: str, model: Any, robot: Robot) -> Iterator[Check]:
    """All checks of how one model moves; every link and joint must be there by name."""
    urdf = file.endswith(".urdf")
    yield _joints(file, model, robot, urdf)
    yield _sweep(file, model, robot)
    yield _relations(file, model, robot)
    if not urdf:
        yield _loops(file, model, robot)
        yield from _keyframe(file, model, robot)


def joint_index(model: Any, name: str) -> int:
    return int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name))


def set_joints(model: Any, data: Any, q: Mapping[str, float]) -> None:
    """Resets, sets joint values by name and computes poses."""
    mujoco.mj_resetData(model, data)
    for name, value in q.items():
        data.qpos[model.jnt_qposadr[joint_index(model, name)]] = value
    mujoco.mj_kinematics(model, data)


def pose_of(data: Any, body: int) -> Array:
    pose = np.eye(4)
    pose[:3, :3] = data.xmat[body].reshape(3, 3)
    pose[:3, 3] = data.xpos[body]
    return pose


def body_index(model: Any, name: str) -> int:
    return int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name))


def distance(found: Array, expected: Array) -> float:
    """The larger of the offset [m] and the turn [rad, for small ones] between two poses (4, 4)."""
    off = found - expected
    return max(math.hypot(*off[:3, 3]), float(np.linalg.norm(off[:3, :3])) / math.sqrt(2))


def _joints(file: str, model: Any, robot: Robot, urdf: bool) -> Check:
    """Type and limits of each joint. A URDF may bound what nobody bounded: it must."""
    wrong = []
    for joint in robot.joints:
        index = joint_index(model, joint.name)
        low, high = model.jnt_range[index]
        sides = ((joint.limits.lower, low, -1), (joint.limits.upper, high, 1))
        limited = any(side is not None for side, *_ in sides)
        fits = model.jnt_type[index] == KINDS[joint.type] and (urdf or model.jnt_limited[index] == limited)
        fits &= all(
            side is None or abs(side - value) <= CLOSE * max(1, abs(side)) for side, value, _ in sides
        )
        fits &= not limited or all(_open(value, sign, urdf) for side, value, sign in sides if side is None)
        effort = joint.dynamics.effort
        fits &= effort is None or abs(model.jnt_actfrcrange[index][1] - effort) <= CLOSE * effort
        if not fits:
            wrong.append(joint.name)
    detail = f"differ: {', '.join(wrong)}" if wrong else "type, limits and effort of each joint"
    return Check(f"{file}: joints", not wrong, detail, float(len(wrong)), 0.0)


def _open(value: float, sign: int, urdf: bool) -> bool:
    return urdf or value * sign >= 1e6


def _sweep(file: str, model: Any, robot: Robot) -> Check:
    """Every link and frame at configurations spread over the joints' values, relative to the root."""
    data = mujoco.MjData(model)
    worst, where = 0.0, ""
    for turn in range(3):
        # An irrational step spreads the values evenly and the same way every time.
        q = {
            j.name: 3 * math.modf((turn * len(robot.joints) + i + 1) * math.e)[0] - 1.5
            for i, j in enumerate(robot.joints)
        }
        set_joints(model, data, q)
        root_from_world = inverse(pose_of(data, body_index(model, robot.root.name)))
        expected = link_poses(robot, q)
        found = {name: pose_of(data, body_index(model, name)) for name in expected}
        for frame in robot.frames:
            expected[frame.name] = expected[frame.link] @ frame.link_from_frame
            found[frame.name] = _frame(model, data, frame.name)
        for name, pose in expected.items():
            value = distance(root_from_world @ found[name], pose)
            if not value < worst:
                worst, where = value, name
    detail = f"links and frames at three configurations against the robot's own kinematics; worst: {where}"
    return Check(f"{file}: motion", worst <= CLOSE, detail, worst, CLOSE)


def _frame(model: Any, data: Any, name: str) -> Array:
    """A frame: a site, or in a URDF a body. NaN where there is neither."""
    site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, name)
    if site >= 0:
        pose = np.eye(4)
        pose[:3, :3] = data.site_xmat[site].reshape(3, 3)
        pose[:3, 3] = data.site_xpos[site]
        return pose
    body = body_index(model, name)
    return pose_of(data, body) if body >= 0 else np.full((4, 4), np.nan)


def _relations(file: str, model: Any, robot: Robot) -> Check:
    """Each relation is an equality of its two joints, with its numbers."""
    found = {}
    for index in np.flatnonzero(model.eq_type == mujoco.mjtEq.mjEQ_JOINT):
        pair = (int(model.eq_obj1id[index]), int(model.eq_obj2id[index]))
        found[pair] = model.eq_data[index][:5]
    wrong = []
    for relation in robot.relations:
        follower, driver = joint_index(model, relation.follower), joint_index(model, relation.driver)
        data = found.get((follower, driver))
        zero = [float(model.qpos0[model.jnt_qposadr[j]]) for j in (follower, driver)]
        constant = relation.multiplier * zero[1] + relation.offset - zero[0]
        expected = np.array([constant, relation.multiplier, 0, 0, 0])
        if data is None or np.abs(data - expected).max() > CLOSE * max(1.0, abs(relation.multiplier)):
            wrong.append(relation.name)
    surplus = len(found) - len(robot.relations)
    detail = (
        f"differ: {', '.join(wrong)}" if wrong else f"{len(robot.relations)} relations, with their numbers"
    )
    return Check(f"{file}: relations", not wrong and surplus == 0, detail, float(len(wrong)), 0.0)


def _loops(file: str, model: Any, robot: Robot) -> Check:
    """Each loop is held by two points on its axis."""
    held: dict[frozenset[int], int] = {}
    for index in np.flatnonzero(model.eq_type == mujoco.mjtEq.mjEQ_CONNECT):
        sites = (int(model.eq_obj1id[index]), int(model.eq_obj2id[index]))
        pair = frozenset(int(model.site_bodyid[site]) for site in sites)
        held[pair] = held.get(pair, 0) + 1
    wanted: dict[frozenset[int], int] = {}
    for loop in robot.loops:
        pair = frozenset(body_index(model, name) for name in (loop.link_a, loop.link_b))
        wanted[pair] = wanted.get(pair, 0) + 2
    detail = f"{len(robot.loops)} loops, each held by two points on its axis"
    return Check(
        f"{file}: loops", held == wanted, detail, float(abs(sum(held.values()) - sum(wanted.values()))), 0.0
    )


def _keyframe(file: str, model: Any, robot: Robot) -> Iterator[Check]:
    """The keyframe `cad` is the saved pose, and every loop and relation holds there."""
    key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, "cad")
    if key < 0:
        if robot.joints:
            yield Check(f"{file}: keyframe cad", False, "there is no keyframe cad")
        return
    saved = saved_configuration(robot)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, key)
    off = max((abs(_value(model, data, joint) - saved[joint.name]) for joint in robot.joints), default=0.0)
    yield Check(f"{file}: keyframe cad", off <= CLOSE, "joint values against the saved pose", off, CLOSE)
    mujoco.mj_forward(model, data)
    rows = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
    open_by = float(np.abs(data.efc_pos[rows]).max(initial=0.0))
    limit = 1e-6
    yield Check(
        f"{file}: closed in keyframe cad",
        open_by <= limit,
        "loops and relations hold in the saved pose [m, rad]",
        open_by,
        limit,
    )


def _value(model: Any, data: Any, joint: Joint) -> float:
    return float(data.qpos[model.jnt_qposadr[joint_index(model, joint.name)]])
