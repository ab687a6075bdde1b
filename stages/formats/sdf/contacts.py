"""What of a robot's contacts an SDF can say."""

from stages.robot.geometry import Geometry
from stages.robot.model import Robot


def self_collides(robot: Robot, geometry: Geometry) -> bool:
    """Whether the links of the SDF collide with each other: where they do in the robot, but for pairs that a
    joint holds together, which engines leave out by themselves. An SDF has no word for other pairs."""
    joined = {frozenset((one.parent, one.child)) for one in robot.joints if one.type != "free"}
    apart = [one for one in geometry.excludes if frozenset((one.link_a, one.link_b)) not in joined]
    return geometry.self_contact and not apart
