"""A joint's coordinates: their kinds, values, limits and dynamics."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from linkwright.stages.robot.model.arrays import Array

DofKind = Literal["turn", "slide", "ball", "free"]

Value = float | tuple[float, ...]
"""A dof's value: a turn [rad], a slide [m]; a ball's unit quaternion (w, x, y, z); of a free joint the
position [m] and quaternion (x, y, z, w, qx, qy, qz)."""

Configuration = Mapping[str, Value]
"""Values by the names of dofs."""


@dataclass(frozen=True, slots=True)
class LimitOrigin:
    """How the limits of a mate were read from CAD. `unknown`: why they are unknown, or not known exactly; ""
    if they are known. `doubts`: contradictions, and how they were resolved. `open`: the open side where only
    the other was typed."""

    unknown: str = ""
    doubts: tuple[str, ...] = ()
    open: tuple[str, ...] = ()

    def with_those_of(self, title: str, other: "LimitOrigin") -> "LimitOrigin":
        """The same with that of another mate, called `title` in CAD, whose limits these take in."""
        mark = f" (of {title})"
        unknown = [self.unknown, other.unknown and other.unknown + mark]
        doubts, sides = (tuple(text + mark for text in texts) for texts in (other.doubts, other.open))
        return LimitOrigin("; ".join(filter(None, unknown)), self.doubts + doubts, self.open + sides)


AS_TYPED = LimitOrigin()
"""Limits that are known, or that there are none."""


@dataclass(frozen=True, slots=True)
class Limits:
    """The dof's range [rad or m]; None is open. A ball's `upper` is the half
    angle [rad] of the cone that its z axis stays in. Equal ranges are equal, whatever their `origin`."""

    lower: float | None = None
    upper: float | None = None
    origin: LimitOrigin = field(default=AS_TYPED, compare=False, kw_only=True)

    def mapped(self, factor: float, shift: float = 0.0) -> "Limits":
        """The range of factor · value + shift."""
        if factor == 0:
            return Limits(shift, shift, origin=self.origin)
        ends = [None if end is None else factor * end + shift + 0.0 for end in (self.lower, self.upper)]
        return Limits(*(ends if factor > 0 else reversed(ends)), origin=self.origin)

    @property
    def interval(self) -> tuple[float, float]:
        """Both ends; an open one is infinite."""
        low = -math.inf if self.lower is None else self.lower
        return low, math.inf if self.upper is None else self.upper

    def contains(self, value: float, tolerance: float = 0.0) -> bool:
        """Whether a value lies within the range, or no further outside than `tolerance`."""
        low, high = self.interval
        return low - tolerance <= value <= high + tolerance

    def clip(self, value: float) -> float:
        """The value of the range that is nearest to this one."""
        low, high = self.interval
        return min(max(value, low), high)

    def unwrap(self, angle: float, tolerance: float = 0.0) -> float:
        """The angle [rad] moved into the range by the fewest whole turns; unchanged where none fits."""
        low, high = self.interval
        turns = 0
        if angle < low - tolerance:
            turns = math.ceil((low - tolerance - angle) / math.tau)
        elif angle > high + tolerance:
            turns = -math.ceil((angle - high - tolerance) / math.tau)
        moved = angle + turns * math.tau
        return moved if self.contains(moved, tolerance) else angle


@dataclass(frozen=True, slots=True)
class Dynamics:
    """What moves and resists a dof; None is unset.

    damping [N m s/rad or N s/m], friction [N m or N], armature [kg m² or kg],
    effort [N m or N], velocity [rad/s or m/s].
    """

    damping: float | None = None
    friction: float | None = None
    armature: float | None = None
    effort: float | None = None
    velocity: float | None = None


@dataclass(frozen=True, slots=True)
class Spring:
    """A spring of a dof: its stiffness [N m/rad or N/m], and the value [rad or m] at which it is slack: 0
    of a ball, whose spring is slack at the pose of qpos0."""

    stiffness: float
    reference: float = 0.0


@dataclass(frozen=True, slots=True)
class MateValue:
    """The way from a dof's value back to the mate's own: `zero` + `sign` · value, for a turn or a slide.

    Of a ball the quaternion `zero` times the value; `sign` is 1. Each as the dof's chain has it, from parent
    to child.
    """

    sign: int = 1
    zero: Value = 0.0

    def of(self, value: float) -> float:
        """The mate's own value [rad or m] of a turn or slide."""
        return float(self.zero) + self.sign * value if isinstance(self.zero, float) else value

    def inverse(self, mate: float) -> float:
        """The value [rad or m] at which the mate's own is `mate`."""
        return self.sign * (mate - self.zero) + 0.0 if isinstance(self.zero, float) else mate


AS_THE_MATE = MateValue()
"""The mate's own value."""


@dataclass(frozen=True, slots=True, eq=False)
class Dof:
    """A coordinate of a joint: a turn about or a slide along `axis` (3,), a ball, or free motion.

    `axis` is a unit vector in the dof's own frame, zero for a ball and for free motion. `origin`
    (4, 4) is that frame in the one which the dof before it moves (previous_from_dof); the first has
    the identity. The only dof of a joint has the joint's name. `saved`: the value in the pose that
    CAD was left in. `given`: those of `limits` and of the dynamics, by name, that the configuration gives;
    the others are the source's. `named`: those of `given` that an entry with the dof's own name gives.
    `in_mate`: how its value is counted in the mate's own. `spring`: that of an MJCF source.
    """

    name: str
    kind: DofKind
    axis: Array
    origin: Array
    limits: Limits
    dynamics: Dynamics
    saved: Value
    given: tuple[str, ...] = ()
    named: tuple[str, ...] = ()
    in_mate: MateValue = AS_THE_MATE
    spring: Spring | None = None
