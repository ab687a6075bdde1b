"""Computes the robot's mass matrix at any configuration."""

from collections.abc import Mapping

import numpy as np

from linkwright.stages.robot.dynamics.inertia import moved
from linkwright.stages.robot.model.poses import at_rest, motion
from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Inertial, Joint, Robot
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.tree_paths import TreePaths

SPEEDS = {"turn": 1, "slide": 1, "ball": 3, "free": 6}
"""The number of speeds of a dof, by its kind."""


def mass_matrix(robot: Robot, q: Configuration | None = None) -> Array:
    """Returns M (n, n) of the kinetic energy ½ q̇ᵀ M q̇ at the values `q`; missing values are 0.

    The root link is at rest, every dof of the tree moves on its own, and armature does not count. Rows are
    the speeds of `robot.dofs` in order: a turn [rad/s], a slide [m/s]; of a ball the angular velocity of its
    child in the child's axes; of free motion the velocity in the parent's axes, then the angular velocity
    as of a ball.

    Featherstone's composite-rigid-body algorithm, with all vectors in the root link's axes and about its
    origin: M between a joint and a joint above it is Sₐᵀ I Sᵦ, I the inertia of all that the lower joint
    moves.
    """
    poses = link_poses(robot, q)
    carried = _inertias_below(robot, poses)
    paths = TreePaths(robot)
    motions_by_link: dict[str, tuple[Array, slice]] = {}
    size = sum(SPEEDS[dof.kind] for dof in robot.dofs)
    matrix = np.zeros((size, size))
    end = 0
    for joint in robot.joints:
        motions = _motions(joint, poses[joint.parent], q or {})
        rows = slice(end, end := end + motions.shape[1])
        motions_by_link[joint.child] = (motions, rows)
        momenta = carried[joint.child] @ motions
        for upper in paths.up(joint.child):
            its_motions, its_rows = motions_by_link[upper.child]
            block = its_motions.T @ momenta
            matrix[its_rows, rows] = block
            matrix[rows, its_rows] = block.T
    return matrix


def held_inertias(robot: Robot, q: Configuration | None = None) -> dict[str, Array]:
    """Returns by dof of the tree the inertia (n,) [kg m² or kg] about or along each of its axes, of all links
    that it does not move. These move if its child is held."""
    poses = link_poses(robot, q)
    carried = _inertias_below(robot, poses)
    inertias: dict[str, Array] = {}
    for joint in robot.joints:
        motions = _motions(joint, poses[joint.parent], q or {})
        rest = carried[robot.root.name] - carried[joint.child]
        sizes = np.einsum("in,ij,jn->n", motions, rest, motions)
        ends = np.cumsum([SPEEDS[dof.kind] for dof in joint.dofs])
        inertias |= {dof.name: part for dof, part in zip(joint.dofs, np.split(sizes, ends), strict=False)}
    return inertias


def _inertias_below(robot: Robot, poses: Mapping[str, Array]) -> dict[str, Array]:
    """Returns the inertia (6, 6) about the root link's origin of each link with all links below it."""
    carried = {link.name: _spatial(moved(link.inertial, poses[link.name])) for link in robot.links}
    for joint in reversed(robot.joints):
        carried[joint.parent] = carried[joint.parent] + carried[joint.child]
    return carried


def _spatial(body: Inertial) -> Array:
    """Returns the inertia (6, 6) of a body about the origin: (angular velocity, velocity there) → momenta."""
    shift = body.mass * _cross(body.com)
    out = np.zeros((6, 6))
    out[:3, :3] = body.inertia + shift @ _cross(body.com).T
    out[:3, 3:] = shift
    out[3:, :3] = shift.T
    out[3:, 3:] = body.mass * np.eye(3)
    return out


def _motions(joint: Joint, root_from_parent: Array, q: Configuration) -> Array:
    """Returns the twists (6, n) of a joint's speeds: a column (angular velocity, velocity at the origin) for
    each."""
    columns: list[Array] = []
    frame = root_from_parent @ joint.parent_from_joint
    for dof in joint.dofs:
        frame = frame @ dof.origin
        after = frame @ motion(dof.kind, dof.axis, q.get(dof.name, at_rest(dof.kind)))
        columns += _columns(dof, frame, after)
        frame = after
    return np.array(columns).reshape(-1, 6).T


def _columns(dof: Dof, frame: Array, moved_frame: Array) -> list[Array]:
    """Returns the columns of a dof whose frame is at `frame` and is moved to `moved_frame`."""
    if dof.kind == "slide":
        return [_sliding(frame[:3, :3] @ dof.axis)]
    if dof.kind == "turn":
        return [_turning(frame[:3, :3] @ dof.axis, moved_frame[:3, 3])]
    turns = [_turning(axis, moved_frame[:3, 3]) for axis in moved_frame[:3, :3].T]
    return turns if dof.kind == "ball" else [*map(_sliding, frame[:3, :3].T), *turns]


def _turning(axis: Array, point: Array) -> Array:
    return np.concatenate([axis, np.cross(point, axis)])


def _sliding(axis: Array) -> Array:
    return np.concatenate([np.zeros(3), axis])


def _cross(v: Array) -> Array:
    """Returns the matrix (3, 3) of v × ."""
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
