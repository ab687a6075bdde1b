"""Describes the content of a robot's SRDF (Semantic Robot Description Format), by the robot's names."""

from dataclasses import dataclass

NEVER = "Never"
"""The reason of pairs of links that are said never to touch; it takes no contact away."""


@dataclass(frozen=True, slots=True)
class JointGroup:
    """Joints that are planned for together.

    name: unique among groups.
    joints: the names of their dofs.
    base: the link at the beginning of the group's chain; "" where it is no chain.
    tip: the link at the end of the group's chain; "" where it is no chain.
    """

    name: str
    joints: tuple[str, ...]
    base: str = ""
    tip: str = ""


@dataclass(frozen=True, slots=True)
class EndEffector:
    """A tool or a hand.

    name: unique among end effectors.
    group: its joints.
    parent_link: the link or frame that carries it.
    parent_group: the arm that moves it; "" where that is not said.
    """

    name: str
    group: str
    parent_link: str
    parent_group: str = ""


@dataclass(frozen=True, slots=True)
class DisabledPair:
    """Two links whose collisions are not checked.

    link_a: the first.
    link_b: the second.
    reason: as the source has it; "" for none.
    """

    link_a: str
    link_b: str
    reason: str

    @property
    def touches(self) -> bool:
        """Whether the links may touch, so that their contact has to be left out."""
        return self.reason != NEVER


@dataclass(frozen=True, slots=True)
class VirtualJoint:
    """The joint that places the root in the world.

    name: as the source has it.
    parent_frame: what the source calls the world.
    """

    name: str
    parent_frame: str


@dataclass(frozen=True, slots=True)
class RobotSemantics:
    """The content of a source's SRDF, by the robot's names; empty where the robot has no SRDF.

    groups: joints that are planned for together.
    end_effectors: tools and hands.
    passive: dofs that nothing drives.
    disabled: pairs of links whose collisions are not checked.
    virtual_joint: the joint that places the root in the world; null where that is not said.
    """

    groups: tuple[JointGroup, ...] = ()
    end_effectors: tuple[EndEffector, ...] = ()
    passive: tuple[str, ...] = ()
    disabled: tuple[DisabledPair, ...] = ()
    virtual_joint: VirtualJoint | None = None


NO_SEMANTICS = RobotSemantics()
"""The semantics of a robot without an SRDF."""
