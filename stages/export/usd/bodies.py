"""Rigid bodies of a USD: where their links stand, and their mass properties in single precision."""

import numpy as np

from linkwright.stages.export.usd.joints import UsdJoint
from linkwright.stages.export.usd.layer import Prim, rounded
from linkwright.stages.formats.numbers import LENGTH, rounded_tensor
from linkwright.stages.formats.usd.names import UsdNames
from linkwright.stages.robot.dynamics.inertia import SPECK, principal_axes
from linkwright.stages.robot.model.poses import at_rest, motion
from linkwright.stages.robot.model.robot import Array, Configuration, Inertial, Robot
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.loops import across, closing


def body_poses(
    robot: Robot,
    names: UsdNames,
    q: Configuration,
    zeros: Configuration,
    joints: tuple[UsdJoint, ...],
    world_from_root: Array,
) -> dict[str, Array]:
    """world_from_body (4, 4) of every body by the name of its prim, with the dofs at `q`. `zeros`: of balls
    whose joints turn on from there."""
    at = link_poses(robot, q)
    poses = {names.links[link]: world_from_root @ pose for link, pose in at.items()}
    values = dict(q)
    for loop in robot.loops:
        values |= closing(loop, across(loop, at))
    values |= {name: at_rest("ball") for name in zeros}
    for joint in joints:
        if joint.second not in poses:
            assert joint.dof is not None
            assert joint.first is not None
            moved = motion(joint.dof.kind, joint.dof.axis, values[joint.dof.name])
            turned = joint.second_from_joint
            # The body is where the dof moves it from where its frame is at zero.
            poses[joint.second] = poses[joint.first] @ joint.first_from_joint @ np.linalg.inv(turned) @ moved
    return poses


def write_mass(body: Prim, inertial: Inertial) -> None:
    """The mass properties; what has no mass is next to nothing, since engines would make up a mass."""
    own = inertial if inertial.mass > 0 else SPECK
    body.apply("PhysicsMassAPI")
    body.number("physics:mass", own.mass)
    body.floats("physics:centerOfMass", "point3f", own.com, LENGTH)
    # Of the rounded tensor: the digits below differ between machines.
    moments, axes = principal_axes(rounded_tensor(own.inertia))
    body.set("physics:diagonalInertia", "float3", tuple(single(rounded(moments))))
    body.turned("physics:principalAxes", axes)


def single(moments: list[float]) -> list[float]:
    """Principal moments in single precision, of which still none is larger than the others together: of a
    flat body it is as large, and rounding may make it larger."""
    values = np.array(moments, dtype=np.float32)
    most = int(values.argmax())
    others = np.delete(values, most)
    while np.float32(others[0]) + np.float32(others[1]) < values[most]:
        values[most] = np.nextafter(values[most], np.float32(0))
    return [float(one) for one in values]
