"""How a robot's MJCF differs from the robot: for who writes and who checks one."""

from dataclasses import dataclass

from linkwright.stages.robot.model.mjcf_extras import MjcfExtras


@dataclass(frozen=True, slots=True)
class MjcfForm:
    """`fused`: the links that have no body of their own. Each is a site of its name on the body above it,
    which has its mass, its shapes and all that was on it. `extras`: what it has that no other format has, of
    an MJCF source."""

    fused: tuple[str, ...] = ()
    extras: MjcfExtras | None = None
