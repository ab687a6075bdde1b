"""The forces by which a model's joints hold its weight, closed loops and all, and what they can do."""

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import body_index, site_index
from linkwright.stages.robot.model.robot import Array, Configuration, Robot
from linkwright.stages.validate.model.coordinates import FREE, HINGE, SLIDE, link_pose, set_values, site_pose
from linkwright.stages.validate.simulate.running import flags, with_options


def driven(model: Any) -> list[int]:
    """The hinges and slides that actuators drive; without any actuator those that do not follow another."""
    follows = {
        int(model.eq_obj1id[row]) for row in range(model.neq) if model.eq_type[row] == mujoco.mjtEq.mjEQ_JOINT
    }
    on = [
        int(joint)
        for joint, kind in zip(model.actuator_trnid[:, 0], model.actuator_trntype, strict=True)
        if kind == mujoco.mjtTrn.mjTRN_JOINT
    ]
    every = sorted(set(on)) if model.nu else [one for one in range(model.njnt) if one not in follows]
    return [one for one in every if mujoco.mjtJoint(model.jnt_type[one]) in (HINGE, SLIDE)]


def strength(model: Any, joint: int) -> float | None:
    """The largest force [N m or N] that the actuators of a joint can hold to both sides, within the joint's
    own limit of it; None where nothing limits it."""
    found = np.inf
    own = [at for at in range(model.nu) if int(model.actuator_trnid[at][0]) == joint]
    own = [at for at in own if model.actuator_trntype[at] == mujoco.mjtTrn.mjTRN_JOINT]
    if own and all(model.actuator_forcelimited[at] for at in own):
        sides = [np.abs(model.actuator_forcerange[at]).min() * abs(model.actuator_gear[at][0]) for at in own]
        found = float(sum(sides))
    if model.jnt_actfrclimited[joint]:
        found = min(found, float(np.abs(model.jnt_actfrcrange[joint]).min()))
    return None if np.isinf(found) else float(found)


def holding(
    model: Any, robot: Robot, poses: list[Configuration], payload: Mapping[str, float]
) -> dict[str, Array]:
    """By joint that is driven: the force [N m or N] that holds the weight, with the `payload` [kg], at rest
    in each of the poses (n,), where a floating base is held.

    What holds solves c = Sᵀ τ + Jᵀ λ: c the bias force less springs, S the driven joints, J the Jacobian of
    the equalities, λ what these carry; of several solutions the least (numpy's). Joints that nothing drives,
    and that no equality moves, hang as they like.
    """
    joints = driven(model)
    found = np.zeros((len(poses), len(joints)))
    off = flags("CONTACT", "LIMIT", "FRICTIONLOSS", "ACTUATION")
    jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    data = mujoco.MjData(model)
    with with_options(model, disableflags=int(model.opt.disableflags) | off, jacobian=jacobian):
        for row, pose in enumerate(poses):
            set_values(model, data, robot, pose, urdf=False)
            mujoco.mj_forward(model, data)
            found[row] = _held(model, data, joints, _weight(model, data, robot, payload))
    return {model.joint(joint).name: found[:, column] for column, joint in enumerate(joints)}


def _weight(model: Any, data: Any, robot: Robot, payload: Mapping[str, float]) -> Array:
    """The force (nv,) that holds every degree of freedom on its own."""
    force: Array = data.qfrc_bias - data.qfrc_passive
    for name, mass in payload.items():
        body, point = _place(model, data, robot, name)
        rises = np.zeros((3, model.nv))
        mujoco.mj_jac(model, data, rises, None, point, body)
        force = force - mass * (rises.T @ model.opt.gravity)
    return force


def _place(model: Any, data: Any, robot: Robot, name: str) -> tuple[int, Array]:
    """The body that carries a payload, and where [m] in the world: at the origin of a frame, or at the centre
    of mass of a link."""
    site, body = site_index(model, name), body_index(model, name)
    link = next((one for one in robot.links if one.name == name), None)
    if link is None:
        return int(model.site_bodyid[site]), site_pose(model, data, site)[:3, 3]
    if body < 0:
        body = int(model.site_bodyid[site])
    pose = link_pose(model, data, robot, name)
    return body, (pose @ np.append(link.inertial.com, 1.0))[:3]


def _held(model: Any, data: Any, joints: list[int], force: Array) -> Array:
    dofs = [int(model.jnt_dofadr[joint]) for joint in joints]
    if not data.nefc:
        return force[dofs]
    jacobian = np.reshape(data.efc_J, (-1, model.nv))[: data.nefc]
    moved = np.abs(jacobian).max(axis=0) > 0.0
    moved[dofs] = True
    for joint in np.flatnonzero(model.jnt_type == int(FREE)):
        first = int(model.jnt_dofadr[joint])
        moved[first : first + 6] = False
    drive = np.zeros((model.nv, len(dofs)))
    drive[dofs, range(len(dofs))] = 1.0
    columns = np.concatenate([drive, jacobian.T], axis=1)[moved]
    solved: Array = np.linalg.lstsq(columns, force[moved], rcond=None)[0]
    return solved[: len(dofs)]
