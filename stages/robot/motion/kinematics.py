"""Computes the poses of a robot's links at any configuration."""

from collections.abc import Iterable

import numpy as np

from linkwright.stages.robot.model.poses import UNMOVED, at_rest, motion
from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Robot


def link_poses(robot: Robot, q: Configuration | None = None) -> dict[str, Array]:
    """Returns root_from_link (4, 4) of every link at the values `q`; dofs without a value are at rest."""
    poses: dict[str, Array] = {robot.root.name: np.eye(4)}
    for joint in robot.joints:
        poses[joint.child] = poses[joint.parent] @ joint.parent_from_joint @ chain(joint.dofs, q or {})
    return poses


def chain(dofs: Iterable[Dof], q: Configuration) -> Array:
    """Returns the pose (4, 4) of the end of a chain of dofs in the frame of its beginning, at the values `q`;
    dofs without a value are at rest."""
    pose: Array = UNMOVED
    for dof in dofs:
        pose = pose @ dof.origin @ motion(dof.kind, dof.axis, q.get(dof.name, at_rest(dof.kind)))
    return pose


def saved_configuration(robot: Robot) -> Configuration:
    """Returns the values of the tree's dofs at the saved pose."""
    return {dof.name: dof.saved for dof in robot.dofs}


def rest_configuration(robot: Robot) -> Configuration:
    """Returns the values of the tree's dofs at which no dof moves its frame."""
    return {dof.name: at_rest(dof.kind) for dof in robot.dofs}
