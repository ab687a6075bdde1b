"""What a robot's SRDF says beside its URDF (Semantic Robot Description Format), by the robot's names."""

from dataclasses import dataclass

NEVER = "Never"
"""The reason of pairs of links that are said never to touch; it takes no contact away."""


@dataclass(frozen=True, slots=True)
class JointGroup:
    """Joints that are planned for together: the names of their dofs. `base`, `tip`: the links at the ends of
    the chain that the group is; "" where it is none."""

    name: str
    joints: tuple[str, ...]
    base: str = ""
    tip: str = ""


@dataclass(frozen=True, slots=True)
class EndEffector:
    """The `group` of a tool or a hand, carried by `parent_link`, a link or frame. `parent_group`: the arm
    that moves it, "" where that is not said."""

    name: str
    group: str
    parent_link: str
    parent_group: str = ""


@dataclass(frozen=True, slots=True)
class DisabledPair:
    """Two links whose collisions are not checked. `reason`: as the source has it, "" for none."""

    link_a: str
    link_b: str
    reason: str

    @property
    def touches(self) -> bool:
        """Whether the links may touch, so that their contact has to be left out."""
        return self.reason != NEVER


@dataclass(frozen=True, slots=True)
class VirtualJoint:
    """The joint by which the root is in the world; `parent_frame`: what the source calls the world."""

    name: str
    parent_frame: str


@dataclass(frozen=True, slots=True)
class RobotSemantics:
    """`passive`: dofs that nothing drives. Empty where the robot has no SRDF."""

    groups: tuple[JointGroup, ...] = ()
    end_effectors: tuple[EndEffector, ...] = ()
    passive: tuple[str, ...] = ()
    disabled: tuple[DisabledPair, ...] = ()
    virtual_joint: VirtualJoint | None = None


NOTHING_MORE = RobotSemantics()
"""Of a robot without an SRDF."""
