"""Computes the forces that hold a robot's weight, at many configurations at once."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from linkwright.stages.robot.model.robot import Array, Dof, Robot
from linkwright.stages.robot.motion.pose_batch import Values, count_of, poses_and_frames

GRAVITY = (0.0, 0.0, -9.81)
"""MuJoCo's default gravity [m/s²]."""


@dataclass(frozen=True, slots=True, eq=False)
class GroundSupport:
    """A point of a link that the ground carries."""

    link: str
    point: Array
    """Position (3,) [m] in the root link's axes."""
    mass: float
    """Mass [kg] whose weight it bears."""


def holding_forces(
    robot: Robot, values: Values, up: Array, support: float = 0.0, ground: Sequence[GroundSupport] = ()
) -> dict[str, Array]:
    """Returns the force (n, 1) [N m or N] by dof of the tree, for a ball the torque (n, 3) in its child's
    axes, that holds the weight of all links that the dof moves; dofs do not share loads, and the root is
    held. Free motion is left out.

    `up` (3,) [m/s²]: against gravity, in the root link's axes. With `support` above 0 the dof's own child is
    held instead, and that share of the rest of the robot's weight is on it, as for a leg on the ground. No
    dof holds the weight that the `ground` carries: its force is along `up`, as if that mass were taken away.
    """
    poses, frames = poses_and_frames(robot.root.name, robot.joints, values)
    count = count_of(values)
    weights = {link.name: np.full(count, link.inertial.mass) for link in robot.links}
    moments = {
        link.name: link.inertial.mass * (poses[link.name] @ np.append(link.inertial.com, 1.0))[:, :3]
        for link in robot.links
    }
    for carried in ground:
        weights[carried.link] = weights[carried.link] - carried.mass
        moments[carried.link] = moments[carried.link] - carried.mass * carried.point
    for joint in reversed(robot.joints):
        weights[joint.parent] = weights[joint.parent] + weights[joint.child]
        moments[joint.parent] = moments[joint.parent] + moments[joint.child]
    totals = weights[robot.root.name], moments[robot.root.name]
    forces: dict[str, Array] = {}
    for joint in robot.joints:
        load = weights[joint.child], moments[joint.child]
        if support:
            load = support * (load[0] - totals[0]), support * (load[1] - totals[1])
        for dof in joint.dofs:
            if dof.kind != "free":
                forces[dof.name] = _against(dof, *frames[dof.name], *load, up)
    return forces


def _against(dof: Dof, frame: Array, moved_frame: Array, mass: Array, moment: Array, up: Array) -> Array:
    """Returns the rise (n, 1 or 3) of Σ m x along `up` for unit speeds of the dof: power against gravity."""
    axis = frame[:, :3, :3] @ dof.axis
    if dof.kind == "slide":
        rise: Array = (mass * (axis @ up))[:, None]
        return rise
    axes = axis[:, :, None] if dof.kind == "turn" else moved_frame[:, :3, :3]
    arm = moment - mass[:, None] * moved_frame[:, :3, 3]
    turned: Array = np.einsum("i,nij->nj", up, np.cross(axes, arm[:, :, None], axis=1))
    return turned
