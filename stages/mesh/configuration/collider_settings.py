"""The settings of the makers of colliders: what each reads, and so what its colliders depend on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from typing import Self

    from linkwright.stages.formats.meshes.surface import Surface

LEAST_TOLERANCE = 0.001
"""The tolerance [m] of a small part where `mesh.tolerance` says nothing."""

TOLERANCE_OF_SIZE = 0.015
"""The same of a larger part, as a share of the diagonal of its bounding box."""

Effort = Literal["low", "normal", "high"]
Engine = Literal["mujoco", "mjx"]


@dataclass(frozen=True, slots=True)
class ColliderSettings:
    """The keys of `mesh` that a maker of colliders reads, with the same meanings and units; none here.

    All of them are in the key of the cache, so that a maker gets a new setting by a field alone.
    """

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """The maker's own of all settings."""
        return cls(**{one.name: values[one.name] for one in fields(cls)})


@dataclass(frozen=True, slots=True)
class HullSettings(ColliderSettings):
    max_vertices: int = 64


@dataclass(frozen=True, slots=True)
class ContactSettings(HullSettings):
    """Of colliders by contact."""

    target: Engine = "mujoco"


@dataclass(frozen=True, slots=True)
class SphereSettings(ColliderSettings):
    tolerance: float | None = None

    def tolerance_of(self, surface: Surface) -> float:
        """The largest distance [m] of a collider from a part with this surface."""
        return default_tolerance(surface.diagonal) if self.tolerance is None else self.tolerance


@dataclass(frozen=True, slots=True)
class PrimitiveSettings(SphereSettings):
    target: Engine = "mujoco"


@dataclass(frozen=True, slots=True)
class GivenSettings(SphereSettings):
    """`kind`, `size`: the kind of primitive that the user says, and its lengths as a `Primitive` has them,
    None where they are free."""

    kind: str = "box"
    size: tuple[float | None, ...] = ()


@dataclass(frozen=True, slots=True)
class PieceSettings(SphereSettings):
    max_vertices: int = 64
    effort: Effort = "normal"


@dataclass(frozen=True, slots=True)
class CoacdSettings(PieceSettings):
    coacd: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class LadderSettings(PieceSettings):
    extra_volume: float = 0.15
    target: Engine = "mujoco"


def default_tolerance(diagonal: float) -> float:
    """The tolerance [m] of a part whose bounding box has this diagonal [m]."""
    return max(LEAST_TOLERANCE, TOLERANCE_OF_SIZE * diagonal)
