"""Describes the content of a robot's SRDF (Semantic Robot Description Format), by the robot's names."""

from dataclasses import dataclass

NEVER = "Never"
"""The reason of pairs of links that never touch: their contact need not be excluded."""


@dataclass(frozen=True, slots=True)
class JointGroup:
    """Joints whose motion is planned together.

    name: a name that is unique among groups.
    joints: the names of the dofs.
    base: the link at the beginning of the group's chain; "" if it is not a chain.
    tip: the link at the end of the group's chain; "" if it is not a chain.
    """

    name: str
    joints: tuple[str, ...]
    base: str = ""
    tip: str = ""


@dataclass(frozen=True, slots=True)
class EndEffector:
    """A tool or a hand.

    name: a name that is unique among end effectors.
    group: the group of its joints.
    parent_link: the link or frame that carries it.
    parent_group: the group of the arm that moves it; "" if the SRDF does not say.
    """

    name: str
    group: str
    parent_link: str
    parent_group: str = ""


@dataclass(frozen=True, slots=True)
class DisabledPair:
    """Two links whose collisions are not checked.

    link_a: the first link.
    link_b: the second link.
    reason: the reason in the source; "" without a reason.
    """

    link_a: str
    link_b: str
    reason: str

    @property
    def touches(self) -> bool:
        """Whether the links may touch, so that their contact must be excluded."""
        return self.reason != NEVER


@dataclass(frozen=True, slots=True)
class VirtualJoint:
    """The joint that places the root in the world.

    name: the name in the source.
    parent_frame: the source's name of the world.
    """

    name: str
    parent_frame: str


@dataclass(frozen=True, slots=True)
class RobotSemantics:
    """The content of a source's SRDF, by the robot's names; empty without an SRDF.

    groups: the groups of joints whose motion is planned together.
    end_effectors: the tools and hands.
    passive: the dofs that nothing drives.
    disabled: the pairs of links whose collisions are not checked.
    virtual_joint: the joint that places the root in the world; null if the SRDF does not say.
    """

    groups: tuple[JointGroup, ...] = ()
    end_effectors: tuple[EndEffector, ...] = ()
    passive: tuple[str, ...] = ()
    disabled: tuple[DisabledPair, ...] = ()
    virtual_joint: VirtualJoint | None = None


NO_SEMANTICS = RobotSemantics()
"""The semantics of a robot without an SRDF."""
