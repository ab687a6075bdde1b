"""Selects the sensors of a source that the robot's actuators allow."""

from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Robot, Sensor


def available_sensors(robot: Robot, actuation: Actuation) -> tuple[Sensor, ...]:
    """Returns the robot's sensors, except those of actuators that the robot does not have."""
    names = {actuator.name for actuator in actuation.actuators}
    return tuple(
        sensor for sensor in robot.sensors if sensor.target != "actuator" or sensor.name_of_target in names
    )
