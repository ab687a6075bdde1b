"""Advises to add actuators to a robot that its own weight moves."""

from collections.abc import Sequence

import numpy as np

from linkwright.stages.export.actuators.choices import ChosenActuator, driven_order
from linkwright.stages.export.actuators.loads import postures
from linkwright.stages.robot.dynamics.statics import GRAVITY, holding_forces
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Array, Robot
from linkwright.stages.robot.motion.couplings import Couplings
from linkwright.stages.robot.motion.pose_batch import repeated
from linkwright.stages.robot.motion.start_pose import home

_MAX_DOFS = 50
"""Largest number of dofs for which the driver of a follower is looked for: the time grows with the square."""

MIN_WEIGHT_SHARE = 1e-6
"""Smallest force [N m or N] that counts, as a share of the robot's weight (times 1 m for a turn)."""


def advice(
    robot: Robot, actuation: Actuation, world_from_root: Array, gravity: Sequence[float] = GRAVITY
) -> str:
    """Returns the override that makes a robot hold itself, if it has no actuators and at `home` a dof bears
    more weight than its friction holds; else "". For a dof that follows another, the text names the other.
    `gravity` (3,) [m/s²]: in the world."""
    if actuation.actuators or _has_other_actuators(robot) or not robot.mobility.dof:
        return ""
    falling = _falling_dof(robot, world_from_root, gravity)
    if not falling:
        return ""
    falling = _driver(robot, falling)
    return f"nothing holds {falling} against its weight: try actuators=position"


def _has_other_actuators(robot: Robot) -> bool:
    """Returns whether an MJCF source has actuators that do not drive a single joint, such as those of
    tendons."""
    sections = robot.mjcf.sections if robot.mjcf is not None else ()
    return any(section.tag == "actuator" for section in sections)


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
    """Returns the turn or slide furthest from the root that its friction does not hold at `home`, or ""."""
    up = -world_from_root[:3, :3].T @ gravity
    forces = holding_forces(robot, repeated(home(robot), 1), up)
    weight = sum(link.inertial.mass for link in robot.links) * float(np.linalg.norm(up))
    for joint in reversed(robot.joints):
        for dof in reversed(joint.dofs):
            if dof.kind not in ("turn", "slide"):
                continue
            force = abs(float(forces[dof.name][0, 0]))
            if force > MIN_WEIGHT_SHARE * weight + (dof.dynamics.friction or 0.0):
                return dof.name
    return ""
