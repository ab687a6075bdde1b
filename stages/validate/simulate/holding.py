"""Computes the forces with which a model's joints hold its weight, also in closed loops, and the joints'
strength."""

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import actuator_count, body_index, site_index
from linkwright.stages.robot.model.robot import Array, Configuration, Robot
from linkwright.stages.validate.model.coordinates import FREE, HINGE, SLIDE, link_pose, set_values, site_pose
from linkwright.stages.validate.simulate.running import flags, with_options

_JOINT_TRANSMISSIONS = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
"""The transmissions to a joint, which are the same for hinges and slides."""


def driven_joints(model: Any) -> list[int]:
    """Returns the hinges and slides that actuators drive; without actuators, those that follow no other
    joint."""
    followers = {
        int(model.eq_obj1id[row]) for row in range(model.neq) if model.eq_type[row] == mujoco.mjtEq.mjEQ_JOINT
    }
    joints_with_actuator = [
        int(joint)
        for joint, kind in zip(model.actuator_trnid[:, 0], model.actuator_trntype, strict=True)
        if kind in _JOINT_TRANSMISSIONS
    ]
    if model.nu:
        joints = sorted(set(joints_with_actuator))
    else:
        joints = [joint for joint in range(model.njnt) if joint not in followers]
    return [joint for joint in joints if mujoco.mjtJoint(model.jnt_type[joint]) in (HINGE, SLIDE)]


def strength(model: Any, joint: int) -> float | None:
    """Returns the largest force [N m or N] that the actuators of a joint can hold in both directions, within
    the joint's limit; None without any limit."""
    force = np.inf
    actuators = [
        actuator
        for actuator in range(actuator_count(model))
        if int(model.actuator_trnid[actuator][0]) == joint
        and model.actuator_trntype[actuator] in _JOINT_TRANSMISSIONS
    ]
    if actuators and all(model.actuator_forcelimited[actuator] for actuator in actuators):
        # A negative gear swaps the ends. The ends are added, since two actuators may pull against each other.
        ends = [
            np.sort(model.actuator_forcerange[actuator] * model.actuator_gear[actuator][0])
            for actuator in actuators
        ]
        low, high = np.sum(ends, axis=0)
        force = max(0.0, min(-float(low), float(high)))
    if model.jnt_actfrclimited[joint]:
        force = min(force, float(np.abs(model.jnt_actfrcrange[joint]).min()))
    return None if np.isinf(force) else float(force)


def holding_forces(
    model: Any, robot: Robot, poses: list[Configuration], payload: Mapping[str, float]
) -> dict[str, Array]:
    """Returns the force [N m or N] (n,) of each driven joint that holds the weight and the `payload` (link or
    frame → mass [kg]) at rest, in each of the n poses, by the joint's name. A floating base is held.

    The forces solve c = Sᵀ τ + Jᵀ λ, with the bias force less springs c, the driven joints S, the Jacobian J
    of the equalities and their forces λ. Of several solutions the smallest is taken (numpy's lstsq). Undriven
    joints that no equality moves hang freely.
    """
    joints = driven_joints(model)
    forces = np.zeros((len(poses), len(joints)))
    disabled_features = flags("CONTACT", "LIMIT", "FRICTIONLOSS", "ACTUATION")
    jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    data = mujoco.MjData(model)
    with with_options(model, disableflags=int(model.opt.disableflags) | disabled_features, jacobian=jacobian):
        for row, pose in enumerate(poses):
            set_values(model, data, robot, pose, urdf=False)
            mujoco.mj_forward(model, data)
            forces[row] = _joint_forces(model, data, joints, _weight(model, data, robot, payload))
    return {model.joint(joint).name: forces[:, column] for column, joint in enumerate(joints)}


def _weight(model: Any, data: Any, robot: Robot, payload: Mapping[str, float]) -> Array:
    """Returns the force (nv,) that holds the weight and the payload at every degree of freedom, as if there
    were no equalities."""
    force: Array = data.qfrc_bias - data.qfrc_passive
    for name, mass in payload.items():
        body, point = _payload_place(model, data, robot, name)
        point_jacobian = np.zeros((3, model.nv))
        mujoco.mj_jac(model, data, point_jacobian, None, point, body)
        force = force - mass * (point_jacobian.T @ model.opt.gravity)
    return force


def _payload_place(model: Any, data: Any, robot: Robot, name: str) -> tuple[int, Array]:
    """Returns the body that carries a payload, and the payload's place [m] in the world: the origin of a
    frame, or the centre of mass of a link."""
    site, body = site_index(model, name), body_index(model, name)
    link = next((link for link in robot.links if link.name == name), None)
    if link is None:
        return int(model.site_bodyid[site]), site_pose(model, data, site)[:3, 3]
    # A link that is merged into another is a site.
    if body < 0:
        body = int(model.site_bodyid[site])
    pose = link_pose(model, data, robot, name)
    return body, (pose @ np.append(link.inertial.com, 1.0))[:3]


def _joint_forces(model: Any, data: Any, joints: list[int], force: Array) -> Array:
    """Returns the forces of the joints that, with those of the equalities, hold a force (nv,)."""
    dofs = [int(model.jnt_dofadr[joint]) for joint in joints]
    if not data.nefc:
        return force[dofs]
    jacobian = np.reshape(data.efc_J, (-1, model.nv))[: data.nefc]
    # Other degrees of freedom hang freely, and a free base is held: they have no equation.
    has_equation = np.abs(jacobian).max(axis=0) > 0.0
    has_equation[dofs] = True
    for joint in np.flatnonzero(model.jnt_type == int(FREE)):
        first = int(model.jnt_dofadr[joint])
        has_equation[first : first + 6] = False
    selection = np.zeros((model.nv, len(dofs)))
    selection[dofs, range(len(dofs))] = 1.0
    columns = np.concatenate([selection, jacobian.T], axis=1)[has_equation]
    solution: Array = np.linalg.lstsq(columns, force[has_equation], rcond=None)[0]
    return solution[: len(dofs)]
