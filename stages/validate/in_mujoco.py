"""What MuJoCo finds in a compiled model: poses, mass matrix and forces, without contact and armature."""

from typing import Any

import mujoco
import numpy as np

from stages.robot.model import Array, Robot, Value
from stages.robot.pose_batch import Values
from stages.robot.statics import GRAVITY
from stages.validate.coordinates import joint_index, link_pose, root_pose, set_values
from stages.validate.tree_dynamics import Moving, scalar_dofs


def in_mujoco(model: Any, robot: Robot, values: Values, speeds: Array, urdf: bool) -> tuple[Moving, Array]:
    """As `dynamics`, and what gravity is against there (n, 3), in the root's axes, which a scene may turn."""
    kept = model.opt.gravity.copy(), int(model.opt.disableflags)
    model.opt.gravity[:], model.opt.disableflags = GRAVITY, 0
    try:
        return _read(model, robot, values, speeds, urdf)
    finally:
        model.opt.gravity[:], model.opt.disableflags = kept


def _read(model: Any, robot: Robot, values: Values, speeds: Array, urdf: bool) -> tuple[Moving, Array]:
    data = mujoco.MjData(model)
    joints = [joint_index(model, dof.name) for dof in scalar_dofs(robot)]
    rows, places = model.jnt_dofadr[joints], model.jnt_qposadr[joints]
    plain = {dof.name for dof in scalar_dofs(robot)} == {dof.name for dof in robot.dofs}
    count, size = speeds.shape
    poses = {link.name: np.empty((count, 4, 4)) for link in robot.links}
    mass, gravity, bias = np.empty((count, size, size)), np.empty((count, size)), np.empty((count, size))
    up, units = np.empty((count, 3)), np.eye(model.nv)[rows]
    column, force = np.empty(model.nv), np.empty(model.nv)
    loops = {dof.name: dof.saved for loop in robot.loops for dof in loop.dofs}
    mujoco.mj_resetData(model, data)
    for index in range(count):
        if plain and not loops:
            data.qpos[places] = [values[dof.name][index] for dof in robot.dofs]
        else:
            set_values(model, data, robot, loops | _one(values, index), urdf)
        data.qvel[:] = 0
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_makeM(model, data)
        world_from_root = root_pose(model, data, robot)
        from_root = np.linalg.inv(world_from_root)
        for name, pose in poses.items():
            pose[index] = from_root @ link_pose(model, data, robot, name)
        up[index] = -world_from_root[:3, :3].T @ GRAVITY
        for row, unit in enumerate(units):
            mujoco.mj_mulM(model, data, column, unit)
            mass[index, row] = column[rows]
        mass[index] -= np.diag(model.dof_armature[rows])
        mujoco.mj_comVel(model, data)
        mujoco.mj_rne(model, data, 0, force)
        gravity[index] = force[rows]
        data.qvel[rows] = speeds[index]
        mujoco.mj_comVel(model, data)
        mujoco.mj_rne(model, data, 0, force)
        bias[index] = force[rows] - gravity[index]
    return Moving(poses, mass, gravity, bias), up


def _one(values: Values, index: int) -> dict[str, Value]:
    """One of the configurations."""
    return {
        name: float(every[index]) if every.ndim == 1 else tuple(map(float, every[index]))
        for name, every in values.items()
    }
