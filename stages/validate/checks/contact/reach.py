"""Each joint moves over its whole range, alone, without two links running into each other.

The other joints stay at `home`, but for those that follow by a relation or a closed loop. What touches at
`home` already is no finding here.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.robot.check import Check, Finding, Table
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.model.coordinates import HINGE, set_values
from linkwright.stages.validate.model.following import Follower, swept_joints

STEPS = 24
"""Values of a joint from one end of its range to the other, besides `home`."""

PLACED = 4_000_000
"""The most bodies times poses: of a robot of more than 400 joints each is looked at in fewer steps, and of
some thousands not every joint."""

FEWEST = 4
"""Steps over a joint's range."""

DEEP = 5e-4
"""Links that are in each other by less [m] touch."""

TURN = 2.0 * np.pi
OPEN = 1e3
"""A slide's limit that is further [m] is none."""

HEADER = ("joint", "link", "other link", "from, rad or m", "deepest at, rad or m", "depth, mm")


@dataclass(slots=True)
class Meeting:
    """Two links that a joint's motion brings together: at which value [rad, m] first, going out from `home`,
    and where they are deepest in each other [m]."""

    first: float
    deepest: float
    depth: float


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Of a robot that collides. A free base, a ball and a slide without limits have no range."""
    model = compiled.model
    if not np.any(model.geom_contype) and not np.any(model.geom_conaffinity):
        return
    data = mujoco.MjData(model)
    set_values(model, data, compiled.robot, home(compiled.robot), urdf=False)
    start = data.qpos.copy()
    mujoco.mj_collision(model, data)
    meeting = _contacts(model, data)
    follower = Follower(model, start)
    rows, findings, poses, every = [], [], 0, swept_joints(model, start)
    joints, steps = _within_reason(every, model.nbody)
    for joint in joints:
        found, tried = _swept(model, data, follower, joint, set(meeting), steps)
        poses += tried
        name = model.joint(joint).name
        for (pair, _), one in sorted(found.items()):
            links = [model.body(body).name for body in pair]
            rows.append((name, *links, round(one.first, 4), round(one.deepest, 4), round(1e3 * one.depth, 3)))
            unit = "rad" if model.jnt_type[joint] == HINGE else "m"
            text = (
                f"{links[0]} and {links[1]} collide when {name} is at {one.first:.3g} {unit}, by "
                f"{1e3 * one.depth:.2g} mm at {one.deepest:.3g}"
            )
            findings.append((-one.depth, Finding(named("joint", name), "range", text)))
    if not joints:
        return
    told = tuple(one for _, one in sorted(findings, key=lambda pair: pair[0]))
    looked = count(len(joints), "joint") + (f" of {len(every)}" if len(every) > len(joints) else "")
    detail = f"{looked} over its range, {poses} poses: no links run into each other"
    if told:
        detail = f"{count(len(told), 'collision')} of links over the ranges of {looked}"
    result = compiled.within("reach", float(len(told)), 0.0, detail, told, "warning")
    yield replace(result, table=Table(HEADER, tuple(rows)) if rows else None)


def _within_reason(joints: list[int], bodies: int) -> tuple[list[int], int]:
    """The joints that are looked at, spread evenly over all, and in how many steps each."""
    poses = max(FEWEST, PLACED // bodies)
    steps = max(FEWEST, min(STEPS, poses // max(1, len(joints))))
    return joints[:: math.ceil(len(joints) * steps / poses) or 1], steps


def _swept(
    model: Any, data: Any, follower: Follower, joint: int, ignored: set[tuple[int, int]], steps: int
) -> tuple[dict[tuple[tuple[int, int], float], Meeting], int]:
    """The pairs of bodies that meet, each with the end of the range where they do, and how many poses were
    looked at: from `home` to the one end, and to the other."""
    found: dict[tuple[tuple[int, int], float], Meeting] = {}
    value = follower.start[model.jnt_qposadr[joint]]
    low, high = _range(model, joint, value)
    step, tried = max(high - low, 1e-12) / steps, 0
    for end in (low, high):
        pose = follower.start
        for at in np.linspace(value, end, math.ceil(abs(end - value) / step - 1e-6) + 1)[1:]:
            moved = follower.at(joint, float(at), pose)
            if moved is None:
                break
            pose, tried = moved, tried + 1
            data.qpos[:] = pose
            mujoco.mj_kinematics(model, data)
            mujoco.mj_collision(model, data)
            for pair, depth in _contacts(model, data).items():
                if pair in ignored:
                    continue
                known = found.setdefault((pair, float(end)), Meeting(float(at), float(at), depth))
                if depth > known.depth:
                    known.depth, known.deepest = depth, float(at)
    return found, tried


def _range(model: Any, joint: int, value: float) -> tuple[float, float]:
    """The ends between which a joint is swept. A side that has no limit is written as a number that nothing
    reaches: a hinge turns at most once, and a slide stays where it has none."""
    low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (value - np.pi, value + np.pi)
    if model.jnt_type[joint] == HINGE:
        return max(low, value - TURN), min(high, value + TURN)
    return (low if low > value - OPEN else value), (high if high < value + OPEN else value)


def _contacts(model: Any, data: Any) -> dict[tuple[int, int], float]:
    """The bodies that are in each other, and how deep [m]."""
    found: dict[tuple[int, int], float] = {}
    contacts = data.contact
    deep = np.flatnonzero(contacts.dist < -DEEP)
    bodies = np.sort(model.geom_bodyid[contacts.geom[deep]], axis=1)
    for pair, depth in zip(map(tuple, bodies.tolist()), -contacts.dist[deep], strict=True):
        found[pair] = max(float(depth), found.get(pair, 0.0))
    return found
