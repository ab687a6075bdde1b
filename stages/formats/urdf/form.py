"""Defines how a robot's URDF differs from the robot, as a value that writers and checks share."""

from dataclasses import dataclass

from linkwright.stages.robot.motion.linear_coupling import LinearCoupling


@dataclass(frozen=True, slots=True)
class UrdfForm:
    """The choices that decide how a robot is written as a URDF."""

    merged: bool = False
    """Whether links on fixed joints are merged into their parents."""

    couplings: tuple[LinearCoupling, ...] = ()
    """The linear couplings that the closed loops impose on dofs; the exact couplings are written as
    <mimic>."""

    closed: tuple[str, ...] = ()
    """The names of the loops that these couplings close completely."""

    package: str = ""
    """The ROS package in the URIs of meshes, or "" if meshes are named by path."""

    @property
    def mimics(self) -> tuple[LinearCoupling, ...]:
        """The exact couplings, each of which is written as a <mimic>."""
        return tuple(coupling for coupling in self.couplings if coupling.exact)
