"""The points that a simulation shows, of a robot with servos."""

import mujoco
import numpy as np

from tests.support.checklist.compiled import HINGE, SLIDE

DEEPEST = 1e-3
DRIFT = 0.01
RANK = 1e-6
SECONDS = 2.0


def driven(built):
    """15: what is driven has inertia of its rotor, friction, and one limit of its force."""
    model = built.model
    for index in range(model.nu):
        joint = model.actuator_trnid[index, 0]
        dof, name = model.jnt_dofadr[joint], model.joint(joint).name
        if model.dof_armature[dof] <= 0:
            yield f"{name}: no armature"
        speed = -model.actuator_biasprm[index, 2]
        if model.dof_damping[dof] <= 0 and model.dof_frictionloss[dof] <= 0 and speed <= 0:
            yield f"{name}: nothing damps it"
        if model.jnt_actfrclimited[joint] and model.actuator_forcelimited[index]:
            yield f"{name}: its force is limited twice"


def independent(built):
    """16: as many actuators as the robot has independent hinges and slides, each with gains, within its
    range and as far beyond it as a keyframe needs to hold the weight."""
    model = built.model
    data = mujoco.MjData(model)
    data.qpos[:] = model.key("home").qpos
    mujoco.mj_fwdPosition(model, data)
    rows = np.flatnonzero(data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    jacobian = np.zeros((data.nefc, model.nv))
    if mujoco.mj_isSparse(model):
        mujoco.mju_sparse2dense(jacobian, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind)
    else:
        jacobian[:] = data.efc_J.reshape(-1, model.nv)[: data.nefc]
    _, sizes, motions = np.linalg.svd(np.vstack([jacobian[rows], np.zeros((1, model.nv))]))
    # What a ball alone leaves free (a rod turns about itself, a caster rolls) has no actuator.
    single = np.isin(model.jnt_type, (HINGE, SLIDE))[model.dof_jntid]
    free = np.linalg.matrix_rank(motions[int((sizes > RANK).sum()) :, single], tol=RANK)
    if model.nu != free:
        yield f"{model.nu} actuators for {free} independent hinges and slides"
    for index in range(model.nu):
        joint = model.actuator_trnid[index, 0]
        name = model.joint(joint).name
        stiffness, speed_gain = model.actuator_gainprm[index, 0], model.actuator_biasprm[index, 2]
        dof = model.jnt_dofadr[joint]
        # A servo of the motor library has no gain of its speed: its back EMF is the joint's damping.
        undamped = speed_gain >= 0 and model.dof_damping[dof] ** 2 <= stiffness * model.dof_armature[dof]
        if stiffness <= 0 or undamped:
            yield f"{name}: no gain, or nothing that damps it"
        low, high = model.actuator_ctrlrange[index]
        if model.jnt_limited[joint]:
            least, most = model.jnt_range[joint]
            beyond = np.abs(model.key_ctrl[:, index] - model.key_qpos[:, model.jnt_qposadr[joint]]).max()
            if low < least - beyond - 1e-9 or high > most + beyond + 1e-9:
                yield f"{name}: controls {low} to {high}, range {least} to {most}"


def no_contacts(built):
    """19 and 22: at `home` nothing is in the way, but for what the build names."""
    data, model = built.at_home(), built.scene
    for contact in data.contact:
        first, other = (model.body(model.geom_bodyid[geom]).name for geom in contact.geom)
        if contact.dist < -DEEPEST and not (first in built.messages and other in built.messages):
            yield f"{first} and {other}: {contact.dist} m"


def excludes(built):
    """22: each exclude has its reason in the report."""
    model = built.model
    rows = {tuple(sorted(row["links"])) for row in built.report["details"].get("excludes", ())}
    for signature in model.exclude_signature[: model.nexclude]:
        pair = tuple(sorted(model.body(int(index)).name for index in divmod(int(signature), 1 << 16)))
        if pair not in rows:
            yield f"{pair} are excluded, and nobody says why"


def holds(built):
    """20: two seconds at `home`: it rests where it is."""
    data, model = built.at_home(), built.scene
    start = data.qpos.copy()
    for _ in range(round(SECONDS / model.opt.timestep)):
        mujoco.mj_step(model, data)
    yield from _warnings(data)
    if np.abs(data.qvel).max() > 0.01:
        yield f"it moves at {np.abs(data.qvel).max()} rad/s or m/s"
    if np.abs(data.qpos[:3] - start[:3]).max() > DRIFT and model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE:
        yield f"the base moves from {start[:3]} to {data.qpos[:3]}"
    joints = [i for i in range(model.njnt) if model.jnt_type[i] in (HINGE, SLIDE)]
    off = np.abs(data.qpos - start)[model.jnt_qposadr[joints]]
    for index in np.flatnonzero(off > 0.02):
        yield f"{model.joint(joints[index]).name} sags by {off[index]}"


def control_noise(built):
    """21: one second of random controls over their whole ranges."""
    data, model = built.at_home(), built.scene
    random = np.random.default_rng(7)
    low, high = model.actuator_ctrlrange.T
    for step in range(round(1.0 / model.opt.timestep)):
        if step % 10 == 0:
            data.ctrl[:] = random.uniform(low, high)
        mujoco.mj_step(model, data)
    yield from _warnings(data)
    if not np.isfinite(data.qpos).all():
        yield "not a number"


def _warnings(data):
    yield from (f"warning {index}" for index in np.flatnonzero(data.warning.number))


POINTS = (driven, independent, no_contacts, excludes, holds, control_noise)
