"""Judges the points about joints, their drives, and the first pose."""

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import actuator_count, controls_of
from linkwright.stages.mujoco.state import keyframe_index
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.model.coordinates import BALL, FREE
from linkwright.stages.validate.model.equality_solver import jacobian_and_errors
from linkwright.stages.validate.model.shapes import reach
from linkwright.stages.validate.readiness.finished import FinishedRobot, NotApplicable

MIN_SINGULAR_VALUE = 1e-6
"""Smallest singular value of the equalities' Jacobian that counts for its rank."""

ROUNDING = 1e-9
"""Tolerance of values [rad, m], controls and quaternions at the ends of their ranges."""

GROUND_DISTANCE = (-1e-6, 2e-3)
"""Range of the height [m] of a free base's lowest collider above the ground."""

DOWN = np.array([[0.0, 0.0, -1.0]])
"""The direction (1, 3) of gravity in the world."""


def limits(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether slides have limits, and `home` is within all limits. The robot's hinges need none."""
    model, data = finished.model, finished.home
    dof_names = {dof.name for dof in finished.robot.dofs}
    for joint in finished.scalar_joints:
        name = finished.name_of("joint", joint)
        low, high = model.jnt_range[joint]
        value = data.qpos[model.jnt_qposadr[joint]]
        if not model.jnt_limited[joint]:
            if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE or name not in dof_names:
                yield f"give {name} limits: joints: {{{name}: {{limits: [low, high]}}}}"
        elif not low - ROUNDING <= value <= high + ROUNDING:
            yield f"{name} is at {value:.4g} at home, outside its range {low:.4g} to {high:.4g}"


def drives(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether driven joints have an armature, damping and a single bound of their force."""
    model = finished.model
    joints = _driving_actuators(finished)
    if not joints:
        raise NotApplicable("nothing is driven")
    for index, joint in joints:
        dof, name = int(model.jnt_dofadr[joint]), finished.name_of("joint", joint)
        if model.dof_armature[dof] <= 0:
            yield f"give {name} an armature: joints: {{{name}: {{armature: ...}}}}"
        is_damped = model.dof_damping[dof] > 0 or model.dof_frictionloss[dof] > 0
        if not is_damped and model.actuator_biasprm[index, 2] >= 0:
            yield f"nothing damps {name}: joints: {{{name}: {{damping: ...}}}}"
        bound_count = int(model.jnt_actfrclimited[joint]) + int(model.actuator_forcelimited[index])
        if bound_count == 0:
            yield f"bound the force on {name}: joints: {{{name}: {{effort: ...}}}}"
        elif bound_count == 2:
            yield f"bound the force on {name} once, at the joint or at the actuator"


def controls(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether as many joints are driven as move independently, and controls stay in range."""
    model, joints = finished.model, _driving_actuators(finished)
    if not joints:
        raise NotApplicable("nothing is driven")
    free = _independent_motion_count(finished)
    # Two actuators may drive the same joint.
    driven_joints = {joint for _, joint in joints}
    if len(driven_joints) != free:
        yield f"actuators drive {count(len(driven_joints), 'joint')}, but {free} are independent: actuators"
    for index, joint in joints:
        name = finished.name_of("joint", joint)
        # MuJoCo's affine bias is biasprm[0] + biasprm[1] · position + biasprm[2] · speed.
        is_servo = model.actuator_biasprm[index, 1] < 0
        if is_servo and (model.actuator_gainprm[index, 0] <= 0 or model.actuator_biasprm[index, 2] >= 0):
            is_damped = model.dof_damping[int(model.jnt_dofadr[joint])] > 0
            if not is_damped:
                yield f"the servo of {name} has no gain, or no gain of the speed: dampratio"
        controls = controls_of(model, index)
        if is_servo and model.jnt_limited[joint] and controls and model.actuator_ctrllimited[controls.start]:
            low, high = model.actuator_ctrlrange[controls.start]
            ends = model.jnt_range[joint] * model.actuator_gear[index, 0]
            if low < ends.min() - ROUNDING or high > ends.max() + ROUNDING:
                yield f"keep the controls of {name} within its range"


def _driving_actuators(finished: FinishedRobot) -> list[tuple[int, int]]:
    """Returns the actuators of joints with a single dof, each with its joint."""
    model = finished.model
    joint_transmissions = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
    return [
        (index, int(model.actuator_trnid[index, 0]))
        for index in range(actuator_count(model))
        if model.actuator_trntype[index] in joint_transmissions
        and int(model.actuator_trnid[index, 0]) in finished.scalar_joints
    ]


def _independent_motion_count(finished: FinishedRobot) -> int:
    """Returns the number of independent motions, without those of a floating base: the number of dofs less
    the rank of the equalities."""
    model = finished.model
    floating_dofs = 6 * int((model.jnt_type == FREE).sum())
    jacobian, _ = jacobian_and_errors(model, mujoco.MjData(model), finished.home.qpos)
    singular_values = np.linalg.svd(jacobian, compute_uv=False) if len(jacobian) else np.zeros(0)
    return int(model.nv - floating_dofs - (singular_values > MIN_SINGULAR_VALUE).sum())


def keyframe(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether a keyframe `home` exists, with unit quaternions and controls in range."""
    model = finished.model
    key = keyframe_index(model, "home")
    if key < 0:
        yield "write a keyframe home: keyframes"
        return
    for joint in range(model.njnt):
        if model.jnt_type[joint] == FREE or model.jnt_type[joint] == BALL:
            first = int(model.jnt_qposadr[joint]) + (3 if model.jnt_type[joint] == FREE else 0)
            if not abs(np.linalg.norm(model.key_qpos[key][first : first + 4]) - 1) <= ROUNDING:
                yield f"normalise the quaternion of {finished.name_of('joint', joint)} at home"
    low, high = model.actuator_ctrlrange.T
    control = model.key_ctrl[key]
    is_out_of_range = model.actuator_ctrllimited.astype(bool) & (
        (control < low - ROUNDING) | (control > high + ROUNDING)
    )
    for index in range(actuator_count(model)):
        if is_out_of_range[controls_of(model, index)].any():
            yield f"{finished.name_of('actuator', index)} has a control at home out of its range"


def base_placement(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether the base floats as in the source, and stands on the ground at `home`."""
    model = finished.model
    free = [joint for joint in range(model.njnt) if model.jnt_type[joint] == FREE]
    if finished.robot.base.fixed:
        if free:
            yield "the base is fixed in the source, and floats here"
        return
    if not free:
        yield "the base floats in the source, and is fixed here"
    yield from ("name the free joint" for joint in free if not finished.name_of("joint", joint))
    ground = ground_height(model)
    if ground is None:
        raise NotApplicable("there is no flat ground")
    lowest = min(
        (
            _lowest_height(finished, body, solid)
            for body, (_, solid) in finished.geoms_by_body.items()
            if solid
        ),
        default=None,
    )
    if lowest is None:
        raise NotApplicable("nothing collides")
    if not GROUND_DISTANCE[0] <= lowest - ground <= GROUND_DISTANCE[1]:
        yield f"the lowest collider is {1e3 * (lowest - ground):.3g} mm above the ground at home: scene.pose"


def ground_height(model: Any) -> float | None:
    """Returns the height [m] of the world's first level plane; None without such a plane."""
    for geom in range(model.ngeom):
        is_plane = model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE and not model.geom_bodyid[geom]
        # A turn about z keeps a plane level: x and y of its quaternion are 0.
        if is_plane and abs(model.geom_quat[geom][1]) + abs(model.geom_quat[geom][2]) < ROUNDING:
            return float(model.geom_pos[geom][2])
    return None


def _lowest_height(finished: FinishedRobot, body: int, solid: list[int]) -> float:
    """Returns the height [m] of a body's lowest colliding point at `home`."""
    data = finished.home
    down = DOWN @ data.xmat[body].reshape(3, 3)
    return float(data.xpos[body][2] - reach(finished.model, solid, down)[0])


def sensors(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether joints are measured, and IMUs and cameras are complete."""
    model = finished.model
    kinds = {int(kind) for kind in model.sensor_type}
    kind = mujoco.mjtSensor
    if finished.scalar_joints and not {int(kind.mjSENS_JOINTPOS), int(kind.mjSENS_ACTUATORPOS)} & kinds:
        yield "measure the joints: actuators: {'*': {encoder: true}}, or sensors"
    imus = {int(kind.mjSENS_GYRO), int(kind.mjSENS_ACCELEROMETER)}
    if len(imus & kinds) == 1:
        yield "an IMU has a gyroscope and an accelerometer: sensors"
    for camera in range(model.ncam):
        if model.cam_bodyid[camera] and (model.cam_resolution[camera] <= 1).all():
            yield f"state the resolution of the camera {finished.name_of('camera', camera)}"
