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

MIN_DEPTH = 5e-4
"""Depth [m] below which links that overlap only touch."""

TURN = 2.0 * np.pi
MAX_SLIDE_LIMIT = 1e3
"""Slide limits beyond this [m] count as unlimited."""

HEADER = ("joint", "link", "other link", "from, rad or m", "deepest at, rad or m", "depth, mm")


@dataclass(slots=True)
class Meeting:
    """The values of a joint at which two links collide."""

    first: float
    """The first such value [rad or m] on the way from `home`."""

    deepest: float
    """The value [rad or m] of the deepest overlap."""

    depth: float
    """The depth [m] of the deepest overlap."""


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
    at_home = _contacts(model, data)
    solver = EqualitySolver(model)
    rows, findings, poses, swept = [], [], 0, swept_joints(model, start)
    joints, steps = _within_reason(swept, model.nbody)
    for joint in joints:
        meetings, tried = _swept(model, data, solver, start, joint, set(at_home), steps)
        poses += tried
        name = model.joint(joint).name
        for (pair, _), meeting in sorted(meetings.items()):
            links = [model.body(body).name for body in pair]
            rows.append(
                (
                    name,
                    *links,
                    round(meeting.first, 4),
                    round(meeting.deepest, 4),
                    round(1e3 * meeting.depth, 3),
                )
            )
            unit = "rad" if model.jnt_type[joint] == HINGE else "m"
            text = (
                f"{links[0]} and {links[1]} collide when {name} is at {meeting.first:.3g} {unit}, by "
                f"{1e3 * meeting.depth:.2g} mm at {meeting.deepest:.3g}"
            )
            findings.append((-meeting.depth, Finding(named("joint", name), "range", text)))
    if not joints:
        return
    collisions = tuple(finding for _, finding in sorted(findings, key=lambda row: row[0]))
    joints_swept = count(len(joints), "joint") + (f" of {len(swept)}" if len(swept) > len(joints) else "")
    detail = f"{joints_swept} over its range, {poses} poses: no links run into each other"
    if collisions:
        detail = f"{count(len(collisions), 'collision')} of links over the ranges of {joints_swept}"
    result = compiled.within("reach", float(len(collisions)), 0.0, detail, collisions, "warning")
    yield replace(result, table=Table(HEADER, tuple(rows)) if rows else None)


def _within_reason(joints: list[int], bodies: int) -> tuple[list[int], int]:
    """Returns the joints to sweep and the number of steps for each, as `MAX_BODY_POSES` allows: of thousands
    of joints, an even sample."""
    poses = max(MIN_STEPS, MAX_BODY_POSES // bodies)
    steps = max(MIN_STEPS, min(STEPS, poses // max(1, len(joints))))
    return joints[:: math.ceil(len(joints) * steps / poses) or 1], steps


def _swept(
    model: Any,
    data: Any,
    solver: EqualitySolver,
    start: Array,
    joint: int,
    ignored: set[tuple[int, int]],
    steps: int,
) -> tuple[dict[tuple[tuple[int, int], float], Meeting], int]:
    """Sweeps a joint from its value in the pose `start` (nq,), whose equalities are closed, to the low end
    and to the high end of its range. Returns the collisions by pair of bodies and end of the range, and the
    number of poses tried."""
    meetings: dict[tuple[tuple[int, int], float], Meeting] = {}
    value = start[model.jnt_qposadr[joint]]
    low, high = _range(model, joint, value)
    step, tried = max(high - low, 1e-12) / steps, 0
    for end in (low, high):
        pose = start
        # Rounding must not add a step.
        for at in np.linspace(value, end, math.ceil(abs(end - value) / step - 1e-6) + 1)[1:]:
            next_pose = solver.solve(joint, float(at), pose)
            if next_pose is None:
                break
            pose, tried = next_pose, tried + 1
            data.qpos[:] = pose
            mujoco.mj_kinematics(model, data)
            mujoco.mj_collision(model, data)
            for pair, depth in _contacts(model, data).items():
                if pair in ignored:
                    continue
                meeting = meetings.setdefault((pair, float(end)), Meeting(float(at), float(at), depth))
                if depth > meeting.depth:
                    meeting.depth, meeting.deepest = depth, float(at)
    return meetings, tried


def _range(model: Any, joint: int, value: float) -> tuple[float, float]:
    """Returns the ends between which a joint is swept. A missing limit is written as a huge number: a hinge
    is then swept by at most one turn, and a slide not at all, towards that limit."""
    low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (value - np.pi, value + np.pi)
    if model.jnt_type[joint] == HINGE:
        return max(low, value - TURN), min(high, value + TURN)
    return (low if low > value - MAX_SLIDE_LIMIT else value), (
        high if high < value + MAX_SLIDE_LIMIT else value
    )


def _contacts(model: Any, data: Any) -> dict[tuple[int, int], float]:
    """Maps the pairs of bodies that overlap to their depth [m]."""
    depths: dict[tuple[int, int], float] = {}
    contacts = data.contact
    overlaps = np.flatnonzero(contacts.dist < -MIN_DEPTH)
    bodies = np.sort(model.geom_bodyid[contacts.geom[overlaps]], axis=1)
    for pair, depth in zip(map(tuple, bodies.tolist()), -contacts.dist[overlaps], strict=True):
        depths[pair] = max(float(depth), depths.get(pair, 0.0))
    return depths
