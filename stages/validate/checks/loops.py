"""Whether a compiled MJCF closes the robot's loops: equalities, sites and carriers."""

from collections import Counter
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from stages.robot.check import Check
from stages.robot.kinematics import chain, link_poses
from stages.robot.model import Array, Loop, Robot
from stages.robot.poses import inverse
from stages.validate.engines.coordinates import (
    HELD,
    body_index,
    distance,
    joint_index,
    placed,
    root_pose,
    set_values,
    site_pose,
    spread,
)

CLOSE = 1e-9
"""Poses of sites [m, rad]."""

CONNECT, WELD = int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD)
EQUALITIES = {"revolute": (CONNECT, 2), "ball": (CONNECT, 1)}
"""How points hold a loop; every other is held by one weld."""


def check_loops(file: str, model: Any, robot: Robot) -> Iterator[Check]:
    """Each loop is held by what its type needs, between the right bodies, at the right places."""
    held = Counter(
        (int(kind), frozenset(int(model.site_bodyid[site]) for site in _sites(model, index)))
        for index, kind in enumerate(model.eq_type)
        if int(kind) in (CONNECT, WELD)
    )
    wanted: Counter[tuple[int, frozenset[int]]] = Counter()
    for loop in robot.loops:
        kind, count = EQUALITIES.get(loop.type, (WELD, 1))
        wanted[kind, frozenset(_ends(model, loop))] += count
    off = sum((held - wanted).values()) + sum((wanted - held).values())
    detail = f"{len(robot.loops)} loops, each held between its links by what its type needs"
    yield Check(f"{file}: loops", off == 0, detail, float(off), 0.0)
    if robot.loops and not off:
        yield _places(file, model, robot)


def unmet(model: Any, data: Any) -> float:
    """How far the equalities of a pose are from met [m, rad], a relation by the joint that it moves less."""
    rows = np.flatnonzero(data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    related = model.eq_type[data.efc_id[rows]] == mujoco.mjtEq.mjEQ_JOINT
    factors = np.abs(model.eq_data[data.efc_id[rows], 1])
    scale = np.where(related, np.maximum(1.0, factors), 1.0)
    return float(np.abs(data.efc_pos[rows] / scale).max(initial=0.0))


def carriers(model: Any, robot: Robot) -> dict[str, list[tuple[int, Array]]]:
    """By link: (body, link_from_body) of the carriers that are welded to it."""
    found: dict[str, list[tuple[int, Array]]] = {}
    for loop in robot.loops:
        index = _equality(model, loop)
        if loop.type in HELD or index < 0:
            continue
        carrier, _ = _ends(model, loop)
        bodies = {body_index(model, link): link for link in (loop.link_a, loop.link_b)}
        sites = sorted(_sites(model, index), key=lambda site: int(model.site_bodyid[site]) == carrier)
        link_site, carrier_site = (placed(model.site_quat[s], model.site_pos[s]) for s in sites)
        link = bodies.get(int(model.site_bodyid[sites[0]]))
        if link is not None:
            found.setdefault(link, []).append((carrier, link_site @ inverse(carrier_site)))
    return found


def _equality(model: Any, loop: Loop) -> int:
    return int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_EQUALITY, loop.name))


def _sites(model: Any, equality: int) -> tuple[int, int]:
    return int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])


def _ends(model: Any, loop: Loop) -> tuple[int, int]:
    """The two bodies that an equality holds together: for a loop with a carrier that, and the link
    that it does not hang on (-1 if it hangs on neither)."""
    a, b = body_index(model, loop.link_a), body_index(model, loop.link_b)
    if loop.type in HELD:
        return a, b
    carrier = int(model.jnt_bodyid[joint_index(model, loop.dofs[0].name)])
    return carrier, {a: b, b: a}.get(int(model.body_parentid[carrier]), -1)


def _places(file: str, model: Any, robot: Robot) -> Check:
    """Each loop's frames, at a configuration at which nothing is closed, relative to the root."""
    data = mujoco.MjData(model)
    q = spread(robot, 0)
    set_values(model, data, robot, q, urdf=False)
    root_from_world = inverse(root_pose(model, data, robot))
    poses = link_poses(robot, q)
    worst, where = 0.0, ""
    for loop in robot.loops:
        index = _equality(model, loop)
        found = {
            int(model.site_bodyid[site]): root_from_world @ site_pose(data, site)
            for site in (_sites(model, index) if index >= 0 else ())
        }
        for body, pose in _frames(model, loop, poses, chain(loop.dofs, q)):
            value = distance(found.get(body, np.full((4, 4), np.nan)), pose)
            if not value < worst:
                worst, where = value, loop.name
    detail = f"frames of each loop against the robot's own kinematics; worst: {where}"
    return Check(f"{file}: frames of loops", worst <= CLOSE, detail, worst, CLOSE)


def _frames(
    model: Any, loop: Loop, poses: dict[str, Array], second_from_first: Array
) -> Iterator[tuple[int, Array]]:
    """(body, root_from_frame) of the loop's two frames; one of them is the carrier's, if there is one."""
    first = poses[loop.link_a] @ loop.a_from_frame
    second = poses[loop.link_b] @ loop.b_from_frame
    a, b = body_index(model, loop.link_a), body_index(model, loop.link_b)
    if loop.type in HELD:
        yield from ((a, first), (b, second))
        return
    carrier, carried = _ends(model, loop)
    if carried == a:
        yield from ((a, first), (carrier, second @ second_from_first))
    else:
        yield from ((b, second), (carrier, first @ inverse(second_from_first)))
