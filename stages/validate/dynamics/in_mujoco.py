"""Computes poses, mass matrices and forces of a compiled model in MuJoCo, without contact and armature."""

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import body_index, joint_index
from linkwright.stages.robot.dynamics.statics import GRAVITY
from linkwright.stages.robot.model.robot import Array, Robot, Value
from linkwright.stages.robot.motion.pose_batch import Values
from linkwright.stages.validate.dynamics.tree_dynamics import TreeDynamics, scalar_dofs
from linkwright.stages.validate.model.coordinates import body_from_link, link_pose, root_pose, set_values


def mujoco_dynamics(
    model: Any, robot: Robot, values: Values, speeds: Array, vectors: Array | None, urdf: bool
) -> tuple[TreeDynamics, Array]:
    """Returns MuJoCo's results in the form of `PosedRobot.dynamics`, and the direction against gravity (n, 3)
    in the root's axes, which a scene may turn."""
    saved_options = model.opt.gravity.copy(), int(model.opt.disableflags)
    model.opt.gravity[:], model.opt.disableflags = GRAVITY, 0
    try:
        return _computed_dynamics(model, robot, values, speeds, vectors, urdf)
    finally:
        model.opt.gravity[:], model.opt.disableflags = saved_options


def _computed_dynamics(
    model: Any, robot: Robot, values: Values, speeds: Array, vectors: Array | None, urdf: bool
) -> tuple[TreeDynamics, Array]:
    data = mujoco.MjData(model)
    joints = [joint_index(model, dof.name) for dof in scalar_dofs(robot)]
    rows, places = model.jnt_dofadr[joints], model.jnt_qposadr[joints]
    has_only_scalars = {dof.name for dof in scalar_dofs(robot)} == {dof.name for dof in robot.dofs}
    count, size = speeds.shape
    poses = np.empty((len(robot.links), count, 4, 4))
    mass = np.empty((count, size, size if vectors is None else vectors.shape[1]))
    gravity, bias, up = np.empty((count, size)), np.empty((count, size)), np.empty((count, 3))
    force = np.empty(model.nv)
    loops = {dof.name: dof.saved for loop in robot.loops for dof in loop.dofs}
    link_poses_of = _link_pose_reader(model, robot)
    mujoco.mj_resetData(model, data)
    for index in range(count):
        if has_only_scalars and not loops:
            data.qpos[places] = [values[dof.name][index] for dof in robot.dofs]
        else:
            set_values(model, data, robot, loops | _configuration(values, index), urdf)
        data.qvel[:] = 0
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        world_from_root = root_pose(model, data, robot)
        poses[:, index] = np.linalg.inv(world_from_root) @ link_poses_of(data)
        up[index] = -world_from_root[:3, :3].T @ GRAVITY
        mass[index] = (
            _mass_matrix(model, data, rows) if vectors is None else _mass_products(model, data, rows, vectors)
        )
        mujoco.mj_comVel(model, data)
        mujoco.mj_rne(model, data, 0, force)
        gravity[index] = force[rows]
        data.qvel[rows] = speeds[index]
        mujoco.mj_comVel(model, data)
        mujoco.mj_rne(model, data, 0, force)
        bias[index] = force[rows] - gravity[index]
    by_link = {link.name: poses[at] for at, link in enumerate(robot.links)}
    return TreeDynamics(by_link, mass, gravity, bias), up


def _mass_matrix(model: Any, data: Any, rows: Array) -> Array:
    """Returns the mass matrix (k, k) of these rows, without the armature of their joints."""
    mujoco.mj_makeM(model, data)
    mass, column = np.empty((len(rows), len(rows))), np.empty(model.nv)
    for row, unit in enumerate(np.eye(model.nv)[rows]):
        mujoco.mj_mulM(model, data, column, unit)
        mass[row] = column[rows]
    mass -= np.diag(model.dof_armature[rows])
    return mass


def _mass_products(model: Any, data: Any, rows: Array, vectors: Array) -> Array:
    """Returns the products (k, v) of the mass matrix with the vectors (k, v): the forces of such
    accelerations, at rest and without gravity."""
    products, force = np.empty(vectors.shape), np.empty(model.nv)
    model.opt.gravity[:] = 0.0
    data.qacc[:] = 0.0
    mujoco.mj_comVel(model, data)
    for at, vector in enumerate(vectors.T):
        data.qacc[rows] = vector
        mujoco.mj_rne(model, data, 1, force)
        products[:, at] = force[rows]
    model.opt.gravity[:] = GRAVITY
    return products


def _link_pose_reader(model: Any, robot: Robot) -> Callable[[Any], Array]:
    """Returns a function that returns world_from_link (links, 4, 4) of every link, in order. It is
    `link_pose` for all links at once."""
    bodies = np.array([body_index(model, link.name) for link in robot.links])
    has_body = bodies >= 0
    by_site = [at for at, link in enumerate(robot.links) if not has_body[at] or link.name == robot.root.name]
    bodies = np.where(has_body, bodies, 0)
    body_from_link_poses = np.array([body_from_link(robot, link.name) for link in robot.links])

    def read(data: Any) -> Array:
        poses = np.zeros((len(bodies), 4, 4))
        poses[:, :3, :3] = data.xmat[bodies].reshape(-1, 3, 3)
        poses[:, :3, 3], poses[:, 3, 3] = data.xpos[bodies], 1.0
        poses = np.asarray(poses @ body_from_link_poses)
        for at in by_site:
            poses[at] = link_pose(model, data, robot, robot.links[at].name)
        return poses

    return read


def _configuration(values: Values, index: int) -> dict[str, Value]:
    """Returns the configuration at an index of the values."""
    return {
        name: float(numbers[index]) if numbers.ndim == 1 else tuple(map(float, numbers[index]))
        for name, numbers in values.items()
    }
