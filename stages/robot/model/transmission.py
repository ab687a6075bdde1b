"""Describes the transmissions by which a source's actuators move its joints."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Transmission:
    """A transmission of the source.

    name: as in the source.
    joint: the name of the dof that it moves.
    type: as in the source; for a ros2_control, its plugin.
    reduction: turns of the actuator for each turn of the joint; 1 if the source gives none.
    interfaces: hardware or command interfaces, as the source names them.
    """

    name: str
    joint: str
    type: str
    reduction: float
    interfaces: tuple[str, ...]
