"""How a robot's URDF differs from the robot: for who writes and who checks one."""

from dataclasses import dataclass

from linkwright.stages.robot.motion.linear_coupling import LinearCoupling


@dataclass(frozen=True, slots=True)
class UrdfForm:
    """`merged`: whether links on fixed joints are part of their parents. `couplings`: what the robot's closed
    loops make follow what; those that are exact are <mimic>s. `closed`: the loops that these alone close.
    `package`: that by which it names its meshes, "" where it names them by paths."""

    merged: bool = False
    couplings: tuple[LinearCoupling, ...] = ()
    closed: tuple[str, ...] = ()
    package: str = ""

    @property
    def mimics(self) -> tuple[LinearCoupling, ...]:
        return tuple(one for one in self.couplings if one.exact)
