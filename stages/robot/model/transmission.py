"""Describes the transmissions by which a source's actuators move its joints."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Transmission:
    """A transmission of the source.

    name: as in the source.
    joint: the name of a dof.
    type: as in the source; that of a ros2_control is its plugin.
    reduction: 1 where it has none.
    interfaces: hardware or command interfaces, as the source names them.
    """

    name: str
    joint: str
    type: str
    reduction: float
    interfaces: tuple[str, ...]
