"""Describes the transmissions by which a source's actuators move its joints."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Transmission:
    """A transmission of the source.

    name: the name in the source.
    joint: the name of the dof that it moves.
    type: the type in the source; the plugin of a transmission of <ros2_control>.
    reduction: turns of the actuator for each turn of the joint; 1 if the source gives none.
    interfaces: the hardware or command interfaces, by the source's names.
    """

    name: str
    joint: str
    type: str
    reduction: float
    interfaces: tuple[str, ...]
