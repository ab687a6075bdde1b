"""Defines the content that only an SRDF has."""

from dataclasses import dataclass

from linkwright.stages.robot.motion.adjacency import Pair


@dataclass(frozen=True, slots=True)
class SrdfForm:
    """The content of a robot's SRDF that no other file has."""

    never: frozenset[Pair] = frozenset()
    """The pairs of links of the URDF that never meet."""

    end_effectors: tuple[str, ...] = ()
    """The names of the end effectors."""
