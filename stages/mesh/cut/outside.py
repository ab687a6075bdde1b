"""How far a collider stands out of what can be reached of a link from outside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.measure import BoxTree, Nearest, even
from linkwright.stages.mesh.surfaces.pieces import Distances, Piece, beyond_piece, surface_of

Numbers = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

_CELLS = 110
"""Cells along the diagonal of a link: of a tolerance of 1.5 % there are 1.6."""

_SPACED = 0.6
"""Of a cell: how far apart the points are that mark the cells of a surface."""

_POINTS = 400
"""On each piece."""

_SEAM = 3e-4
"""Of the diagonal: a point so near to another piece is no point of the outer surface."""


@dataclass(frozen=True, slots=True, eq=False)
class Sampled:
    """A piece by how far points are `beyond` it; points (n, 3) spread evenly over it, how far each is out of
    the link (n,) [m], and the area that each stands for [m²]."""

    beyond: Distances
    points: Points
    distances: Numbers
    area: float

    @property
    def volume(self) -> float:
        """Its area times how far that is out of the link [m³]."""
        return self.area * float(self.distances.sum())


@dataclass(frozen=True, slots=True)
class StandingOut:
    """What 95 % of the outer surface of a collider stay within, and all of it [m]; and of each piece the area
    [m²] of its outer surface that is out by more than the radius of the ball."""

    p95: float
    most: float
    far: tuple[float, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Outside:
    """A link's surface as a ball of some radius finds it that comes from outside.

    Where the ball does not get, inside of solids, in cavities, in hollows with narrow mouths, a collider
    stands out of nothing: so covers of open sheets are judged by their outer side. `hidden`: those cells of a
    grid; `low` (3,), `cell` [m]: where it lies.
    """

    nearest: Nearest
    radius: float
    hidden: Flags
    low: Points
    cell: float
    diagonal: float

    @staticmethod
    def of(surface: Surface, radius: float) -> Outside:
        """Of a surface, closed or not, for a ball of this radius [m]."""
        # Late: a part from the cache needs no library that makes colliders or decimates.
        from scipy.ndimage import distance_transform_edt, label

        tree = BoxTree.of(surface)
        low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
        diagonal = float(np.linalg.norm(high - low))
        cell = diagonal / _CELLS
        margin = int(np.ceil(radius / cell)) + 2
        shape = tuple(int(n) for n in np.ceil((high - low) / cell).astype(int) + 2 * margin + 1)
        start = low - margin * cell
        solid = np.zeros(shape, dtype=bool)
        count = int(np.ceil(surface.area() / (_SPACED * cell) ** 2)) + 1
        marked = np.concatenate([even(tree.corners, count).points, surface.vertices])
        solid[tuple(np.floor((marked - start) / cell).astype(int).T)] = True
        free = distance_transform_edt(~solid) * cell > radius
        parts, _ = label(free)
        reached = parts == parts[0, 0, 0]
        hidden = distance_transform_edt(~reached) * cell > radius + cell
        return Outside(Nearest.of(tree), radius, hidden, start, cell, diagonal)

    def distances(self, points: Points) -> Numbers:
        """(n,): how far [m] points (n, 3) are from the surface, 0 where the ball does not get."""
        cells = np.floor((points - self.low) / self.cell).astype(int)
        within = ((cells >= 0) & (cells < self.hidden.shape)).all(axis=1)
        open_air = np.array(~within)
        open_air[within] = ~self.hidden[tuple(cells[within].T)]
        found = np.zeros(len(points))
        if open_air.any():
            found[open_air] = self.nearest(points[open_air])[0]
        return found

    def sampled(self, piece: Piece) -> Sampled:
        """Points on a piece."""
        surface = surface_of(piece)
        points = even(surface.corners, _POINTS).points
        return Sampled(beyond_piece(piece), points, self.distances(points), surface.area() / _POINTS)

    def standing_out(self, pieces: Sequence[Sampled]) -> StandingOut:
        """How far the outer surface of a collider, the union of the pieces, is out of the link."""
        distances = []
        for number, one in enumerate(pieces):
            outer = np.ones(len(one.points), dtype=bool)
            for other, solid in enumerate(pieces):
                if other != number:
                    outer[outer] = solid.beyond(one.points[outer]) > _SEAM * self.diagonal
            distances.append(one.distances[outer])
        every = np.concatenate(distances)
        weights = np.repeat([one.area for one in pieces], [len(found) for found in distances])
        order = np.argsort(every)
        share = np.cumsum(weights[order])
        p95 = float(every[order][np.searchsorted(share, 0.95 * share[-1])]) if len(every) else 0.0
        far = [np.count_nonzero(found > self.radius) for found in distances]
        areas = tuple(one.area * number for one, number in zip(pieces, far, strict=True))
        return StandingOut(p95, float(every.max(initial=0.0)), areas)
