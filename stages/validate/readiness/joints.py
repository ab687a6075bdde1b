"""The points about joints, what drives them, and the first pose."""

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.state import keyframe_of
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.model.coordinates import BALL, FREE
from linkwright.stages.validate.model.following import equalities
from linkwright.stages.validate.model.shapes import reach
from linkwright.stages.validate.readiness.finished import Aside, Finished

RANK = 1e-6
ROUNDING = 1e-9

STANDS = (-1e-6, 2e-3)
"""Where the lowest collider of a free base is above the ground [m]."""

DOWN = np.array([[0.0, 0.0, -1.0]])


def limits(finished: Finished) -> Iterator[str]:
    model, said = finished.model, {dof.name: dof.limits for dof in finished.robot.dofs}
    data = finished.home
    for joint in finished.scalar_joints:
        name = finished.name_of("joint", joint)
        low, high = model.jnt_range[joint]
        value = data.qpos[model.jnt_qposadr[joint]]
        if not model.jnt_limited[joint]:
            if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE or name not in said:
                yield f"give {name} limits: joints: {{{name}: {{limits: [low, high]}}}}"
        elif not low - ROUNDING <= value <= high + ROUNDING:
            yield f"{name} is at {value:.4g} at home, outside its range {low:.4g} to {high:.4g}"


def driven(finished: Finished) -> Iterator[str]:
    model = finished.model
    joints = _driven(finished)
    if not joints:
        raise Aside("nothing is driven")
    for index, joint in joints:
        dof, name = int(model.jnt_dofadr[joint]), finished.name_of("joint", joint)
        if model.dof_armature[dof] <= 0:
            yield f"give {name} an armature: joints: {{{name}: {{armature: ...}}}}"
        damps = model.dof_damping[dof] > 0 or model.dof_frictionloss[dof] > 0
        if not damps and model.actuator_biasprm[index, 2] >= 0:
            yield f"nothing damps {name}: joints: {{{name}: {{damping: ...}}}}"
        bounds = int(model.jnt_actfrclimited[joint]) + int(model.actuator_forcelimited[index])
        if bounds == 0:
            yield f"bound the force on {name}: joints: {{{name}: {{effort: ...}}}}"
        elif bounds == 2:
            yield f"bound the force on {name} once, at the joint or at the actuator"


def independent(finished: Finished) -> Iterator[str]:
    model, joints = finished.model, _driven(finished)
    if not joints:
        raise Aside("nothing is driven")
    free = _free(finished)
    if len({joint for _, joint in joints}) != free:
        yield f"{count(len(joints), 'joint')} of {free} independent ones are driven: actuators"
    for index, joint in joints:
        name = finished.name_of("joint", joint)
        servo = model.actuator_biasprm[index, 1] < 0
        if servo and (model.actuator_gainprm[index, 0] <= 0 or model.actuator_biasprm[index, 2] >= 0):
            damped = model.dof_damping[int(model.jnt_dofadr[joint])] > 0
            if not damped:
                yield f"the servo of {name} has no gain, or none of the speed: dampratio"
        low, high = model.actuator_ctrlrange[index]
        if servo and model.jnt_limited[joint] and model.actuator_ctrllimited[index]:
            ends = model.jnt_range[joint] * model.actuator_gear[index, 0]
            if low < ends.min() - ROUNDING or high > ends.max() + ROUNDING:
                yield f"keep the controls of {name} within its range"


def _driven(finished: Finished) -> list[tuple[int, int]]:
    """The actuators of joints with one dof, each with its joint."""
    model = finished.model
    of_joint = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
    return [
        (index, int(model.actuator_trnid[index, 0]))
        for index in range(model.nu)
        if model.actuator_trntype[index] in of_joint
        and int(model.actuator_trnid[index, 0]) in finished.scalar_joints
    ]


def _free(finished: Finished) -> int:
    """The number of independent motions besides a floating base: dofs less the rank of the equalities."""
    model = finished.model
    passive = 6 * int((model.jnt_type == FREE).sum())
    jacobian, _ = equalities(model, mujoco.MjData(model), finished.home.qpos)
    sizes = np.linalg.svd(jacobian, compute_uv=False) if len(jacobian) else np.zeros(0)
    return int(model.nv - passive - (sizes > RANK).sum())


def keyframe(finished: Finished) -> Iterator[str]:
    model = finished.model
    key = keyframe_of(model, "home")
    if key < 0:
        yield "write a keyframe home: keyframes"
        return
    for joint in range(model.njnt):
        if model.jnt_type[joint] == FREE or model.jnt_type[joint] == BALL:
            first = int(model.jnt_qposadr[joint]) + (3 if model.jnt_type[joint] == FREE else 0)
            if abs(np.linalg.norm(model.key_qpos[key][first : first + 4]) - 1) > ROUNDING:
                yield f"normalise the quaternion of {finished.name_of('joint', joint)} at home"
    low, high = model.actuator_ctrlrange.T
    control = model.key_ctrl[key]
    out = model.actuator_ctrllimited.astype(bool) & ((control < low - ROUNDING) | (control > high + ROUNDING))
    for index in map(int, np.flatnonzero(out)):
        yield f"{finished.name_of('actuator', index)} has a control at home out of its range"


def stance(finished: Finished) -> Iterator[str]:
    model = finished.model
    free = [joint for joint in range(model.njnt) if model.jnt_type[joint] == FREE]
    if finished.robot.base.fixed:
        if free:
            yield "the base is fixed in the source, and floats here"
        return
    if not free:
        yield "the base floats in the source, and is fixed here"
    yield from ("name the free joint" for joint in free if not finished.name_of("joint", joint))
    ground = _ground(model)
    if ground is None:
        raise Aside("there is no flat ground")
    lowest = min(
        (_lowest(finished, body, solid) for body, (_, solid) in finished.shapes.items() if solid),
        default=None,
    )
    if lowest is None:
        raise Aside("nothing collides")
    if not STANDS[0] <= lowest - ground <= STANDS[1]:
        yield f"the lowest collider is {1e3 * (lowest - ground):.3g} mm above the ground at home: scene.pose"


def _ground(model: Any) -> float | None:
    """The height of a level plane in the world [m]."""
    for geom in range(model.ngeom):
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE and not model.geom_bodyid[geom]:
            level = abs(model.geom_quat[geom][1]) + abs(model.geom_quat[geom][2]) < ROUNDING
            return float(model.geom_pos[geom][2]) if level else None
    return None


def _lowest(finished: Finished, body: int, solid: list[int]) -> float:
    """How far down the colliders of a body reach at `home` [m]."""
    data = finished.home
    own = DOWN @ data.xmat[body].reshape(3, 3)
    return float(data.xpos[body][2] - reach(finished.model, solid, own)[0])


def sensors(finished: Finished) -> Iterator[str]:
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
