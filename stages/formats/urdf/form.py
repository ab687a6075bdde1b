"""How a robot's URDF differs from the robot: for who writes and who checks one."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class UrdfForm:
    """`merged`: whether links on fixed joints are part of their parents."""

    merged: bool = False


AS_IS = UrdfForm()
"""The robot as it is."""
