"""What a compiled model must agree with: the parts, where CAD put them and what CAD says they weigh.

The expected values are summed afresh over the parts, by second moments, not taken from the links
that the files were written from.
"""

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from stages.robot.check import Check
from stages.robot.kinematics import saved_configuration
from stages.robot.model import Array, Link, Robot
from stages.validate.motion import body_index, check_motion, distance, pose_of, set_joints

EXACT = 1e-9
"""Mass (relative), centre of mass [m], inertia (relative to its tensor's largest entry)."""

LENGTH = 1e-6
"""Poses [m, rad], loops [m]: what CAD's own solver leaves open is below this."""


def check_model(file: str, model: Any, robot: Robot) -> Iterator[Check]:
    """All checks of one model: contents, masses, poses, and loops where the format has them."""
    yield _contents(file, model, robot)
    data = mujoco.MjData(model)
    yield from _start(file, model, data, robot)
    if _lost(model, robot):
        return
    yield from _masses(file, model, robot)
    set_joints(model, data, saved_configuration(robot))
    yield _poses(file, model, data, robot)
    yield from check_motion(file, model, robot)


def _names(model: Any, kind: Any) -> set[str]:
    count = {mujoco.mjtObj.mjOBJ_BODY: model.nbody, mujoco.mjtObj.mjOBJ_JOINT: model.njnt}[kind]
    return {mujoco.mj_id2name(model, kind, index) or "" for index in range(count)}


def _lost(model: Any, robot: Robot) -> list[str]:
    """Links and joints that the model does not have."""
    bodies = {link.name for link in robot.links} - _names(model, mujoco.mjtObj.mjOBJ_BODY)
    joints = {joint.name for joint in robot.joints} - _names(model, mujoco.mjtObj.mjOBJ_JOINT)
    return sorted(bodies | joints)


def _contents(file: str, model: Any, robot: Robot) -> Check:
    """Every link and joint is there by name, and no other degree of freedom."""
    free = 0 if robot.base.fixed or file.endswith(".urdf") else 6
    surplus = model.nv - len(robot.joints) - free
    lost = _lost(model, robot)
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
    rows = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
    worst = float(np.abs(data.efc_pos[rows]).max(initial=0.0))
    detail = f"{len(robot.loops)} loops and {len(robot.relations)} relations hold at qpos0 [m, rad]"
    yield Check(f"{file}: closed at qpos0", worst < LENGTH, detail, worst, LENGTH)


def _masses(file: str, model: Any, robot: Robot) -> Iterator[Check]:
    worst = dict.fromkeys(("mass", "centre of mass", "inertia"), 0.0)
    where = dict.fromkeys(worst, "")
    for link in robot.links:
        mass, com, inertia = _expected(link)
        body = body_index(model, link.name)
        flat = np.empty(9)
        mujoco.mju_quat2Mat(flat, model.body_iquat[body])
        axes = flat.reshape(3, 3)
        found = axes @ np.diag(model.body_inertia[body]) @ axes.T
        off = {
            "mass": abs(float(model.body_mass[body]) - mass) / (mass or 1.0),
            "centre of mass": float(np.linalg.norm(model.body_ipos[body] - com)) if mass else 0.0,
            "inertia": float(np.abs(found - inertia).max()) / (float(np.abs(inertia).max()) or 1.0),
        }
        for key, value in off.items():
            if value >= worst[key]:
                worst[key], where[key] = value, link.name
    units = {"mass": "relative", "centre of mass": "m", "inertia": "relative to the tensor"}
    for key, value in worst.items():
        detail = f"{key} of each link against CAD's parts ({units[key]}); worst: {where[key]}"
        yield Check(f"{file}: {key}", value <= EXACT, detail, value, EXACT)


def _expected(link: Link) -> tuple[float, Array, Array]:
    """(mass, centre, inertia about it) of a link in its own frame, from its parts.

    Sums the second-moment matrices ∫ x xᵀ dm = ½ tr(I) 1 − I + m c cᵀ, from which
    I = tr(S) 1 − S, rather than merging tensors by the parallel axis theorem.
    """
    mass = sum(part.inertial.mass for part in link.parts)
    if mass == 0.0:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    centres = [part.link_from_part @ np.append(part.inertial.com, 1.0) for part in link.parts]
    com = sum(p.inertial.mass * c[:3] for p, c in zip(link.parts, centres, strict=True)) / mass
    second = np.zeros((3, 3))
    for part, centre in zip(link.parts, centres, strict=True):
        rotation, inertia = part.link_from_part[:3, :3], part.inertial.inertia
        spread = 0.5 * np.trace(inertia) * np.eye(3) - inertia
        arm = centre[:3] - com
        second += rotation @ spread @ rotation.T + part.inertial.mass * np.outer(arm, arm)
    return mass, com, np.trace(second) * np.eye(3) - second


def _poses(file: str, model: Any, data: Any, robot: Robot) -> Check:
    """At the saved configuration every part is where CAD's occurrence has it.

    The scene may put the robot anywhere; where its root is counts as the assembly's origin. A URDF
    has no scene: there the root is at the origin.
    """
    world_from_root = pose_of(data, body_index(model, robot.root.name))
    if file.endswith(".urdf"):
        world_from_root = np.eye(4)
    worst, where = 0.0, ""
    for link in robot.links:
        world_from_link = pose_of(data, body_index(model, link.name))
        for part in link.parts:
            found = world_from_link @ part.link_from_part
            value = distance(found, world_from_root @ part.world_from_part)
            if value >= worst:
                worst, where = value, part.name
    detail = f"parts against CAD's occurrences at the saved pose [m, rad]; worst: {where}"
    return Check(f"{file}: poses", worst <= LENGTH, detail, worst, LENGTH)
