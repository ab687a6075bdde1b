"""The robot's own dynamics at many poses at once: what engines must find in the files.

Vectors of motion and force are (angular, linear), in the root link's axes and about its origin. The root is
at rest, and so is what turns as a ball or moves freely: their speeds are no numbers that all formats share.
"""

from dataclasses import dataclass

import numpy as np

from linkwright.stages.robot.model.robot import Array, Dof, Inertial, Robot
from linkwright.stages.robot.motion.pose_batch import Values, count_of, cross, placed
from linkwright.stages.robot.motion.tree_paths import Ways

WHOLE = 100
"""Up to this many dofs mass matrices are compared as a whole."""


@dataclass(frozen=True, slots=True, eq=False)
class Moving:
    """Of `k` dofs at `n` poses. `poses`: root_from_link (n, 4, 4) by link; `mass`: the mass matrix without
    armature (n, k, k), or its products with `v` vectors (n, k, v); `gravity` (n, k): the forces that hold the
    weight; `bias` (n, k): those of the speeds, Coriolis and centrifugal, without gravity."""

    poses: dict[str, Array]
    mass: Array
    gravity: Array
    bias: Array


def scalar_dofs(robot: Robot) -> list[Dof]:
    """The turns and slides of the tree."""
    return [dof for dof in robot.dofs if dof.kind in ("turn", "slide")]


def dynamics(robot: Robot, values: Values, speeds: Array, up: Array) -> Moving:
    """At `values`, with the `speeds` (n, k) of `scalar_dofs`, against gravity along `up` (n, 3) [m/s²]."""
    return PosedRobot(robot, values).moving(speeds, up)


class PosedRobot:
    """A robot at many poses: the motions of its dofs, and the inertias that these move.

    Featherstone, "Rigid Body Dynamics Algorithms" (2008): composite bodies for the mass matrix (6.2), the
    recursive Newton-Euler algorithm (5.3) for its products with vectors and for the bias. The whole matrix
    takes work of links times depth, all else of links alone. A large robot's are about its middle instead of
    the root's origin: far from that its many small inertias would lose their digits.
    """

    def __init__(self, robot: Robot, values: Values) -> None:
        self._robot = robot
        self.poses, frames = placed(robot.root.name, robot.joints, values)
        self._count = count_of(values)
        number = {dof.name: at for at, dof in enumerate(scalar_dofs(robot))}
        self._size = len(number)
        middle = np.zeros((self._count, 3))
        if self._size > WHOLE:
            middle = np.mean([pose[:, :3, 3] for pose in self.poses.values()], axis=0)
        self._bodies = {
            link.name: _inertias(link.inertial, self.poses[link.name], middle) for link in robot.links
        }
        self._carried = dict(self._bodies)
        for joint in reversed(robot.joints):
            self._carried[joint.parent] = self._carried[joint.parent] + self._carried[joint.child]
        self._ways = {
            joint.child: [
                (number[dof.name], _motion(dof, frames[dof.name][0], middle))
                for dof in joint.dofs
                if dof.name in number
            ]
            for joint in robot.joints
        }
        self._momenta = [
            (joint.child, at, way, _times(self._carried[joint.child], way))
            for joint in robot.joints
            for at, way in self._ways[joint.child]
        ]

    def moving(self, speeds: Array, up: Array, vectors: Array | None = None) -> Moving:
        """What moves with the `speeds` (n, k), against gravity along `up` (n, 3) [m/s²]. `vectors` (k, v):
        the mass matrix is multiplied by these; None for the whole."""
        mass = self._mass() if vectors is None else self._products(vectors)
        return Moving(self.poses, mass, self.gravity(up), self._bias(speeds))

    def diagonal(self) -> Array:
        """The diagonal (n, k) of the mass matrix."""
        found = np.zeros((self._count, self._size))
        for _, at, way, momentum in self._momenta:
            found[:, at] = np.einsum("ni,ni->n", way, momentum)
        return found

    def _mass(self) -> Array:
        mass = np.zeros((self._count, self._size, self._size))
        above = Ways(self._robot)
        for child, at, _, momentum in self._momenta:
            for upper in above.up(child):
                for other, its_way in self._ways[upper.child]:
                    mass[:, at, other] = mass[:, other, at] = np.einsum("ni,ni->n", its_way, momentum)
        return mass

    def _products(self, vectors: Array) -> Array:
        """The forces (n, k, v) that give the resting mechanism the accelerations `vectors` (k, v)."""
        rest = np.zeros((self._count, 6, vectors.shape[1]))
        gains = {self._robot.root.name: rest}
        for joint in self._robot.joints:
            gain = gains[joint.parent]
            for at, way in self._ways[joint.child]:
                gain = gain + way[:, :, None] * vectors[at]
            gains[joint.child] = gain
        forces = {name: body @ gains[name] for name, body in self._bodies.items()}
        found = np.zeros((self._count, *vectors.shape))
        for joint in reversed(self._robot.joints):
            for at, way in self._ways[joint.child]:
                found[:, at] = np.einsum("ni,niv->nv", way, forces[joint.child])
            forces[joint.parent] = forces[joint.parent] + forces[joint.child]
        return found

    def gravity(self, up: Array) -> Array:
        """The forces (n, k) that hold the weight against gravity along `up` (n, 3) [m/s²]."""
        weightless = np.concatenate([np.zeros((self._count, 3)), up], axis=1)
        found = np.zeros((self._count, self._size))
        for _, at, _, momentum in self._momenta:
            found[:, at] = np.einsum("ni,ni->n", momentum, weightless)
        return found

    def _bias(self, speeds: Array) -> Array:
        root = self._robot.root.name
        velocities, drifts = {root: np.zeros((self._count, 6))}, {root: np.zeros((self._count, 6))}
        for joint in self._robot.joints:
            velocity, drift = velocities[joint.parent], drifts[joint.parent]
            for at, way in self._ways[joint.child]:
                own = way * speeds[:, at, None]
                drift = drift + _crossed(velocity, own)
                velocity = velocity + own
            velocities[joint.child], drifts[joint.child] = velocity, drift
        forces = {
            name: _times(body, drifts[name])
            + _crossed_force(velocities[name], _times(body, velocities[name]))
            for name, body in self._bodies.items()
        }
        found = np.zeros((self._count, self._size))
        for joint in reversed(self._robot.joints):
            for at, way in self._ways[joint.child]:
                found[:, at] = np.einsum("ni,ni->n", way, forces[joint.child])
            forces[joint.parent] = forces[joint.parent] + forces[joint.child]
        return found


def _inertias(one: Inertial, pose: Array, origin: Array) -> Array:
    """The inertia (n, 6, 6) of a link about `origin` (n, 3)."""
    turn = pose[:, :3, :3]
    shift = one.mass * _skew(turn @ one.com + (pose[:, :3, 3] - origin))
    tensor = turn @ one.inertia @ turn.transpose(0, 2, 1)
    out = np.zeros((len(pose), 6, 6))
    if one.mass:
        tensor = tensor - shift @ shift / one.mass
    out[:, :3, :3] = tensor
    out[:, :3, 3:] = shift
    out[:, 3:, :3] = -shift
    out[:, 3:, 3:] = one.mass * np.eye(3)
    return out


def _motion(dof: Dof, before: Array, origin: Array) -> Array:
    """The motion (n, 6) about `origin` (n, 3) of a unit speed of a dof in the frame `before` (n, 4, 4)."""
    axis: Array = before[:, :3, :3] @ dof.axis
    if dof.kind == "slide":
        return np.concatenate([np.zeros_like(axis), axis], axis=1)
    return np.concatenate([axis, cross(before[:, :3, 3] - origin, axis)], axis=1)


def _times(bodies: Array, motion: Array) -> Array:
    product: Array = np.einsum("nij,nj->ni", bodies, motion)
    return product


def _crossed(velocity: Array, motion: Array) -> Array:
    """How a motion (n, 6) changes that is carried along with a velocity (n, 6)."""
    turn, shift = np.split(velocity, 2, axis=1)
    first, last = np.split(motion, 2, axis=1)
    return np.concatenate([cross(turn, first), cross(turn, last) + cross(shift, first)], axis=1)


def _crossed_force(velocity: Array, force: Array) -> Array:
    """The same of a force or momentum (n, 6)."""
    turn, shift = np.split(velocity, 2, axis=1)
    first, last = np.split(force, 2, axis=1)
    return np.concatenate([cross(turn, first) + cross(shift, last), cross(turn, last)], axis=1)


def _skew(vectors: Array) -> Array:
    """The matrices (n, 3, 3) of v × ."""
    out = np.zeros((len(vectors), 3, 3))
    x, y, z = vectors.T
    out[:, 0, 1], out[:, 0, 2], out[:, 1, 2] = -z, y, -x
    out[:, 1, 0], out[:, 2, 0], out[:, 2, 1] = z, -y, x
    return out
