"""What an SRDF says that nothing else of the robot does."""

from dataclasses import dataclass

from linkwright.stages.robot.motion.adjacency import Pair


@dataclass(frozen=True, slots=True)
class SrdfForm:
    """`never`: the pairs of links of the URDF that never meet; `end_effectors`: the names of these."""

    never: frozenset[Pair] = frozenset()
    end_effectors: tuple[str, ...] = ()
