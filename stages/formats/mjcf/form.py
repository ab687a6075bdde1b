"""Defines how a robot's MJCF differs from the robot, as a value that writers and checks share."""

from dataclasses import dataclass

from linkwright.stages.robot.model.mjcf_extras import MjcfExtras


@dataclass(frozen=True, slots=True)
class MjcfForm:
    """The choices that decide how a robot is written as an MJCF."""

    fused: tuple[str, ...] = ()
    """The links without a body of their own. Each is a site of its name on the body above it; its mass, its
    shapes and everything else on it belong to that body."""

    extras: MjcfExtras | None = None
    """The content of an MJCF source that no other format has."""
