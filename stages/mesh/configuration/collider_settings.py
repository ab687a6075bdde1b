"""Defines the settings that each maker of colliders reads: all on which its colliders depend."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, Literal

from linkwright.stages.targets.engines import NO_LIMITS, ShapeLimits

if TYPE_CHECKING:
    from typing import Self

    from linkwright.stages.formats.meshes.surface import Surface

MIN_TOLERANCE = 0.001
"""Smallest default tolerance [m], for small parts."""

TOLERANCE_SHARE = 0.015
"""Default tolerance of a larger part, as a share of the diagonal of its bounding box."""

Effort = Literal["low", "normal", "high"]


@dataclass(frozen=True, slots=True)
class ColliderSettings:
    """The keys of `mesh` that a maker of colliders reads, with the same meanings and units. This base class
    has no keys.

    The key of the cache contains all fields, so that a new setting only needs a new field.
    """

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """Picks the settings that this maker reads from those of all makers."""
        return cls(**{setting.name: values[setting.name] for setting in fields(cls)})


@dataclass(frozen=True, slots=True)
class HullSettings(ColliderSettings):
    """Settings of convex hulls."""

    max_vertices: int = 64


@dataclass(frozen=True, slots=True)
class RawSettings(ColliderSettings):
    """Settings of unchanged meshes."""

    limits: ShapeLimits = NO_LIMITS
    """Limits of the engines of `target` on colliders."""


@dataclass(frozen=True, slots=True)
class ContactSettings(HullSettings):
    """The settings of colliders by contact."""

    limits: ShapeLimits = NO_LIMITS


@dataclass(frozen=True, slots=True)
class SphereSettings(ColliderSettings):
    """Settings of spheres, and of all colliders with a tolerance."""

    tolerance: float | None = None

    def tolerance_of(self, surface: Surface) -> float:
        """Returns the tolerance [m] of a part's collider: the configured one, else the default for this
        surface."""
        return default_tolerance(surface.diagonal) if self.tolerance is None else self.tolerance


@dataclass(frozen=True, slots=True)
class PrimitiveSettings(SphereSettings):
    """Settings of the primitive that fits best."""

    limits: ShapeLimits = NO_LIMITS


@dataclass(frozen=True, slots=True)
class GivenSettings(SphereSettings):
    """Settings of a primitive that the user chose."""

    kind: str = "box"
    """Kind of primitive that the user chose."""
    size: tuple[float | None, ...] = ()
    """Lengths as in `Primitive.size`, None for a length that is fitted."""


@dataclass(frozen=True, slots=True)
class PieceSettings(SphereSettings):
    """Settings of convex pieces."""

    max_vertices: int = 64
    effort: Effort = "normal"


@dataclass(frozen=True, slots=True)
class CoacdSettings(PieceSettings):
    """Settings of CoACD's pieces."""

    coacd: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class LadderSettings(PieceSettings):
    """Settings of the ladder with a tolerance."""

    extra_volume: float = 0.15
    limits: ShapeLimits = NO_LIMITS


def default_tolerance(diagonal: float) -> float:
    """Returns the default tolerance [m] of a part whose bounding box has this diagonal [m]."""
    return max(MIN_TOLERANCE, TOLERANCE_SHARE * diagonal)
