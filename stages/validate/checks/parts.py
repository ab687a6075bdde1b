"""What a compiled model must agree with: the parts, where CAD put them and what CAD says they weigh.

The expected values are summed afresh over the parts, by second moments, not taken from the links
that the files were written from. Where the user gave a link an inertial, that is what it must have.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from stages.robot.check import Check
from stages.robot.model import Array, Inertial, Link, Robot
from stages.robot.poses import inverse
from stages.validate.checks.loops import carriers, unmet
from stages.validate.checks.motion import check_motion
from stages.validate.engines.ability import axes_off
from stages.validate.engines.coordinates import (
    WIDTH,
    body_index,
    distance,
    every_saved,
    joints_of,
    link_pose,
    placed,
    root_pose,
    set_values,
)

EXACT = 1e-9
"""Mass (relative), centre of mass [m], inertia (relative to its tensor's largest entry)."""

LENGTH = 1e-6
"""Poses [m, rad], loops [m]: what CAD's own solver leaves open is below this."""


Lump = tuple[float, Array, Array]
"""Mass, centre of mass, inertia about it."""


def check_model(path: Path, model: Any, robot: Robot) -> Iterator[Check]:
    """All checks of one file's model: contents, masses, poses, and loops where the format has them."""
    file, urdf = path.name, path.suffix == ".urdf"
    yield _contents(file, model, robot, urdf)
    data = mujoco.MjData(model)
    yield from _start(file, model, data, robot)
    if _lost(model, robot, urdf):
        return
    yield from _masses(file, model, robot, urdf)
    set_values(model, data, robot, every_saved(robot), urdf)
    yield _poses(file, model, data, robot, urdf)
    yield from check_motion(path, model, robot)


def _names(model: Any, kind: Any) -> set[str]:
    count = {mujoco.mjtObj.mjOBJ_BODY: model.nbody, mujoco.mjtObj.mjOBJ_JOINT: model.njnt}[kind]
    return {mujoco.mj_id2name(model, kind, index) or "" for index in range(count)}


def _lost(model: Any, robot: Robot, urdf: bool) -> list[str]:
    """Links and joints that the model does not have."""
    bodies = {link.name for link in robot.links} - _names(model, mujoco.mjtObj.mjOBJ_BODY)
    joints = {name for name, *_ in joints_of(robot, urdf)} - _names(model, mujoco.mjtObj.mjOBJ_JOINT)
    return sorted(bodies | joints)


def _contents(file: str, model: Any, robot: Robot, urdf: bool) -> Check:
    """Every link and joint is there by name, and no other degree of freedom."""
    floating = 0 if robot.base.fixed or urdf else 6
    surplus = model.nv - sum(WIDTH[kind] for _, kind, _ in joints_of(robot, urdf)) - floating
    lost = _lost(model, robot, urdf)
    detail = (
        f"missing: {', '.join(lost)}" if lost else f"{len(robot.links)} links, {model.nv} degrees of freedom"
    )
    return Check(f"{file}: links and joints", not lost and surplus == 0, detail, float(abs(surplus)), 0.0)


def _start(file: str, model: Any, data: Any, robot: Robot) -> Iterator[Check]:
    """At qpos0 every equality holds: a fresh simulation starts with its loops closed."""
    if not model.neq or file.endswith(".urdf"):
        return
    mujoco.mj_resetData(model, data)
    mujoco.mj_forward(model, data)
    worst = unmet(model, data)
    detail = f"{len(robot.loops)} loops and {len(robot.relations)} relations hold at qpos0 [m, rad]"
    yield Check(f"{file}: closed at qpos0", worst < LENGTH, detail, worst, LENGTH)


def _masses(file: str, model: Any, robot: Robot, urdf: bool) -> Iterator[Check]:
    """Each link's body, together with the carriers that have a share of it."""
    worst = dict.fromkeys(("mass", "centre of mass", "inertia"), 0.0)
    where = dict.fromkeys(worst, "")
    shares = {} if urdf else carriers(model, robot)
    coarse = False
    for link in robot.links:
        mass, com, inertia = _expected(link)
        lumps = [_lump(model, body_index(model, link.name), np.eye(4))]
        lumps += [_lump(model, body, pose) for body, pose in shares.get(link.name, [])]
        found_mass, found_com, found = _merged(lumps)
        largest = float(np.abs(inertia).max())
        known = axes_off(largest) if urdf and largest else 0.0
        off = {
            "mass": abs(found_mass - mass) / (mass or 1.0),
            "centre of mass": float(np.linalg.norm(found_com - com)) if mass else 0.0,
            "inertia": max(0.0, float(np.abs(found - inertia).max()) / (largest or 1.0) - known),
        }
        coarse |= known > EXACT
        for key, value in off.items():
            if not value < worst[key]:
                worst[key], where[key] = value, link.name
    units = {"mass": "relative", "centre of mass": "m", "inertia": "relative to the tensor"}
    units["inertia"] += ", beyond what this MuJoCo loses of any" if coarse else ""
    for key, value in worst.items():
        detail = f"{key} of each link against CAD's parts ({units[key]}); worst: {where[key]}"
        yield Check(f"{file}: {key}", value <= EXACT, detail, value, EXACT)


def _lump(model: Any, body: int, link_from_body: Array) -> Lump:
    """What a body weighs, in the frame of a link."""
    axes = placed(model.body_iquat[body], model.body_ipos[body])
    tensor = axes[:3, :3] @ np.diag(model.body_inertia[body]) @ axes[:3, :3].T
    return _moved(float(model.body_mass[body]), axes[:3, 3], tensor, link_from_body)


def _expected(link: Link) -> Lump:
    """What a link must weigh, in its own frame: what the user gave, else its parts; a link that CAD
    does not have weighs what it was given as."""
    own: Inertial | None = link.given or (None if link.parts else link.inertial)
    if own is not None:
        return own.mass, own.com, own.inertia
    parts = ((part.inertial, part.link_from_part) for part in link.parts)
    return _merged([_moved(inertial.mass, inertial.com, inertial.inertia, pose) for inertial, pose in parts])


def _moved(mass: float, com: Array, inertia: Array, a_from_b: Array) -> Lump:
    rotation = a_from_b[:3, :3]
    return mass, rotation @ com + a_from_b[:3, 3], rotation @ inertia @ rotation.T


def _merged(lumps: list[Lump]) -> Lump:
    """One body of several in the same frame.

    Sums the second-moment matrices ∫ x xᵀ dm = ½ tr(I) 1 − I + m c cᵀ, from which
    I = tr(S) 1 − S, rather than merging tensors by the parallel axis theorem.
    """
    mass = sum(lump[0] for lump in lumps)
    if mass == 0.0:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    com = sum((own * centre for own, centre, _ in lumps), np.zeros(3)) / mass
    second = np.zeros((3, 3))
    for own, centre, inertia in lumps:
        arm = centre - com
        second += 0.5 * np.trace(inertia) * np.eye(3) - inertia + own * np.outer(arm, arm)
    return mass, com, np.trace(second) * np.eye(3) - second


def _poses(file: str, model: Any, data: Any, robot: Robot, urdf: bool) -> Check:
    """At the saved configuration every part is where CAD's occurrence has it.

    The scene may put the robot anywhere: where its root is counts as where CAD has the root's frame. A
    URDF has no scene: there the root is at the origin.
    """
    world_from_root = np.eye(4) if urdf else root_pose(model, data, robot)
    world_from_cad = world_from_root @ inverse(robot.world_from_root)
    worst, where = 0.0, ""
    for link in robot.links:
        world_from_link = link_pose(model, data, robot, link.name)
        for part in link.parts:
            found = world_from_link @ part.link_from_part
            value = distance(found, world_from_cad @ part.world_from_part)
            if not value < worst:
                worst, where = value, part.name
    detail = f"parts against CAD's occurrences at the saved pose [m, rad]; worst: {where}"
    return Check(f"{file}: poses", worst <= LENGTH, detail, worst, LENGTH)
