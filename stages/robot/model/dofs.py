"""Describes a joint's coordinates: their kinds, values, limits and dynamics."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from linkwright.stages.robot.model.arrays import Array

DofKind = Literal["turn", "slide", "ball", "free"]
"""The kind of a dof. turn: rotation about an axis; slide: translation along it; ball: any rotation; free: any
motion."""

Value = float | tuple[float, ...]
"""A dof's value: a turn [rad], a slide [m]; a ball's unit quaternion (w, x, y, z); of a free joint the
position [m] and quaternion (x, y, z, w, qx, qy, qz)."""

Configuration = Mapping[str, Value]
"""Values by the names of dofs."""


@dataclass(frozen=True, slots=True)
class LimitOrigin:
    """The origin of the limits of a mate: how they were read from CAD."""

    unknown: str = ""
    """Why the limits are unknown, or not known exactly; "" if they are known."""
    doubts: tuple[str, ...] = ()
    """The contradictions in CAD, and how they were resolved."""
    open: tuple[str, ...] = ()
    """The open sides of limits for which only the other side was typed."""

    def merged_with(self, title: str, other: "LimitOrigin") -> "LimitOrigin":
        """Returns the origin of limits that combine these with those of another mate, called `title` in
        CAD."""
        mark = f" (of {title})"
        unknown = [self.unknown, other.unknown and other.unknown + mark]
        doubts, open_sides = (tuple(text + mark for text in texts) for texts in (other.doubts, other.open))
        return LimitOrigin("; ".join(filter(None, unknown)), self.doubts + doubts, self.open + open_sides)


AS_TYPED = LimitOrigin()
"""The origin of limits that are known exactly, also if there are none."""


@dataclass(frozen=True, slots=True)
class Limits:
    """The range of a dof. Comparison ignores the `origin`."""

    lower: float | None = None
    """Lower end [rad or m]; None is open."""
    upper: float | None = None
    """Upper end [rad or m]; None is open. For a ball, the half angle [rad] of the cone that its z axis stays
    in."""
    origin: LimitOrigin = field(default=AS_TYPED, compare=False, kw_only=True)
    """How the limits were read from CAD."""

    def mapped(self, factor: float, shift: float = 0.0) -> "Limits":
        """Returns the range of factor · value + shift, for values in this range."""
        if factor == 0:
            return Limits(shift, shift, origin=self.origin)
        # Adding 0.0 turns -0.0 into 0.0.
        ends = [None if end is None else factor * end + shift + 0.0 for end in (self.lower, self.upper)]
        return Limits(*(ends if factor > 0 else reversed(ends)), origin=self.origin)

    @property
    def interval(self) -> tuple[float, float]:
        """The lower and the upper end [rad or m]; an open end is infinite."""
        low = -math.inf if self.lower is None else self.lower
        return low, math.inf if self.upper is None else self.upper

    def contains(self, value: float, tolerance: float = 0.0) -> bool:
        """Returns whether a value is within the range, or outside by at most `tolerance`."""
        low, high = self.interval
        return low - tolerance <= value <= high + tolerance

    def clip(self, value: float) -> float:
        """Returns the value in the range that is nearest to `value`."""
        low, high = self.interval
        return min(max(value, low), high)

    def unwrap(self, angle: float, tolerance: float = 0.0) -> float:
        """Returns the angle [rad] that differs by the fewest whole turns and is within the range, or outside
        by at most `tolerance`; `angle` itself if no such angle exists."""
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
    """The resistances and limits of a dof's motion; None if a value is not set."""

    damping: float | None = None
    """Viscous damping [N m s/rad or N s/m]."""
    friction: float | None = None
    """Dry (Coulomb) friction [N m or N]."""
    armature: float | None = None
    """Inertia of the rotor, reflected to the joint [kg m² or kg]."""
    effort: float | None = None
    """Largest torque or force [N m or N]."""
    velocity: float | None = None
    """Largest speed [rad/s or m/s]."""


@dataclass(frozen=True, slots=True)
class Spring:
    """A spring of a dof."""

    stiffness: float
    """Stiffness [N m/rad or N/m]."""
    reference: float = 0.0
    """Value [rad or m] without spring force; 0 for a ball, whose spring has no force at qpos0."""


@dataclass(frozen=True, slots=True)
class MateValue:
    """The conversion of a dof's value to the value that its mate has in CAD.

    For a turn or a slide it is `zero` + `sign` · value. For a ball it is the quaternion `zero` times the
    value, as the dof's chain multiplies rotations from parent to child, and `sign` is 1.
    """

    sign: int = 1
    zero: Value = 0.0

    def to_mate(self, value: float) -> float:
        """Returns the mate's value [rad or m] at this value of a turn or slide."""
        return float(self.zero) + self.sign * value if isinstance(self.zero, float) else value

    def from_mate(self, mate: float) -> float:
        """Returns the value [rad or m] of a turn or slide at which the mate's value is `mate`."""
        return self.sign * (mate - self.zero) + 0.0 if isinstance(self.zero, float) else mate


AS_THE_MATE = MateValue()
"""The conversion of a dof whose value is that of the mate."""


@dataclass(frozen=True, slots=True, eq=False)
class Dof:
    """A coordinate of a joint. If a joint has a single dof, both have the same name."""

    name: str
    kind: DofKind
    axis: Array
    """Unit vector (3,) in the dof's own frame; zero for a ball and for free motion."""
    origin: Array
    """The dof's frame in the frame that the dof before it moves (4, 4: previous_from_dof); the identity for
    the first."""
    limits: Limits
    dynamics: Dynamics
    saved: Value
    """Value in the pose that is saved in CAD."""
    given: tuple[str, ...] = ()
    """Names of the limits and dynamics that the configuration sets; the others are the source's."""
    named: tuple[str, ...] = ()
    """Names in `given` that are set by an entry with the name of the dof, and not by a glob."""
    mate_value: MateValue = AS_THE_MATE
    """Conversion of the value to that of the mate."""
    spring: Spring | None = None
    """The spring in an MJCF source; None without a spring."""
