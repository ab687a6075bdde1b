"""The sensors that a robot has with what drives it."""

from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Robot, Sensor


def measuring(robot: Robot, actuation: Actuation) -> tuple[Sensor, ...]:
    """The robot's sensors, but for those of actuators that are not there."""
    there = {one.name for one in actuation.actuators}
    return tuple(one for one in robot.sensors if one.target != "actuator" or one.name_of_target in there)
