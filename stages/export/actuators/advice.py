"""What a user may try with a robot that nothing drives."""

from collections.abc import Sequence

import numpy as np

from linkwright.stages.export.actuators.choices import Wanted, driven_order
from linkwright.stages.export.actuators.loads import postures
from linkwright.stages.robot.dynamics.statics import GRAVITY
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Array, Robot
from linkwright.stages.robot.motion.couplings import Couplings
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.start_pose import home

_MANY = 50
"""Of a robot with more dofs the driver of a follower is not looked for: that takes time by their square."""

NEGLIGIBLE = 1e-6
"""A force is none [N m or N] below this share of the robot's weight (times one metre)."""


def advice(
    robot: Robot, actuation: Actuation, world_from_root: Array, gravity: Sequence[float] = GRAVITY
) -> str:
    """The override that makes a robot hold itself, where at `home` a dof that nothing drives bears more
    weight than its friction holds; "" where none does. Of a dof that follows another it names that other.
    `gravity` (3,) [m/s²]: in the world."""
    if actuation.actuators or not robot.mobility.dof:
        return ""
    fallen = _not_held(robot, world_from_root, gravity)
    if not fallen:
        return ""
    fallen = _driver(robot, fallen)
    return f"nothing holds {fallen} against its weight: try actuators=position"


def _driver(robot: Robot, dof: str) -> str:
    """The dof itself, or of those that `actuators=position` drives the one that moves it the most."""
    follows = robot.loops or any(one.follower == dof for one in robot.relations)
    if not follows or len(robot.dofs) > _MANY:
        return dof
    values = postures(robot)
    couplings = Couplings(robot, values)
    scalar = [one.name for one in robot.dofs if one.kind in ("turn", "slide")]
    wanted = {name: Wanted("position", {}, named=False) for name in scalar}
    driven = couplings.independent(driven_order(robot, wanted, ()))
    if dof in driven:
        return dof
    rates = couplings.moved_by(driven)
    speeds = {name: float(np.abs(moved[dof]).max()) for name, moved in rates.items() if dof in moved}
    return max(speeds, key=lambda name: speeds[name]) if speeds else dof


def _not_held(robot: Robot, world_from_root: Array, gravity: Sequence[float]) -> str:
    """The first such dof from the leaves on: of most robots the first that is looked at."""
    poses = link_poses(robot, home(robot))
    up = -world_from_root[:3, :3].T @ gravity
    weight = {link.name: link.inertial.mass for link in robot.links}
    moment = {
        link.name: weight[link.name] * (poses[link.name] @ np.append(link.inertial.com, 1.0))[:3]
        for link in robot.links
    }
    least = NEGLIGIBLE * sum(weight.values()) * float(np.linalg.norm(up))
    for joint in reversed(robot.joints):
        dof = joint.dofs[-1] if joint.dofs else None
        if dof is not None and dof.kind in ("turn", "slide"):
            pose = poses[joint.child]
            axis = pose[:3, :3] @ dof.axis
            arm = moment[joint.child] - weight[joint.child] * pose[:3, 3]
            force = weight[joint.child] * axis @ up if dof.kind == "slide" else np.cross(axis, arm) @ up
            if abs(force) > least + (dof.dynamics.friction or 0.0):
                return dof.name
        weight[joint.parent] += weight[joint.child]
        moment[joint.parent] = moment[joint.parent] + moment[joint.child]
    return ""
