"""Advises to add actuators to a robot that its own weight moves."""

from collections.abc import Sequence

import numpy as np

from linkwright.stages.export.actuators.choices import ChosenActuator, driven_order
from linkwright.stages.export.actuators.loads import postures
from linkwright.stages.robot.dynamics.statics import GRAVITY
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Array, Robot
from linkwright.stages.robot.motion.couplings import Couplings
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.start_pose import home

_MAX_DOFS = 50
"""Largest number of dofs for which the driver of a follower is looked for: the time grows with the square."""

NEGLIGIBLE = 1e-6
"""Forces [N m or N] below this share of the robot's weight (times 1 m) count as zero."""


def advice(
    robot: Robot, actuation: Actuation, world_from_root: Array, gravity: Sequence[float] = GRAVITY
) -> str:
    """Returns the override that makes a robot hold itself, if it has no actuators and at `home` a dof bears
    more weight than its friction holds; else "". For a dof that follows another, the text names the other.
    `gravity` (3,) [m/s²]: in the world."""
    if actuation.actuators or not robot.mobility.dof:
        return ""
    falling = _falling_dof(robot, world_from_root, gravity)
    if not falling:
        return ""
    falling = _driver(robot, falling)
    return f"nothing holds {falling} against its weight: try actuators=position"


def _driver(robot: Robot, dof: str) -> str:
    """Returns the dof itself if `actuators=position` drives it, else the driven dof that moves it the
    most."""
    follows = robot.loops or any(relation.follower == dof for relation in robot.relations)
    if not follows or len(robot.dofs) > _MAX_DOFS:
        return dof
    values = postures(robot)
    couplings = Couplings(robot, values)
    scalar_dofs = [dof.name for dof in robot.dofs if dof.kind in ("turn", "slide")]
    choices = {name: ChosenActuator("position", {}, named=False) for name in scalar_dofs}
    driven = couplings.independent(driven_order(robot, choices, ()))
    if dof in driven:
        return dof
    rates = couplings.moved_by(driven)
    speeds = {name: float(np.abs(moved[dof]).max()) for name, moved in rates.items() if dof in moved}
    return max(speeds, key=lambda name: speeds[name]) if speeds else dof


def _falling_dof(robot: Robot, world_from_root: Array, gravity: Sequence[float]) -> str:
    """Returns the first dof that its friction does not hold, or "". The search starts at the leaves, where
    most robots have such a dof."""
    poses = link_poses(robot, home(robot))
    up = -world_from_root[:3, :3].T @ gravity
    weight = {link.name: link.inertial.mass for link in robot.links}
    moment = {
        link.name: weight[link.name] * (poses[link.name] @ np.append(link.inertial.com, 1.0))[:3]
        for link in robot.links
    }
    tolerance = NEGLIGIBLE * sum(weight.values()) * float(np.linalg.norm(up))
    for joint in reversed(robot.joints):
        dof = joint.dofs[-1] if joint.dofs else None
        if dof is not None and dof.kind in ("turn", "slide"):
            pose = poses[joint.child]
            axis = pose[:3, :3] @ dof.axis
            arm = moment[joint.child] - weight[joint.child] * pose[:3, 3]
            force = weight[joint.child] * axis @ up if dof.kind == "slide" else np.cross(axis, arm) @ up
            if abs(force) > tolerance + (dof.dynamics.friction or 0.0):
                return dof.name
        weight[joint.parent] += weight[joint.child]
        moment[joint.parent] = moment[joint.parent] + moment[joint.child]
    return ""
