"""Computes the mass matrix of a robot at any configuration."""

from collections.abc import Mapping

import numpy as np

from linkwright.stages.robot.dynamics.inertia import moved
from linkwright.stages.robot.model.poses import at_rest, motion
from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Inertial, Joint, Robot
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.tree_paths import TreePaths

SPEEDS = {"turn": 1, "slide": 1, "ball": 3, "free": 6}
"""Kind of a dof → the number of its speeds."""


def mass_matrix(robot: Robot, q: Configuration | None = None) -> Array:
    """Returns M (n, n) of the kinetic energy ½ q̇ᵀ M q̇ at the values `q`; dofs without a value are at rest.

    The root link does not move, every dof of the tree moves on its own, and armature does not count. Rows are
    the speeds of `robot.dofs` in order: of a turn [rad/s], of a slide [m/s], of a ball the angular velocity
    (3 rows) in the axes of its child; of free motion the velocity of the child in the axes of the dof's frame
    (3 rows), then the angular velocity as of a ball.

    This is Featherstone's composite-rigid-body algorithm, with all vectors in the axes of the root link and
    about its origin. The block of a joint a and a joint b at or below it is Sₐᵀ I Sᵦ, where I is the inertia
    of all links that b moves.
    """
    poses = link_poses(robot, q)
    inertias = _inertias_below(robot, poses)
    paths = TreePaths(robot)
    motions_by_link: dict[str, tuple[Array, slice]] = {}
    size = sum(SPEEDS[dof.kind] for dof in robot.dofs)
    matrix = np.zeros((size, size))
    end = 0
    for joint in robot.joints:
        motions = _motions(joint, poses[joint.parent], q or {})
        rows = slice(end, end := end + motions.shape[1])
        motions_by_link[joint.child] = (motions, rows)
        momenta = inertias[joint.child] @ motions
        # This joint is the first on the path.
        for upper in paths.up(joint.child):
            upper_motions, upper_rows = motions_by_link[upper.child]
            block = upper_motions.T @ momenta
            matrix[upper_rows, rows] = block
            matrix[rows, upper_rows] = block.T
    return matrix


def held_inertias(robot: Robot, q: Configuration | None = None) -> dict[str, Array]:
    """Returns by dof of the tree the inertia (n,) [kg m² or kg], about or along each of its axes, of all
    links that its joint does not move: these move if the child is held. `q`: as for `mass_matrix`."""
    poses = link_poses(robot, q)
    inertias_below = _inertias_below(robot, poses)
    inertias: dict[str, Array] = {}
    for joint in robot.joints:
        motions = _motions(joint, poses[joint.parent], q or {})
        rest = inertias_below[robot.root.name] - inertias_below[joint.child]
        diagonal = np.einsum("in,ij,jn->n", motions, rest, motions)
        ends = np.cumsum([SPEEDS[dof.kind] for dof in joint.dofs])
        # After the last end, np.split has an empty part without a dof.
        inertias |= {dof.name: part for dof, part in zip(joint.dofs, np.split(diagonal, ends), strict=False)}
    return inertias


def _inertias_below(robot: Robot, poses: Mapping[str, Array]) -> dict[str, Array]:
    """Returns the spatial inertia (6, 6) of each link with all links below it, about the origin of the root
    link."""
    inertias = {link.name: _spatial_inertia(moved(link.inertial, poses[link.name])) for link in robot.links}
    for joint in reversed(robot.joints):
        inertias[joint.parent] = inertias[joint.parent] + inertias[joint.child]
    return inertias


def _spatial_inertia(inertial: Inertial) -> Array:
    """Returns the inertia (6, 6) of a body about the origin. It maps (angular velocity, velocity of the
    body's point at the origin) to (angular momentum, momentum)."""
    shift = inertial.mass * _cross_matrix(inertial.com)
    matrix = np.zeros((6, 6))
    matrix[:3, :3] = inertial.inertia + shift @ _cross_matrix(inertial.com).T
    matrix[:3, 3:] = shift
    matrix[3:, :3] = shift.T
    matrix[3:, 3:] = inertial.mass * np.eye(3)
    return matrix


def _motions(joint: Joint, root_from_parent: Array, q: Configuration) -> Array:
    """Returns the twists (6, n) of unit speeds of a joint: columns (angular velocity, velocity at the
    origin)."""
    columns: list[Array] = []
    frame = root_from_parent @ joint.parent_from_joint
    for dof in joint.dofs:
        frame = frame @ dof.origin
        moved_frame = frame @ motion(dof.kind, dof.axis, q.get(dof.name, at_rest(dof.kind)))
        columns += _dof_twists(dof, frame, moved_frame)
        frame = moved_frame
    return np.array(columns).reshape(-1, 6).T


def _dof_twists(dof: Dof, frame: Array, moved_frame: Array) -> list[Array]:
    """Returns the twists (6,) of unit speeds of a dof, which moves its frame from `frame` to
    `moved_frame`."""
    if dof.kind == "slide":
        return [_slide_twist(frame[:3, :3] @ dof.axis)]
    if dof.kind == "turn":
        return [_turn_twist(frame[:3, :3] @ dof.axis, moved_frame[:3, 3])]
    turns = [_turn_twist(axis, moved_frame[:3, 3]) for axis in moved_frame[:3, :3].T]
    return turns if dof.kind == "ball" else [*map(_slide_twist, frame[:3, :3].T), *turns]


def _turn_twist(axis: Array, point: Array) -> Array:
    return np.concatenate([axis, np.cross(point, axis)])


def _slide_twist(axis: Array) -> Array:
    return np.concatenate([np.zeros(3), axis])


def _cross_matrix(vector: Array) -> Array:
    """Returns the matrix (3, 3) that maps a vector w to `vector` × w."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
