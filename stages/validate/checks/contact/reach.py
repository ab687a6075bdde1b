"""Checks that no two links collide while a single joint moves over its whole range.

The other joints stay at `home`, except those that follow by a relation or a closed loop. Links that touch at
`home` already are ignored.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.robot.check import Check, Finding, Table
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.model.coordinates import HINGE, set_values
from linkwright.stages.validate.model.equality_solver import EqualitySolver, swept_joints

STEPS = 24
"""Number of values of a joint from one end of its range to the other, in addition to `home`."""

MAX_BODY_POSES = 4_000_000
"""Largest product of bodies and poses: robots with more than 400 joints are swept in fewer steps, and of
robots with some thousands only a part of the joints is swept."""

MIN_STEPS = 4
"""Smallest number of steps over a joint's range."""

BodyPair = tuple[int, int]
"""The indices of two bodies, the smaller first."""

MIN_DEPTH = 5e-4
"""Depth [m] below which links that overlap only touch."""

WHOLE_TURN = 2.0 * np.pi

MAX_SLIDE_LIMIT = 1e3
"""Slide limits beyond this [m] count as unlimited."""

HEADER = ("joint", "link", "other link", "from, rad or m", "deepest at, rad or m", "depth, mm")


@dataclass(slots=True)
class LinkCollision:
    """The values of a joint at which two links collide."""

    first: float
    """The first such value [rad or m] on the way from `home`."""

    deepest: float
    """The value [rad or m] of the deepest overlap."""

    depth: float
    """The depth [m] of the deepest overlap."""


CollisionsByEnd = dict[tuple[BodyPair, float], LinkCollision]
"""(pair of bodies, end of the joint's range [rad or m]) → their collision on the way to that end."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Sweeps the joints of robots with colliders. Free bases, balls and slides without limits have no range,
    and are not swept."""
    model = compiled.model
    if not np.any(model.geom_contype) and not np.any(model.geom_conaffinity):
        return
    data = mujoco.MjData(model)
    set_values(model, data, compiled.robot, home(compiled.robot), urdf=False)
    start = data.qpos.copy()
    mujoco.mj_collision(model, data)
    overlaps_at_home = _overlaps(model, data)
    solver = EqualitySolver(model)
    swept = swept_joints(model, start)
    rows: list[tuple[str | float, ...]] = []
    findings: list[tuple[float, Finding]] = []
    poses = 0
    joints, steps = _joints_and_steps(swept, model.nbody)
    for joint in joints:
        collisions, pose_count = _sweep(model, data, solver, start, joint, set(overlaps_at_home), steps)
        poses += pose_count
        for (pair, _), collision in sorted(collisions.items()):
            rows.append(_row(model, joint, pair, collision))
            findings.append((-collision.depth, _finding(model, joint, pair, collision)))
    if not joints:
        return
    deepest_first = tuple(finding for _, finding in sorted(findings, key=lambda row: row[0]))
    joints_swept = count(len(joints), "joint") + (f" of {len(swept)}" if len(swept) > len(joints) else "")
    detail = f"{joints_swept} over its range, {poses} poses: no links run into each other"
    if deepest_first:
        detail = f"{count(len(deepest_first), 'collision')} of links over the ranges of {joints_swept}"
    summary = compiled.within("reach", float(len(deepest_first)), 0.0, detail, deepest_first, "warning")
    yield replace(summary, table=Table(HEADER, tuple(rows)) if rows else None)


def _row(model: Any, joint: int, pair: BodyPair, collision: LinkCollision) -> tuple[str | float, ...]:
    """Returns a row of the table (see `HEADER`)."""
    values = round(collision.first, 4), round(collision.deepest, 4), round(1e3 * collision.depth, 3)
    return (model.joint(joint).name, *(model.body(body).name for body in pair), *values)


def _finding(model: Any, joint: int, pair: BodyPair, collision: LinkCollision) -> Finding:
    first, second = (model.body(body).name for body in pair)
    name = model.joint(joint).name
    unit = "rad" if model.jnt_type[joint] == HINGE else "m"
    message = (
        f"{first} and {second} collide when {name} is at {collision.first:.3g} {unit}, by "
        f"{1e3 * collision.depth:.2g} mm at {collision.deepest:.3g}"
    )
    return Finding(named("joint", name), "range", message)


def _joints_and_steps(joints: list[int], bodies: int) -> tuple[list[int], int]:
    """Returns the joints to sweep, and the number of steps for each, as `MAX_BODY_POSES` allows. Of thousands
    of joints it returns an even sample."""
    poses = max(MIN_STEPS, MAX_BODY_POSES // bodies)
    steps = max(MIN_STEPS, min(STEPS, poses // max(1, len(joints))))
    return joints[:: math.ceil(len(joints) * steps / poses) or 1], steps


def _sweep(
    model: Any,
    data: Any,
    solver: EqualitySolver,
    start: Array,
    joint: int,
    ignored: set[BodyPair],
    steps: int,
) -> tuple[CollisionsByEnd, int]:
    """Sweeps a joint from its value in the pose `start` (nq,), whose equalities are closed, to the low end
    and to the high end of its range. Returns the collisions, and the number of poses. Each way ends early at
    a value for which the equalities cannot be closed. `ignored`: pairs of bodies whose overlaps do not
    count."""
    collisions: CollisionsByEnd = {}
    value = start[model.jnt_qposadr[joint]]
    low, high = _range(model, joint, value)
    # From a value outside the range it is farther to an end than the range is wide.
    step = max(high - low, high - value, value - low, 1e-12) / steps
    pose_count = 0
    for end in (low, high):
        pose = start
        # Rounding must not add a step.
        for joint_value in np.linspace(value, end, math.ceil(abs(end - value) / step - 1e-6) + 1)[1:]:
            next_pose = solver.solve(joint, float(joint_value), pose)
            if next_pose is None:
                break
            pose, pose_count = next_pose, pose_count + 1
            data.qpos[:] = pose
            mujoco.mj_kinematics(model, data)
            mujoco.mj_collision(model, data)
            for pair, depth in _overlaps(model, data).items():
                if pair in ignored:
                    continue
                first = LinkCollision(float(joint_value), float(joint_value), depth)
                collision = collisions.setdefault((pair, float(end)), first)
                if depth > collision.depth:
                    collision.depth, collision.deepest = depth, float(joint_value)
    return collisions, pose_count


def _range(model: Any, joint: int, value: float) -> tuple[float, float]:
    """Returns the ends between which a joint is swept. A missing limit is written as a huge number: a hinge
    is then swept by at most one turn, and a slide not at all, towards that limit."""
    low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (value - np.pi, value + np.pi)
    if model.jnt_type[joint] == HINGE:
        return max(low, value - WHOLE_TURN), min(high, value + WHOLE_TURN)
    low = low if low > value - MAX_SLIDE_LIMIT else value
    high = high if high < value + MAX_SLIDE_LIMIT else value
    return low, high


def _overlaps(model: Any, data: Any) -> dict[BodyPair, float]:
    """Maps the pairs of bodies that overlap to their depth [m]."""
    depths: dict[BodyPair, float] = {}
    contacts = data.contact
    overlaps = np.flatnonzero(contacts.dist < -MIN_DEPTH)
    bodies = np.sort(model.geom_bodyid[contacts.geom[overlaps]], axis=1)
    for pair, depth in zip(map(tuple, bodies.tolist()), -contacts.dist[overlaps], strict=True):
        depths[pair] = max(float(depth), depths.get(pair, 0.0))
    return depths
