"""Computes the volume of a collider outside its part, and of the part outside the collider."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.measure.tree import Numbers, split
from linkwright.stages.mesh.measure.union import PieceUnion
from linkwright.stages.mesh.surfaces.booleans import body_of
from linkwright.stages.mesh.surfaces.inside import InsideTest
from linkwright.stages.robot.model.geometry import VolumeMethod

_POINT_COUNT = 1 << 13  # in the box of a part
_MIN_VOLUME_SHARE = 1e-12
_STEPS = (0.8191725133961645, 0.6710436067037893, 0.5497004779019703)
"""Steps of the R3 sequence: 1/p, 1/p², 1/p³ with p⁴ = p + 1."""


@dataclass(frozen=True, slots=True)
class Shares:
    """Volumes by which a collider and a part differ, as shares of the part's volume."""

    extra: float | None
    """Volume of the collider outside the part; None if the part has no volume."""
    missing: float
    """Volume of the part outside the collider."""
    by: VolumeMethod
    """How the volumes were found."""


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """A part as a solid of the boolean library."""

    body: Any
    volume: float

    @staticmethod
    def of(surfaces: Sequence[Surface]) -> "Solid | None":
        """Returns the union of surfaces; None if the library finds any of them empty or not manifold."""
        bodies = [body_of(surface) for surface in surfaces]
        if not bodies or any(body is None for body in bodies):
            return None
        body = _union_of(bodies)
        volume = float(body.volume())
        return Solid(body, volume) if volume > 0 else None

    def shares(self, union: PieceUnion) -> Shares | None:
        """Computes the shares by boolean operations; None if a piece is not manifold."""
        pieces = [body_of(surface) for surface in union.surfaces]
        if any(piece is None for piece in pieces):
            return None
        collider = _union_of(pieces)
        common = float((collider ^ self.body).volume())
        extra, missing = float(collider.volume()) - common, self.volume - common
        return Shares(max(0.0, extra / self.volume), max(0.0, missing / self.volume), "boolean")


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """Points spread evenly through the box of a part."""

    points: Points
    within: np.ndarray[Any, np.dtype[np.bool_]]
    """Whether each point is inside the part."""
    low: Numbers
    high: Numbers
    """Corners of the box (3,) [m]."""

    @staticmethod
    def of(surface: Surface, inside: InsideTest) -> "Cloud":
        """Spreads points through the box of a surface."""
        low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
        steps = np.arange(_POINT_COUNT)[:, None]
        points = low + (high - low) * ((0.5 + steps * np.array(_STEPS)) % 1)
        within = np.concatenate(
            [inside(points[indices]) for indices in split(np.arange(_POINT_COUNT), 1 << 13)]
        )
        return Cloud(points, within, low, high)

    def shares(self, union: PieceUnion) -> Shares:
        """Computes the shares by counting points, exact to about 1 % of the box around the part. For a part
        without an inside, `extra` is None, and nothing is missing."""
        covered = union.depth(self.points) > 0
        box = float(np.prod(self.high - self.low))
        per_point = box / _POINT_COUNT
        part_volume = float(self.within.sum()) * per_point
        if part_volume <= _MIN_VOLUME_SHARE * box or part_volume == 0.0:
            return Shares(None, 0.0, "sampling")
        volume_beyond_box = self._volume_beyond_box(union)
        extra = float((covered & ~self.within).sum()) * per_point + volume_beyond_box
        return Shares(
            extra / part_volume, float((self.within & ~covered).sum()) * per_point / part_volume, "sampling"
        )

    def _volume_beyond_box(self, union: PieceUnion) -> float:
        """Returns the volume [m³] of the union outside the part's box."""
        low, high = union.low.min(axis=0), union.high.max(axis=0)
        low, high = np.minimum(low, self.low), np.maximum(high, self.high)
        steps = np.arange(_POINT_COUNT)[:, None]
        points = low + (high - low) * ((0.5 + steps * np.array(_STEPS)) % 1)
        is_outside = ((points < self.low) | (points > self.high)).any(axis=1)
        covered = union.depth(points[is_outside]) > 0
        return float(covered.sum()) / _POINT_COUNT * float(np.prod(high - low))


def _union_of(bodies: Sequence[Any]) -> Any:
    # Late: a part from the cache needs no library that makes colliders or decimates.
    import manifold3d

    if len(bodies) == 1:
        return bodies[0]
    return manifold3d.Manifold.batch_boolean(list(bodies), manifold3d.OpType.Add)
