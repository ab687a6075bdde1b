"""How much a collider has too much and too little, as volumes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.measure.tree import Numbers, split
from linkwright.stages.mesh.measure.union import Union
from linkwright.stages.mesh.surfaces.booleans import body_of
from linkwright.stages.mesh.surfaces.inside import Inside
from linkwright.stages.robot.model.geometry import By

_POINTS = 1 << 13
_NEGLIGIBLE = 1e-12
_STEPS = (0.8191725133961645, 0.6710436067037893, 0.5497004779019703)
"""The steps of the R3 sequence: 1/p, 1/p², 1/p³ with p⁴ = p + 1."""


@dataclass(frozen=True, slots=True)
class Shares:
    """Volume of the collider outside the part, and of the part outside the collider, over the part's own;
    `extra` is None where the part has none."""

    extra: float | None
    missing: float
    by: By


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """A part as a solid of the boolean library."""

    body: Any
    volume: float

    @staticmethod
    def of(surfaces: Sequence[Surface]) -> "Solid | None":
        """The union of surfaces; None where the library takes one of them for no manifold, or as empty."""
        bodies = [body_of(surface) for surface in surfaces]
        if not bodies or any(body is None for body in bodies):
            return None
        body = _together(bodies)
        volume = float(body.volume())
        return Solid(body, volume) if volume > 0 else None

    def shares(self, union: Union) -> Shares | None:
        """By boolean operations; None where a piece is no manifold."""
        pieces = [body_of(surface) for surface in union.surfaces]
        if any(piece is None for piece in pieces):
            return None
        collider = _together(pieces)
        common = float((collider ^ self.body).volume())
        extra, missing = float(collider.volume()) - common, self.volume - common
        return Shares(max(0.0, extra / self.volume), max(0.0, missing / self.volume), "boolean")


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """Points spread evenly through the box of a part, and which of them are inside of it."""

    points: Points
    within: np.ndarray[Any, np.dtype[np.bool_]]
    low: Numbers
    high: Numbers

    @staticmethod
    def of(surface: Surface, inside: Inside) -> "Cloud":
        low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
        steps = np.arange(_POINTS)[:, None]
        points = low + (high - low) * ((0.5 + steps * np.array(_STEPS)) % 1)
        within = np.concatenate([inside(points[some]) for some in split(np.arange(_POINTS), 1 << 13)])
        return Cloud(points, within, low, high)

    def shares(self, union: Union) -> Shares:
        """By counting points: right to about 1 % of the box around the part. Where the part has no inside,
        `extra` is None and nothing is missing."""
        covered = union.depth(self.points) > 0
        box = float(np.prod(self.high - self.low))
        one = box / _POINTS
        own = float(self.within.sum()) * one
        if own <= _NEGLIGIBLE * box or own == 0.0:
            return Shares(None, 0.0, "sampling")
        beyond = self._beyond(union)
        extra = float((covered & ~self.within).sum()) * one + beyond
        return Shares(extra / own, float((self.within & ~covered).sum()) * one / own, "sampling")

    def _beyond(self, union: Union) -> float:
        """The volume [m³] of the union outside the part's box."""
        low, high = union.low.min(axis=0), union.high.max(axis=0)
        low, high = np.minimum(low, self.low), np.maximum(high, self.high)
        steps = np.arange(_POINTS)[:, None]
        points = low + (high - low) * ((0.5 + steps * np.array(_STEPS)) % 1)
        out = ((points < self.low) | (points > self.high)).any(axis=1)
        covered = union.depth(points[out]) > 0
        return float(covered.sum()) / _POINTS * float(np.prod(high - low))


def _together(bodies: Sequence[Any]) -> Any:
    # Late: a part from the cache needs no library that makes colliders or decimates.
    import manifold3d

    if len(bodies) == 1:
        return bodies[0]
    return manifold3d.Manifold.batch_boolean(list(bodies), manifold3d.OpType.Add)
