"""Whether a compiled model moves as the robot does: joints, limits, relations, frames, keyframes.

The robot's own kinematics is the measure: it is what was held against CAD at the saved pose.
"""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from stages.formats.urdf.names import urdf_names
from stages.robot.check import Check
from stages.robot.kinematics import link_poses, rest_configuration, saved_configuration
from stages.robot.model import Array, Configuration, Dof, Robot
from stages.robot.poses import inverse
from stages.validate.checks.loops import check_loops, unmet
from stages.validate.engines.ability import mimics, reads_mimic
from stages.validate.engines.coordinates import (
    body_index,
    distance,
    every_saved,
    joint_index,
    joints_of,
    link_pose,
    pose_of,
    root_pose,
    set_values,
    site_index,
    site_pose,
    spread,
)

CLOSE = 1e-9
"""Poses [m, rad] and joint values [rad, m] that two engines compute from the same numbers."""


def check_motion(path: Path, model: Any, robot: Robot) -> Iterator[Check]:
    """All checks of how one file's model moves; every link and joint must be there by name."""
    file, urdf = path.name, path.suffix == ".urdf"
    yield _joints(file, model, robot, urdf)
    yield _sweep(file, model, robot, urdf)
    by_text = urdf and not reads_mimic()
    yield _relations(file, model, robot, mimics(model, path.read_bytes()) if by_text else _related(model))
    if not urdf:
        yield from check_loops(file, model, robot)
        yield from _keyframe(file, model, robot)


def _joints(file: str, model: Any, robot: Robot, urdf: bool) -> Check:
    """Type, limits and dynamics of each joint. A URDF may bound what nobody bounded: it must."""
    wrong = []
    for name, kind, dof in joints_of(robot, urdf):
        index = joint_index(model, name)
        fits = model.jnt_type[index] == kind
        if dof.kind in ("ball", "free"):
            # A ball's cone is written nowhere, nor the three turns' limits that it is not.
            fits &= not model.jnt_limited[index]
        else:
            fits &= _bounded(model, index, dof, urdf)
        if dof.kind != "free":
            fits &= _resists(model, index, dof, urdf)
        if not fits:
            wrong.append(name)
    detail = f"differ: {', '.join(wrong)}" if wrong else "type, limits, effort and dynamics of each joint"
    return Check(f"{file}: joints", not wrong, detail, float(len(wrong)), 0.0)


def _bounded(model: Any, index: int, dof: Dof, urdf: bool) -> bool:
    """Whether a hinge or slide has the limits and effort of its dof."""
    low, high = model.jnt_range[index]
    sides = ((dof.limits.lower, low, -1), (dof.limits.upper, high, 1))
    limited = any(side is not None for side, *_ in sides)
    fits = urdf or model.jnt_limited[index] == limited
    fits &= all(side is None or abs(side - value) <= CLOSE * max(1, abs(side)) for side, value, _ in sides)
    fits &= not limited or all(_open(value, sign, urdf) for side, value, sign in sides if side is None)
    effort = dof.dynamics.effort
    fits &= effort is None or abs(model.jnt_actfrcrange[index][1] - effort) <= CLOSE * effort
    return bool(fits)


def _resists(model: Any, index: int, dof: Dof, urdf: bool) -> bool:
    """Whether a joint has the damping, friction and armature of its dof; URDF has no armature."""
    wanted, at = dof.dynamics, int(model.jnt_dofadr[index])
    pairs = [(wanted.damping, model.dof_damping), (wanted.friction, model.dof_frictionloss)]
    pairs += [] if urdf else [(wanted.armature, model.dof_armature)]
    return all(
        abs((value or 0.0) - float(found[at])) <= CLOSE * max(1.0, value or 0.0) for value, found in pairs
    )


def _open(value: float, sign: int, urdf: bool) -> bool:
    return urdf or value * sign >= 1e6


def _sweep(file: str, model: Any, robot: Robot, urdf: bool) -> Check:
    """Every link and frame at configurations spread over the dofs' values, relative to the root."""
    data = mujoco.MjData(model)
    worst, where = 0.0, ""
    if urdf:
        # Where nothing has moved: a floating joint's own numbers would hide its origin.
        mujoco.mj_kinematics(model, data)
        worst, where = _worst(model, data, robot, rest_configuration(robot), urdf)
    for turn in range(3):
        q = spread(robot, turn)
        set_values(model, data, robot, q, urdf)
        worst, where = max((worst, where), _worst(model, data, robot, q, urdf), key=lambda found: found[0])
    detail = f"links and frames at three configurations against the robot's own kinematics; worst: {where}"
    return Check(f"{file}: motion", worst <= CLOSE, detail, worst, CLOSE)


def _worst(model: Any, data: Any, robot: Robot, q: Configuration, urdf: bool) -> tuple[float, str]:
    """The largest difference of a link or frame from the robot's own kinematics, and which it is;
    infinite for one that is not there."""
    root_from_world = inverse(root_pose(model, data, robot))
    links = link_poses(robot, q)
    names = urdf_names(robot).frames if urdf else {}
    pairs = [(name, link_pose(model, data, robot, name), pose) for name, pose in links.items()]
    for frame in robot.frames:
        found = _frame(model, data, names.get(frame.name, frame.name), urdf)
        pairs.append((frame.name, found, links[frame.link] @ frame.link_from_frame))
    off = [(distance(root_from_world @ found, pose), name) for name, found, pose in pairs]
    return max(((math.inf if math.isnan(value) else value), name) for value, name in off)


def _frame(model: Any, data: Any, name: str, urdf: bool) -> Array:
    """A frame: a site, in a URDF a body. NaN where there is none."""
    index, pose = (body_index, pose_of) if urdf else (site_index, site_pose)
    found = index(model, name)
    return pose(data, found) if found >= 0 else np.full((4, 4), np.nan)


def _related(model: Any) -> dict[tuple[int, int], Array]:
    """By (follower, driver): the numbers of each equality of two joints."""
    joints = np.flatnonzero(model.eq_type == mujoco.mjtEq.mjEQ_JOINT)
    return {(int(model.eq_obj1id[one]), int(model.eq_obj2id[one])): model.eq_data[one][:5] for one in joints}


def _relations(file: str, model: Any, robot: Robot, found: Mapping[tuple[int, int], Array]) -> Check:
    """Each relation is among the `found` ones of its two joints, solved for either, with its numbers."""
    wrong = []
    for relation in robot.relations:
        driver, follower = joint_index(model, relation.driver), joint_index(model, relation.follower)
        y, x, factor, offset = follower, driver, relation.multiplier, relation.offset
        if (y, x) not in found and factor:
            y, x, factor, offset = x, y, 1 / factor, -offset / factor
        data = found.get((y, x))
        zero = [float(model.qpos0[model.jnt_qposadr[joint]]) for joint in (y, x)]
        expected = np.array([factor * zero[1] + offset - zero[0], factor, 0, 0, 0])
        if data is None or np.abs(data - expected).max() > CLOSE * max(1.0, abs(factor)):
            wrong.append(relation.name)
    surplus = len(found) - len(robot.relations)
    detail = (
        f"differ: {', '.join(wrong)}" if wrong else f"{len(robot.relations)} relations, with their numbers"
    )
    return Check(f"{file}: relations", not wrong and surplus == 0, detail, float(len(wrong)), 0.0)


def _keyframe(file: str, model: Any, robot: Robot) -> Iterator[Check]:
    """The keyframe `cad` is the saved pose, and every loop and relation holds there."""
    key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, "cad")
    if key < 0:
        if model.nq:
            yield Check(f"{file}: keyframe cad", False, "there is no keyframe cad")
        return
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, key)
    mujoco.mj_kinematics(model, data)
    off = _off(model, data, robot)
    yield Check(f"{file}: keyframe cad", off <= CLOSE, "values and links against the saved pose", off, CLOSE)
    yield _home(file, model, data.qpos)
    mujoco.mj_forward(model, data)
    open_by, limit = unmet(model, data), 1e-6
    yield Check(
        f"{file}: closed in keyframe cad",
        open_by <= limit,
        "loops and relations hold in the saved pose [m, rad]",
        open_by,
        limit,
    )


def _home(file: str, model: Any, cad: Array) -> Check:
    """The keyframe `home` is the keyframe `cad`, its joints taken into their limits."""
    expected = np.array(cad)
    for index in np.flatnonzero(model.jnt_limited):
        at = model.jnt_qposadr[index]
        expected[at] = np.clip(expected[at], *model.jnt_range[index])
    key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, "home")
    off = float(np.abs(model.key_qpos[key] - expected).max(initial=0.0)) if key >= 0 else math.inf
    detail = "values against the saved pose, taken into the limits"
    return Check(f"{file}: keyframe home", off <= CLOSE, detail, off, CLOSE)


def _off(model: Any, data: Any, robot: Robot) -> float:
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
