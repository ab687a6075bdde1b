"""The robot's own dynamics at many poses at once: what engines must find in the files.

Vectors of motion and force are (angular, linear), in the root link's axes and about its origin. The root is
at rest, and so is what turns as a ball or moves freely: their speeds are no numbers that all formats share.
"""

from dataclasses import dataclass

import numpy as np

from stages.robot.model import Array, Dof, Robot
from stages.robot.pose_batch import Values, count_of, placed
from stages.robot.ways import Ways


@dataclass(frozen=True, slots=True, eq=False)
class Moving:
    """Of `k` dofs at `n` poses. `poses`: root_from_link (n, 4, 4) by link; `mass` (n, k, k): the mass matrix
    without armature; `gravity` (n, k): the forces that hold the weight; `bias` (n, k): those of the
    speeds, Coriolis and centrifugal, without gravity."""

    poses: dict[str, Array]
    mass: Array
    gravity: Array
    bias: Array


def scalar_dofs(robot: Robot) -> list[Dof]:
    """The turns and slides of the tree."""
    return [dof for dof in robot.dofs if dof.kind in ("turn", "slide")]


def dynamics(robot: Robot, values: Values, speeds: Array, up: Array) -> Moving:
    """At `values`, with the `speeds` (n, k) of `scalar_dofs`, against gravity along `up` (n, 3) [m/s²].

    Featherstone, "Rigid Body Dynamics Algorithms" (2008): composite bodies for the mass matrix (6.2), the
    recursive Newton-Euler algorithm (5.3) for the bias.
    """
    poses, frames = placed(robot.root.name, robot.joints, values)
    number, count = {dof.name: at for at, dof in enumerate(scalar_dofs(robot))}, count_of(values)
    bodies = {link.name: _inertias(robot, link.name, poses[link.name]) for link in robot.links}
    carried = dict(bodies)
    for joint in reversed(robot.joints):
        carried[joint.parent] = carried[joint.parent] + carried[joint.child]
    velocities = {robot.root.name: np.zeros((count, 6))}
    drifts = {robot.root.name: np.zeros((count, 6))}
    ways: dict[str, list[tuple[int, Array]]] = {}
    for joint in robot.joints:
        velocity, drift = velocities[joint.parent], drifts[joint.parent]
        ways[joint.child] = []
        for dof in joint.dofs:
            if dof.name in number:
                at = number[dof.name]
                way = _motion(dof, frames[dof.name][0])
                own = way * speeds[:, at, None]
                drift = drift + _crossed(velocity, own)
                velocity = velocity + own
                ways[joint.child].append((at, way))
        velocities[joint.child], drifts[joint.child] = velocity, drift
    mass, gravity, bias = np.zeros((count, len(number), len(number))), *np.zeros((2, count, len(number)))
    forces = {
        name: _times(body, drifts[name]) + _crossed_force(velocities[name], _times(body, velocities[name]))
        for name, body in bodies.items()
    }
    weightless = np.concatenate([np.zeros((count, 3)), up], axis=1)
    above = Ways(robot)
    for joint in reversed(robot.joints):
        for at, way in ways[joint.child]:
            momentum = _times(carried[joint.child], way)
            gravity[:, at] = np.einsum("ni,ni->n", momentum, weightless)
            bias[:, at] = np.einsum("ni,ni->n", way, forces[joint.child])
            for upper in above.up(joint.child):
                for other, its_way in ways[upper.child]:
                    mass[:, at, other] = mass[:, other, at] = np.einsum("ni,ni->n", its_way, momentum)
        forces[joint.parent] = forces[joint.parent] + forces[joint.child]
    return Moving(poses, mass, gravity, bias)


def _inertias(robot: Robot, link: str, pose: Array) -> Array:
    """The inertia (n, 6, 6) of a link about the root's origin."""
    one = robot.link(link).inertial
    turn = pose[:, :3, :3]
    shift = one.mass * _skew(turn @ one.com + pose[:, :3, 3])
    tensor = turn @ one.inertia @ turn.transpose(0, 2, 1)
    out = np.zeros((len(pose), 6, 6))
    if one.mass:
        tensor = tensor - shift @ shift / one.mass
    out[:, :3, :3] = tensor
    out[:, :3, 3:] = shift
    out[:, 3:, :3] = -shift
    out[:, 3:, 3:] = one.mass * np.eye(3)
    return out


def _motion(dof: Dof, before: Array) -> Array:
    """The motion (n, 6) of a unit speed of a dof in the frame `before` (n, 4, 4)."""
    axis: Array = before[:, :3, :3] @ dof.axis
    if dof.kind == "slide":
        return np.concatenate([np.zeros_like(axis), axis], axis=1)
    return np.concatenate([axis, np.cross(before[:, :3, 3], axis)], axis=1)


def _times(bodies: Array, motion: Array) -> Array:
    product: Array = np.einsum("nij,nj->ni", bodies, motion)
    return product


def _crossed(velocity: Array, motion: Array) -> Array:
    """How a motion (n, 6) changes that is carried along with a velocity (n, 6)."""
    turn, shift = np.split(velocity, 2, axis=1)
    first, last = np.split(motion, 2, axis=1)
    return np.concatenate([np.cross(turn, first), np.cross(turn, last) + np.cross(shift, first)], axis=1)


def _crossed_force(velocity: Array, force: Array) -> Array:
    """The same of a force or momentum (n, 6)."""
    turn, shift = np.split(velocity, 2, axis=1)
    first, last = np.split(force, 2, axis=1)
    return np.concatenate([np.cross(turn, first) + np.cross(shift, last), np.cross(turn, last)], axis=1)


def _skew(vectors: Array) -> Array:
    """The matrices (n, 3, 3) of v × ."""
    out = np.zeros((len(vectors), 3, 3))
    x, y, z = vectors.T
    out[:, 0, 1], out[:, 0, 2], out[:, 1, 2] = -z, y, -x
    out[:, 1, 0], out[:, 2, 0], out[:, 2, 1] = z, -y, x
    return out
