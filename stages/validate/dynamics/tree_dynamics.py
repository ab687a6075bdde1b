"""Computes the robot's dynamics at many poses at once, as the reference for engines.

Vectors of motion and force are (angular, linear), in the root link's axes and about its origin. The root is
at rest, and so are balls and free joints, since formats count their speeds differently.
"""

from dataclasses import dataclass

import numpy as np

from linkwright.stages.robot.model.robot import Array, Dof, Inertial, Robot
from linkwright.stages.robot.motion.pose_batch import Values, count_of, cross, poses_and_frames
from linkwright.stages.robot.motion.tree_paths import TreePaths

MAX_WHOLE_DOFS = 100
"""Largest number of dofs for which whole mass matrices are compared."""


@dataclass(frozen=True, slots=True, eq=False)
class TreeDynamics:
    """The dynamics of k dofs at n poses."""

    poses: dict[str, Array]
    """root_from_link (n, 4, 4) by link."""

    mass: Array
    """The mass matrix without armature (n, k, k), or its products with v vectors (n, k, v)."""

    gravity: Array
    """The forces (n, k) that hold the weight."""

    bias: Array
    """The Coriolis and centrifugal forces (n, k) of the speeds, without gravity."""


def scalar_dofs(robot: Robot) -> list[Dof]:
    """Returns the turns and slides of the tree."""
    return [dof for dof in robot.dofs if dof.kind in ("turn", "slide")]


def dynamics(robot: Robot, values: Values, speeds: Array, up: Array) -> TreeDynamics:
    """Returns the dynamics at `values`, with the `speeds` (n, k) of `scalar_dofs`, against gravity along `up`
    (n, 3) [m/s²]."""
    return PosedRobot(robot, values).dynamics(speeds, up)


class PosedRobot:
    """A robot at many poses: the motions of its dofs, and the inertias that these move.

    The algorithms are those of Featherstone, "Rigid Body Dynamics Algorithms" (2008): composite bodies for
    the mass matrix (6.2), and the recursive Newton-Euler algorithm (5.3) for its products with vectors and
    for the bias. The time for the whole matrix grows with links times depth, for all else with links.
    Inertias of a large robot are about its middle instead of the root's origin, since far from the origin its
    many small inertias would lose their digits.
    """

    def __init__(self, robot: Robot, values: Values) -> None:
        self._robot = robot
        self.poses, frames = poses_and_frames(robot.root.name, robot.joints, values)
        self._count = count_of(values)
        number = {dof.name: at for at, dof in enumerate(scalar_dofs(robot))}
        self._size = len(number)
        middle = np.zeros((self._count, 3))
        if self._size > MAX_WHOLE_DOFS:
            middle = np.mean([pose[:, :3, 3] for pose in self.poses.values()], axis=0)
        self._link_inertias = {
            link.name: _spatial_inertias(link.inertial, self.poses[link.name], middle) for link in robot.links
        }
        self._composite_inertias = dict(self._link_inertias)
        for joint in reversed(robot.joints):
            self._composite_inertias[joint.parent] = (
                self._composite_inertias[joint.parent] + self._composite_inertias[joint.child]
            )
        self._screws = {
            joint.child: [
                (number[dof.name], _unit_motion(dof, frames[dof.name][0], middle))
                for dof in joint.dofs
                if dof.name in number
            ]
            for joint in robot.joints
        }
        self._momenta = [
            (joint.child, at, screw, _inertia_times(self._composite_inertias[joint.child], screw))
            for joint in robot.joints
            for at, screw in self._screws[joint.child]
        ]

    def dynamics(self, speeds: Array, up: Array, vectors: Array | None = None) -> TreeDynamics:
        """Returns the dynamics with the `speeds` (n, k), against gravity along `up` (n, 3) [m/s²]. `vectors`
        (k, v): the mass matrix is replaced by its products with these; None for the whole matrix."""
        mass = self._mass() if vectors is None else self._products(vectors)
        return TreeDynamics(self.poses, mass, self.gravity(up), self._bias(speeds))

    def diagonal(self) -> Array:
        """Returns the diagonal (n, k) of the mass matrix."""
        diagonal = np.zeros((self._count, self._size))
        for _, at, screw, momentum in self._momenta:
            diagonal[:, at] = np.einsum("ni,ni->n", screw, momentum)
        return diagonal

    def _mass(self) -> Array:
        mass = np.zeros((self._count, self._size, self._size))
        above = TreePaths(self._robot)
        for child, at, _, momentum in self._momenta:
            for upper in above.up(child):
                for other, upper_screw in self._screws[upper.child]:
                    mass[:, at, other] = mass[:, other, at] = np.einsum("ni,ni->n", upper_screw, momentum)
        return mass

    def _products(self, vectors: Array) -> Array:
        """Returns the forces (n, k, v) that give the resting mechanism the accelerations `vectors` (k, v)."""
        zeros = np.zeros((self._count, 6, vectors.shape[1]))
        accelerations = {self._robot.root.name: zeros}
        for joint in self._robot.joints:
            acceleration = accelerations[joint.parent]
            for at, screw in self._screws[joint.child]:
                acceleration = acceleration + screw[:, :, None] * vectors[at]
            accelerations[joint.child] = acceleration
        forces = {name: body @ accelerations[name] for name, body in self._link_inertias.items()}
        products = np.zeros((self._count, *vectors.shape))
        for joint in reversed(self._robot.joints):
            for at, screw in self._screws[joint.child]:
                products[:, at] = np.einsum("ni,niv->nv", screw, forces[joint.child])
            forces[joint.parent] = forces[joint.parent] + forces[joint.child]
        return products

    def gravity(self, up: Array) -> Array:
        """Returns the forces (n, k) that hold the weight against gravity along `up` (n, 3) [m/s²]."""
        # Holding a body against gravity takes the same force as accelerating it upwards.
        upward_acceleration = np.concatenate([np.zeros((self._count, 3)), up], axis=1)
        gravity = np.zeros((self._count, self._size))
        for _, at, _, momentum in self._momenta:
            gravity[:, at] = np.einsum("ni,ni->n", momentum, upward_acceleration)
        return gravity

    def _bias(self, speeds: Array) -> Array:
        root = self._robot.root.name
        velocities, drifts = {root: np.zeros((self._count, 6))}, {root: np.zeros((self._count, 6))}
        for joint in self._robot.joints:
            velocity, drift = velocities[joint.parent], drifts[joint.parent]
            for at, screw in self._screws[joint.child]:
                own_velocity = screw * speeds[:, at, None]
                drift = drift + _cross_motion(velocity, own_velocity)
                velocity = velocity + own_velocity
            velocities[joint.child], drifts[joint.child] = velocity, drift
        forces = {
            name: _inertia_times(body, drifts[name])
            + _cross_force(velocities[name], _inertia_times(body, velocities[name]))
            for name, body in self._link_inertias.items()
        }
        bias = np.zeros((self._count, self._size))
        for joint in reversed(self._robot.joints):
            for at, screw in self._screws[joint.child]:
                bias[:, at] = np.einsum("ni,ni->n", screw, forces[joint.child])
            forces[joint.parent] = forces[joint.parent] + forces[joint.child]
        return bias


def _spatial_inertias(inertial: Inertial, pose: Array, origin: Array) -> Array:
    """Returns the inertia (n, 6, 6) of a link about `origin` (n, 3)."""
    turn = pose[:, :3, :3]
    shift = inertial.mass * _skew(turn @ inertial.com + (pose[:, :3, 3] - origin))
    tensor = turn @ inertial.inertia @ turn.transpose(0, 2, 1)
    matrices = np.zeros((len(pose), 6, 6))
    if inertial.mass:
        # The parallel axis theorem: m [c]ᵀ [c], where `shift` is m [c].
        tensor = tensor - shift @ shift / inertial.mass
    matrices[:, :3, :3] = tensor
    matrices[:, :3, 3:] = shift
    matrices[:, 3:, :3] = -shift
    matrices[:, 3:, 3:] = inertial.mass * np.eye(3)
    return matrices


def _unit_motion(dof: Dof, before: Array, origin: Array) -> Array:
    """Returns the motion (n, 6) about `origin` (n, 3) of a unit speed of a dof in the frame `before` (n, 4,
    4)."""
    axis: Array = before[:, :3, :3] @ dof.axis
    if dof.kind == "slide":
        return np.concatenate([np.zeros_like(axis), axis], axis=1)
    return np.concatenate([axis, cross(before[:, :3, 3] - origin, axis)], axis=1)


def _inertia_times(bodies: Array, motion: Array) -> Array:
    product: Array = np.einsum("nij,nj->ni", bodies, motion)
    return product


def _cross_motion(velocity: Array, motion: Array) -> Array:
    """Returns the change of a motion (n, 6) that is carried along with a velocity (n, 6)."""
    turn, shift = np.split(velocity, 2, axis=1)
    first, last = np.split(motion, 2, axis=1)
    return np.concatenate([cross(turn, first), cross(turn, last) + cross(shift, first)], axis=1)


def _cross_force(velocity: Array, force: Array) -> Array:
    """Returns the change of a force or momentum (n, 6) that is carried along with a velocity (n, 6)."""
    turn, shift = np.split(velocity, 2, axis=1)
    first, last = np.split(force, 2, axis=1)
    return np.concatenate([cross(turn, first) + cross(shift, last), cross(turn, last)], axis=1)


def _skew(vectors: Array) -> Array:
    """Returns the matrices (n, 3, 3) of the cross products v × ."""
    matrices = np.zeros((len(vectors), 3, 3))
    x, y, z = vectors.T
    matrices[:, 0, 1], matrices[:, 0, 2], matrices[:, 1, 2] = -z, y, -x
    matrices[:, 1, 0], matrices[:, 2, 0], matrices[:, 2, 1] = z, -y, x
    return matrices
