"""States of MuJoCo's models: at a keyframe or at values of joints, some time later, and their poses."""

import mujoco

from linkwright.stages.robot.model.poses import from_parts


def state(model, key=None, **values):
    """The state at a keyframe (without one at qpos0) with these values of joints, and their results."""
    data = mujoco.MjData(model)
    if key is not None:
        mujoco.mj_resetDataKeyframe(model, data, model.key(key).id)
    for name, value in values.items():
        data.joint(name).qpos[:] = value
    mujoco.mj_forward(model, data)
    return data


def run(model, data, seconds):
    """The state after this time."""
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
    return data


def pose_of(body):
    """The pose (4, 4) of a body, site, geom or camera of a state in the world."""
    return from_parts(body.xmat.reshape(3, 3), body.xpos)


def equality_errors(model, data):
    """What the equalities of a state lack [m, rad]."""
    return data.efc_pos[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY]
