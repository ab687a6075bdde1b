"""The settings of the makers of colliders."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

if TYPE_CHECKING:
    from linkwright.stages.formats.meshes.surface import Surface
    from linkwright.stages.mesh.section import MeshSection

LEAST_TOLERANCE = 0.001
"""The tolerance [m] of a small part where `mesh.tolerance` says nothing."""

TOLERANCE_OF_SIZE = 0.015
"""The same of a larger part, as a share of the diagonal of its bounding box."""

Effort = Literal["low", "normal", "high"]


@dataclass(frozen=True, slots=True)
class ColliderSettings:
    """The keys of `mesh` that makers of colliders read, with the same meanings and units.

    `kind`, `size`: the kind of primitive where the user says it, and its lengths as a `Primitive` has them,
    None where they are free.
    """

    tolerance: float | None = None
    extra_volume: float = 0.15
    max_vertices: int = 64
    effort: Effort = "normal"
    target: Literal["mujoco", "mjx"] = "mujoco"
    coacd: Mapping[str, Any] = field(default_factory=dict)
    kind: str = ""
    size: tuple[float | None, ...] = ()

    @classmethod
    def of(cls, section: MeshSection) -> ColliderSettings:
        """The settings that the configuration gives."""
        return cls(
            section.tolerance,
            section.extra_volume,
            section.max_vertices,
            section.effort,
            section.target,
            section.coacd,
        )

    def used(self, names: Iterable[str]) -> dict[str, Any]:
        """The settings of these names as plain data, for a cache key."""
        return {name: getattr(self, name) for name in names}

    def tolerance_of(self, surface: Surface) -> float:
        """The largest distance [m] of a collider from a part with this surface."""
        if self.tolerance is not None:
            return self.tolerance
        return default_tolerance(float(np.linalg.norm(np.ptp(surface.vertices, axis=0))))


def default_tolerance(diagonal: float) -> float:
    """The tolerance [m] of a part whose bounding box has this diagonal [m]."""
    return max(LEAST_TOLERANCE, TOLERANCE_OF_SIZE * diagonal)
