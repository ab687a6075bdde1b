"""Computes the dynamics of a URDF in Pinocchio. The root is held, and mimic joints move independently."""

import importlib
import importlib.util
from typing import Any

import numpy as np

from linkwright.stages.formats.urdf.names import urdf_names
from linkwright.stages.robot.dynamics.statics import GRAVITY
from linkwright.stages.robot.model.poses import turns_from_rotation
from linkwright.stages.robot.model.robot import Array, Robot
from linkwright.stages.robot.motion.pose_batch import Values, rotations_from_quats
from linkwright.stages.validate.dynamics.tree_dynamics import TreeDynamics, scalar_dofs


def is_pinocchio_installed() -> bool:
    """Tells whether Pinocchio is installed, and not another distribution of that name."""
    if importlib.util.find_spec("pinocchio") is None:
        return False
    return hasattr(importlib.import_module("pinocchio"), "buildModelFromXML")


def pinocchio_dynamics(urdf: bytes, robot: Robot, values: Values, speeds: Array) -> TreeDynamics:
    """Returns Pinocchio's results in the form of `tree_dynamics.dynamics`, with gravity along the root's z
    axis."""
    pin: Any = importlib.import_module("pinocchio")
    model = pin.buildModelFromXML(urdf.decode())
    model.gravity.linear = np.array(GRAVITY)
    data, scalars = model.createData(), scalar_dofs(robot)
    rows = [model.joints[model.getJointId(dof.name)].idx_v for dof in scalars]
    q, v = _configurations(pin, model, robot, values), np.zeros((len(speeds), model.nv))
    v[:, rows] = speeds
    frames = {frame.name: at for at, frame in enumerate(model.frames) if frame.type == pin.FrameType.BODY}
    count, size = speeds.shape
    poses = {link.name: np.empty((count, 4, 4)) for link in robot.links}
    mass, gravity, bias = np.empty((count, size, size)), np.empty((count, size)), np.empty((count, size))
    for index in range(count):
        pin.framesForwardKinematics(model, data, q[index])
        from_root = data.oMf[frames[robot.root.name]].inverse()
        for name, pose in poses.items():
            pose[index] = (from_root * data.oMf[frames[name]]).homogeneous
        upper = np.triu(pin.crba(model, data, q[index]))
        mass[index] = (upper + np.triu(upper, 1).T)[np.ix_(rows, rows)]
        gravity[index] = pin.computeGeneralizedGravity(model, data, q[index])[rows]
        bias[index] = pin.nonLinearEffects(model, data, q[index], v[index])[rows] - gravity[index]
    return TreeDynamics(poses, mass, gravity, bias)


def _configurations(pin: Any, model: Any, robot: Robot, values: Values) -> Array:
    """Returns Pinocchio's q (n, nq). A continuous joint is (cos, sin), and a quaternion ends with w."""
    turns = urdf_names(robot).turns
    count = len(next(iter(values.values())))
    q: Array = np.tile(pin.neutral(model), (count, 1))
    for dof in robot.dofs:
        numbers = values[dof.name]
        columns = {dof.name: numbers}
        if dof.kind == "ball":
            angles = np.array([turns_from_rotation(rotation) for rotation in rotations_from_quats(numbers)])
            columns = dict(zip(turns[dof.name], angles.T, strict=True))
        for name, column in columns.items():
            joint = model.joints[model.getJointId(name)]
            at = slice(joint.idx_q, joint.idx_q + joint.nq)
            if dof.kind == "free":
                q[:, at] = column[:, [0, 1, 2, 4, 5, 6, 3]]
            elif joint.nq == 2:
                q[:, at] = np.column_stack([np.cos(column), np.sin(column)])
            else:
                q[:, at] = column[:, None]
    return q
