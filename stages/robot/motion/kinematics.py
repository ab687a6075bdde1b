"""Computes the poses of a robot's links at any configuration."""

from collections.abc import Iterable

import numpy as np

from linkwright.stages.robot.model.poses import UNMOVED, at_rest, motion
from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Robot


def link_poses(robot: Robot, q: Configuration | None = None) -> dict[str, Array]:
    """Returns root_from_link (4, 4) of every link at the values `q`; missing values are 0 (no motion)."""
    poses: dict[str, Array] = {robot.root.name: np.eye(4)}
    for joint in robot.joints:
        poses[joint.child] = poses[joint.parent] @ joint.parent_from_joint @ chain(joint.dofs, q or {})
    return poses


def chain(dofs: Iterable[Dof], q: Configuration) -> Array:
    """Returns before_from_after (4, 4) of a chain of dofs at the values `q`; missing values are 0."""
    pose: Array = UNMOVED
    for dof in dofs:
        pose = pose @ dof.origin @ motion(dof.kind, dof.axis, q.get(dof.name, at_rest(dof.kind)))
    return pose


def saved_configuration(robot: Robot) -> Configuration:
    """Returns the values of the saved pose."""
    return {dof.name: dof.saved for dof in robot.dofs}


def rest_configuration(robot: Robot) -> Configuration:
    """Returns the configuration in which every value is zero: no motion."""
    return {dof.name: at_rest(dof.kind) for dof in robot.dofs}
