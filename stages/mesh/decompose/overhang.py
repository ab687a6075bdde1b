"""How far the common hull of pieces stands out of the part: what decides whether they may be joined."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from stages.mesh.decompose.field import Field
from stages.mesh.decompose.remesh import one_a_cell
from stages.mesh.surface import Points, Surface

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

_SPACING = 1.0
"""Of the points that are looked at on a hull, in tolerances: a hole is not missed that is as wide as what
a collider may stand out at most."""

_FEWEST, _MOST, _MOST_OF_PART = 100, 1500, 300_000
_DENSE = 0.8
"""The spacing of the points that stand for a part, in tolerances."""

_DENSER = 0.4
"""The same where a grid is made of them, so that a wall of them has no gap."""

_ROUGHLY = 0.1

_CLASS = 1.2
"""Parts whose tolerances differ by less than this factor have the least of them."""

_FAR = 10.0
"""A hull that stands out by more is as bad as one that stands out by so many tolerances. Well beyond what is
ever allowed: where pieces that stand out too far already have to be joined, the least bad are to be first."""

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
    """Parts to compare hulls with, each within its own tolerance [m]; `tolerance` is the least of them.

    `near`: the points that stand for the parts of each tolerance; `inside` of the parts; `roughly`: the share
    by which a distance may be told too large; `field`: where it is, distances are read off it instead.
    """

    tolerance: float
    near: tuple[tuple[float, cKDTree], ...]
    inside: Callable[[Points], npt.NDArray[np.bool_]]
    roughly: float = 0.0
    field: Field | None = None

    @staticmethod
    def of(
        surfaces: Sequence[Surface],
        tolerances: Sequence[float],
        inside: Callable[[Points], npt.NDArray[np.bool_]],
        spacing: float = _DENSE,
        roughly: float = _ROUGHLY,
    ) -> Overhang:
        """Of the surface of each part, and what says which points are in them.

        `spacing`: of the points that stand for the parts, in tolerances; `roughly` as the field.
        """
        from scipy.spatial import cKDTree

        points: dict[float, list[Points]] = {}
        for surface, tolerance in zip(surfaces, tolerances, strict=True):
            steps = math.floor(math.log(tolerance / min(tolerances), _CLASS) + 1e-9)
            alike = min(tolerances) * _CLASS**steps
            points.setdefault(alike, []).append(_points(surface, spacing * alike))
        near = tuple((one, cKDTree(np.concatenate(points[one]))) for one in sorted(points))
        return Overhang(min(tolerances), near, inside, roughly)

    @staticmethod
    def quick(
        surface: Surface, tolerance: float, inside: Callable[[Points], npt.NDArray[np.bool_]]
    ) -> Overhang:
        """Of one part, for many hulls: distances are told from a grid, to about a tenth of the tolerance,
        unless the grid would be too large."""
        slow = Overhang.of([surface], [tolerance], inside, _DENSER)
        return replace(slow, field=Field.of(np.asarray(slow.near[0][1].data), inside, tolerance))

    def __call__(self, hull: Any) -> Standing:
        """Of a convex body of manifold3d."""
        points, area = self._samples(hull)
        far = self.standing(points)
        return Standing(area * float((far > 1).mean()), max(1.0, float(far.max())))

    def standing(self, points: Points) -> npt.NDArray[np.float64]:
        """(n,): by how many of its tolerances points (n, 3) are outside of the part nearest by that, at most
        10; 0 where that is less than one, or inside."""
        if self.field is not None:
            ratios = np.minimum(self.field(points) / self.near[0][0], _FAR)
            return np.where(ratios > 1, ratios, 0.0)
        ratios = np.full(len(points), _FAR)
        for tolerance, tree in sorted(self.near, key=lambda one: -one[1].n):
            rest = np.flatnonzero(ratios > 1)
            far, _ = tree.query(points[rest], eps=self.roughly, distance_upper_bound=_FAR * tolerance)
            ratios[rest] = np.minimum(ratios[rest], far / tolerance)
        out = np.flatnonzero(ratios > 1)
        result = np.zeros(len(points))
        out = out[~self.inside(points[out])]
        result[out] = ratios[out]
        return result

    def _samples(self, hull: Any) -> tuple[Points, float]:
        """Points spread evenly over a hull, and its area."""
        mesh = hull.to_mesh64()
        vertices = np.array(mesh.vert_properties, dtype=np.float64)[:, :3]
        corners = vertices[np.array(mesh.tri_verts).astype(np.int64)]
        area = float(_areas(corners).sum())
        count = int(np.clip(area / (_SPACING * self.tolerance) ** 2, _FEWEST, _MOST))
        return _even(corners, count), area


def _points(surface: Surface, spacing: float) -> Points:
    """The corners of a surface, and points all over it, about so far [m] apart."""
    count = int(np.clip(2 * surface.area() / spacing**2, _FEWEST, _MOST_OF_PART))
    return np.concatenate([one_a_cell(surface.vertices, spacing), _even(surface.corners, count)])


def _areas(corners: Points) -> npt.NDArray[np.float64]:
    a, b, c = np.moveaxis(corners, 1, 0)
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)


def _even(corners: Points, count: int) -> Points:
    """Points (count, 3) on triangles (m, 3, 3), each standing for the same area."""
    total = np.cumsum(_areas(corners))
    steps = np.arange(count)
    which = np.minimum(np.searchsorted(total, (steps + 0.5) / count * total[-1]), len(total) - 1)
    u, v = (0.5 + steps * _FIRST) % 1, (0.5 + steps * _SECOND) % 1
    over = u + v > 1
    u, v = np.where(over, 1 - u, u)[:, None], np.where(over, 1 - v, v)[:, None]
    a, b, c = np.moveaxis(corners[which], 1, 0)
    return np.asarray(a + (b - a) * u + (c - a) * v)
