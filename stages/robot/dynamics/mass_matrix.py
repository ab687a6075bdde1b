"""The robot's own dynamics: its mass matrix at any configuration."""

from collections.abc import Mapping

import numpy as np

from linkwright.stages.robot.dynamics.inertia import moved
from linkwright.stages.robot.model.poses import at_rest, motion
from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Inertial, Joint, Robot
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.tree_paths import Ways

SPEEDS = {"turn": 1, "slide": 1, "ball": 3, "free": 6}
"""How many speeds a dof has, by its kind."""


def mass_matrix(robot: Robot, q: Configuration | None = None) -> Array:
    """M (n, n) of the kinetic energy ½ q̇ᵀ M q̇ at the values `q`; a missing one is 0.

    The root link is at rest, every dof of the tree moves on its own, and armature does not count. Rows are
    the speeds of `robot.dofs` in order: a turn [rad/s], a slide [m/s]; of a ball the angular velocity of its
    child in the child's axes; of free motion the velocity in the parent's axes, then the angular velocity
    as of a ball.

    Featherstone's composite-rigid-body algorithm, with all vectors in the root link's axes and about its
    origin: M between a joint and one above it is Sₐᵀ I Sᵦ, I the inertia of all that the lower joint moves.
    """
    poses = link_poses(robot, q)
    carried = _carried(robot, poses)
    ways = Ways(robot)
    made: dict[str, tuple[Array, slice]] = {}
    size = sum(SPEEDS[dof.kind] for dof in robot.dofs)
    matrix = np.zeros((size, size))
    end = 0
    for joint in robot.joints:
        motions = _motions(joint, poses[joint.parent], q or {})
        rows = slice(end, end := end + motions.shape[1])
        made[joint.child] = (motions, rows)
        momenta = carried[joint.child] @ motions
        for upper in ways.up(joint.child):
            its_motions, its_rows = made[upper.child]
            block = its_motions.T @ momenta
            matrix[its_rows, rows] = block
            matrix[rows, its_rows] = block.T
    return matrix


def held_inertias(robot: Robot, q: Configuration | None = None) -> dict[str, Array]:
    """By dof of the tree: the inertia (n,) [kg m² or kg] about or along each of its axes of all that it does
    not move, which is what moves where its child is held."""
    poses = link_poses(robot, q)
    carried = _carried(robot, poses)
    inertias: dict[str, Array] = {}
    for joint in robot.joints:
        motions = _motions(joint, poses[joint.parent], q or {})
        rest = carried[robot.root.name] - carried[joint.child]
        sizes = np.einsum("in,ij,jn->n", motions, rest, motions)
        ends = np.cumsum([SPEEDS[dof.kind] for dof in joint.dofs])
        inertias |= {dof.name: part for dof, part in zip(joint.dofs, np.split(sizes, ends), strict=False)}
    return inertias


def _carried(robot: Robot, poses: Mapping[str, Array]) -> dict[str, Array]:
    """By link: the inertia (6, 6) about the root link's origin of it and all below it."""
    carried = {link.name: _spatial(moved(link.inertial, poses[link.name])) for link in robot.links}
    for joint in reversed(robot.joints):
        carried[joint.parent] = carried[joint.parent] + carried[joint.child]
    return carried


def _spatial(body: Inertial) -> Array:
    """The inertia (6, 6) of a body about the origin: (angular velocity, velocity there) → momenta."""
    shift = body.mass * _cross(body.com)
    out = np.zeros((6, 6))
    out[:3, :3] = body.inertia + shift @ _cross(body.com).T
    out[:3, 3:] = shift
    out[3:, :3] = shift.T
    out[3:, 3:] = body.mass * np.eye(3)
    return out


def _motions(joint: Joint, root_from_parent: Array, q: Configuration) -> Array:
    """What a joint's speeds move (6, n): a column (angular velocity, velocity at the origin) for each."""
    columns: list[Array] = []
    before = root_from_parent @ joint.parent_from_joint
    for dof in joint.dofs:
        before = before @ dof.origin
        after = before @ motion(dof.kind, dof.axis, q.get(dof.name, at_rest(dof.kind)))
        columns += _columns(dof, before, after)
        before = after
    return np.array(columns).reshape(-1, 6).T


def _columns(dof: Dof, before: Array, after: Array) -> list[Array]:
    """The columns of a dof whose frame stands at `before` and is moved to `after`."""
    if dof.kind == "slide":
        return [_sliding(before[:3, :3] @ dof.axis)]
    if dof.kind == "turn":
        return [_turning(before[:3, :3] @ dof.axis, after[:3, 3])]
    turns = [_turning(axis, after[:3, 3]) for axis in after[:3, :3].T]
    return turns if dof.kind == "ball" else [*map(_sliding, before[:3, :3].T), *turns]


def _turning(axis: Array, point: Array) -> Array:
    return np.concatenate([axis, np.cross(point, axis)])


def _sliding(axis: Array) -> Array:
    return np.concatenate([np.zeros(3), axis])


def _cross(v: Array) -> Array:
    """The matrix (3, 3) of v × ."""
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
