"""Computes the poses of a USD's rigid bodies, and writes their mass properties in single precision."""

import numpy as np

from linkwright.stages.export.usd.joints import UsdJoint
from linkwright.stages.export.usd.layer import Prim, rounded
from linkwright.stages.formats.numbers import LENGTH, rounded_tensor
from linkwright.stages.formats.usd.names import UsdNames
from linkwright.stages.robot.dynamics.inertia import TINY_INERTIAL, principal_axes
from linkwright.stages.robot.model.poses import at_rest, motion
from linkwright.stages.robot.model.robot import Array, Configuration, Inertial, Robot
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.loops import closing_values, relative_pose


def body_poses(
    robot: Robot,
    names: UsdNames,
    q: Configuration,
    zeros: Configuration,
    joints: tuple[UsdJoint, ...],
    world_from_root: Array,
) -> dict[str, Array]:
    """Returns world_from_body (4, 4) of every body by the name of its prim, with the dofs at `q`. `zeros`:
    the values in `q` of the balls whose joints are at zero there."""
    root_from_link = link_poses(robot, q)
    poses = {names.links[link]: world_from_root @ pose for link, pose in root_from_link.items()}
    values = dict(q)
    for loop in robot.loops:
        values |= closing_values(loop, relative_pose(loop, root_from_link))
    # The frame of such a joint has the value of its ball already.
    values |= {name: at_rest("ball") for name in zeros}
    for joint in joints:
        # The bodies of the robot's links have poses: this is a link between two dofs.
        if joint.second not in poses:
            assert joint.dof is not None
            dof_motion = motion(joint.dof.kind, joint.dof.axis, values[joint.dof.name])
            body_from_joint = joint.second_from_joint
            # The dof moves the body away from the pose in which its joint is at zero.
            poses[joint.second] = (
                poses[joint.first] @ joint.first_from_joint @ np.linalg.inv(body_from_joint) @ dof_motion
            )
    return poses


def write_mass(body: Prim, inertial: Inertial) -> None:
    """Writes the mass properties of a body. A body without mass gets a negligible mass, since engines would
    invent one."""
    body_inertial = inertial if inertial.mass > 0 else TINY_INERTIAL
    body.apply("PhysicsMassAPI")
    body.number("physics:mass", body_inertial.mass)
    body.floats("physics:centerOfMass", "point3f", body_inertial.com, LENGTH)
    # The axes are those of the rounded tensor, since further digits differ between machines.
    moments, axes = principal_axes(rounded_tensor(body_inertial.inertia))
    body.set("physics:diagonalInertia", "float3", tuple(_in_single_precision(rounded(moments))))
    body.rotation("physics:principalAxes", axes)


def _in_single_precision(moments: list[float]) -> list[float]:
    """Returns principal moments in single precision, rounded so that none exceeds the sum of the other two.
    For a flat body the largest equals this sum, and plain rounding could make it larger."""
    values = np.array(moments, dtype=np.float32)
    largest = int(values.argmax())
    smaller = np.delete(values, largest)
    while np.float32(smaller[0]) + np.float32(smaller[1]) < values[largest]:
        values[largest] = np.nextafter(values[largest], np.float32(0))
    return [float(value) for value in values]
