"""How far the common hull of pieces stands out of the part: what decides whether they may be joined."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stages.mesh.decompose.remesh import dense, one_a_cell
from stages.mesh.rays import Inside
from stages.mesh.surface import Points, Surface, joined

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

_SPACING = 1.0
"""Of the points that are looked at on a hull, in tolerances: a hole is not missed that is as wide as what
a collider may stand out at most."""

_FEWEST, _MOST = 100, 1500
_DENSE, _CELL = 0.8, 0.4
"""The spacing of the points that stand for the part, and how near to each other one is enough, in
tolerances."""

_ROUGHLY = 0.1
"""The share by which a distance may be told too large."""

_FAR = 3.5
"""A hull that stands out by more is as bad as one that stands out by so many tolerances."""

_FIRST, _SECOND = 0.7548776662466927, 0.5698402909980532
"""The steps of the R2 sequence; see `measure.samples`."""


@dataclass(frozen=True, slots=True)
class Standing:
    """Of a convex body: the area [m²] that stands out of the part by more than the tolerance, and by how many
    tolerances it stands out at most, as points say that are a tolerance apart."""

    area: float
    most: float


@dataclass(frozen=True, slots=True, eq=False)
class Overhang:
    """A part to compare hulls with, within a tolerance [m]."""

    tolerance: float
    near: cKDTree
    inside: Inside

    @staticmethod
    def of(surface: Surface, bodies: Sequence[Surface], tolerance: float) -> Overhang:
        """Of the surface of a part and the closed bodies that were made of it, which say what is inside."""
        from scipy.spatial import cKDTree

        points = one_a_cell(dense(surface, _DENSE * tolerance), _CELL * tolerance)
        return Overhang(tolerance, cKDTree(points), Inside.of(joined(bodies)))

    def __call__(self, hull: Any) -> Standing:
        """Of a convex body of manifold3d."""
        points, area = self._samples(hull)
        far, _ = self.near.query(points, eps=_ROUGHLY, distance_upper_bound=_FAR * self.tolerance)
        far = np.minimum(far / self.tolerance, _FAR)
        out = np.flatnonzero(far > 1)
        out = out[~self.inside(points[out])]
        return Standing(area * len(out) / len(points), float(far[out].max(initial=1.0)))

    def _samples(self, hull: Any) -> tuple[Points, float]:
        """Points spread evenly over a hull, and its area."""
        mesh = hull.to_mesh64()
        vertices = np.array(mesh.vert_properties, dtype=np.float64)[:, :3]
        a, b, c = np.moveaxis(vertices[np.array(mesh.tri_verts).astype(np.int64)], 1, 0)
        total = np.cumsum(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)
        area = float(total[-1])
        count = int(np.clip(area / (_SPACING * self.tolerance) ** 2, _FEWEST, _MOST))
        steps = np.arange(count)
        which = np.minimum(np.searchsorted(total, (steps + 0.5) / count * area), len(total) - 1)
        u, v = (0.5 + steps * _FIRST) % 1, (0.5 + steps * _SECOND) % 1
        over = u + v > 1
        u, v = np.where(over, 1 - u, u)[:, None], np.where(over, 1 - v, v)[:, None]
        return a[which] + (b - a)[which] * u + (c - a)[which] * v, area
