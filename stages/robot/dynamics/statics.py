"""Computes the forces that hold a robot's weight, at many configurations at once."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from linkwright.stages.robot.model.robot import Array, Dof, Robot
from linkwright.stages.robot.motion.pose_batch import Values, count_of, poses_and_frames

GRAVITY = (0.0, 0.0, -9.81)
"""MuJoCo's default gravity [m/s²], in the world's axes."""


@dataclass(frozen=True, slots=True, eq=False)
class GroundSupport:
    """A point of a link, such as a foot, at which the ground carries weight."""

    link: str
    point: Array
    """Position (3,) [m] in the frame of the root link."""
    mass: float
    """Mass [kg] whose weight the ground carries there."""


def holding_forces(
    robot: Robot, values: Values, up: Array, support: float = 0.0, ground: Sequence[GroundSupport] = ()
) -> dict[str, Array]:
    """Returns the force (n, 1) [N m or N] of each dof of the tree that holds the weight of all links that the
    dof moves; for a ball it is the torque (n, 3) in its child's axes. The root is held, and free motion is
    left out.

    `up` (3,) [m/s²]: the opposite of gravity, in the axes of the root link. `support`: if above 0, the child
    of the dof's joint is held instead of the root, and the dof holds this share of the weight of all other
    links, as in a leg on the ground. `ground`: points at which the ground carries weight, as if the mass were
    taken away there.
    """
    poses, frames = poses_and_frames(robot.root.name, robot.joints, values)
    count = count_of(values)
    masses = {link.name: np.full(count, link.inertial.mass) for link in robot.links}
    moments = {
        link.name: link.inertial.mass * (poses[link.name] @ np.append(link.inertial.com, 1.0))[:, :3]
        for link in robot.links
    }
    for contact in ground:
        masses[contact.link] = masses[contact.link] - contact.mass
        moments[contact.link] = moments[contact.link] - contact.mass * contact.point
    # From here on, those of each link with all links below it.
    for joint in reversed(robot.joints):
        masses[joint.parent] = masses[joint.parent] + masses[joint.child]
        moments[joint.parent] = moments[joint.parent] + moments[joint.child]
    total_mass, total_moment = masses[robot.root.name], moments[robot.root.name]
    forces: dict[str, Array] = {}
    for joint in robot.joints:
        mass, moment = masses[joint.child], moments[joint.child]
        if support:
            # The other links move the opposite way if the child is held.
            mass, moment = support * (mass - total_mass), support * (moment - total_moment)
        for dof in joint.dofs:
            if dof.kind != "free":
                forces[dof.name] = _power(dof, *frames[dof.name], mass, moment, up)
    return forces


def _power(dof: Dof, frame: Array, moved_frame: Array, mass: Array, moment: Array, up: Array) -> Array:
    """Returns the power (n, 1 or 3) against gravity at unit speeds of a dof, which is the force that holds
    the load. `mass` (n,) [kg] and `moment` (n, 3) [kg m]: Σ m and Σ m x of the links that the dof moves."""
    axis = frame[:, :3, :3] @ dof.axis
    if dof.kind == "slide":
        slide_power: Array = (mass * (axis @ up))[:, None]
        return slide_power
    axes = axis[:, :, None] if dof.kind == "turn" else moved_frame[:, :3, :3]
    arm = moment - mass[:, None] * moved_frame[:, :3, 3]
    turn_power: Array = np.einsum("i,nij->nj", up, np.cross(axes, arm[:, :, None], axis=1))
    return turn_power
