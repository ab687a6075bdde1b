"""Measures how far a collider stands out of a link, from the link's surface that is reachable from
outside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.measure import BoxTree, Nearest, evenly_spread
from linkwright.stages.mesh.surfaces.pieces import Distances, Piece, beyond_piece, surface_of

Numbers = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

_CELLS_ALONG_DIAGONAL = 110
"""Number of cells along the diagonal of a link: a tolerance of 1.5 % then has 1.6 cells."""

_MARK_SPACING = 0.6
"""Distance between the points that mark the cells of a surface, in cells."""

_POINTS_PER_PIECE = 400
"""Number of points on each piece."""

_SEAM_WIDTH = 3e-4
"""Points of a piece within this distance of another piece, as a share of the link's diagonal, are not on the
collider's outer surface."""


@dataclass(frozen=True, slots=True, eq=False)
class SampledPiece:
    """A piece of a collider with points on it."""

    beyond: Distances
    """Function that returns how far [m] points are outside the piece, negative inside."""
    points: Points
    """Points (n, 3) spread evenly over the piece."""
    distances: Numbers
    """Distance of each point from the link's reachable surface (n,) [m]."""
    area: float
    """Area that each point represents [m²]."""

    @property
    def volume(self) -> float:
        """Volume [m³] between the piece and the link: area times distance, summed over the points."""
        return self.area * float(self.distances.sum())


@dataclass(frozen=True, slots=True)
class Protrusion:
    """How far the outer surface of a collider stands out of a link."""

    p95: float
    """Distance [m] that 95 % of the outer surface does not exceed."""
    most: float
    """Largest distance [m] of all of the outer surface."""
    far: tuple[float, ...]
    """Area [m²] of each piece's outer surface that stands out by more than the ball's radius, the
    tolerance."""


@dataclass(frozen=True, slots=True, eq=False)
class ReachableSurface:
    """The surface of a link that a ball of some radius can touch from outside.

    Where the ball cannot go (inside solids, in cavities, in hollows with narrow mouths), a collider does not
    count as standing out. Covers made of open sheets are therefore judged by their outer side.
    """

    nearest: Nearest
    """Distances from the surface."""
    radius: float
    """Radius of the ball [m]."""
    hidden: Flags
    """Whether the ball cannot reach each cell of a grid (nx, ny, nz)."""
    low: Points
    """Lowest corner of the grid (3,) [m]."""
    cell: float
    """Pitch of the grid [m]."""
    diagonal: float
    """Diagonal of the link's bounding box [m]."""

    @staticmethod
    def of(surface: Surface, radius: float) -> ReachableSurface:
        """Finds the outside of a surface, closed or not, for a ball of this radius [m]."""
        tree = BoxTree.of(surface)
        low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
        diagonal = float(np.linalg.norm(high - low))
        cell = diagonal / _CELLS_ALONG_DIAGONAL
        margin = int(np.ceil(radius / cell)) + 2
        shape = tuple(int(n) for n in np.ceil((high - low) / cell).astype(int) + 2 * margin + 1)
        start = low - margin * cell
        has_mark = np.zeros(shape, dtype=bool)
        count = int(np.ceil(surface.area() / (_MARK_SPACING * cell) ** 2)) + 1
        marks = np.concatenate([evenly_spread(tree.corners, count).points, surface.vertices])
        has_mark[tuple(np.floor((marks - start) / cell).astype(int).T)] = True
        # Places for the ball's centre: connected to the grid's corner, farther than its radius from the
        # surface.
        is_free = scipy.ndimage.distance_transform_edt(~has_mark) * cell > radius
        regions, _ = scipy.ndimage.label(is_free)
        reachable = regions == regions[0, 0, 0]
        is_hidden = scipy.ndimage.distance_transform_edt(~reachable) * cell > radius + cell
        return ReachableSurface(Nearest.of(tree), radius, is_hidden, start, cell, diagonal)

    def distances(self, points: Points) -> Numbers:
        """Returns the distance [m] (n,) of points (n, 3) from the link's surface, 0 where the ball cannot
        go."""
        cells = np.floor((points - self.low) / self.cell).astype(int)
        within = ((cells >= 0) & (cells < self.hidden.shape)).all(axis=1)
        open_air = np.array(~within)
        open_air[within] = ~self.hidden[tuple(cells[within].T)]
        distances = np.zeros(len(points))
        if open_air.any():
            distances[open_air] = self.nearest(points[open_air])[0]
        return distances

    def sampled(self, piece: Piece) -> SampledPiece:
        """Spreads points over a piece, and measures their distances from the link."""
        surface = surface_of(piece)
        points = evenly_spread(surface.corners, _POINTS_PER_PIECE).points
        return SampledPiece(
            beyond_piece(piece), points, self.distances(points), surface.area() / _POINTS_PER_PIECE
        )

    def protrusion(self, pieces: Sequence[SampledPiece]) -> Protrusion:
        """Measures how far the outer surface of a collider, the union of the pieces, is out of the link."""
        distances = []
        for number, piece in enumerate(pieces):
            outer = np.ones(len(piece.points), dtype=bool)
            for other, other_piece in enumerate(pieces):
                if other != number:
                    outer[outer] = other_piece.beyond(piece.points[outer]) > _SEAM_WIDTH * self.diagonal
            distances.append(piece.distances[outer])
        all_distances = np.concatenate(distances)
        weights = np.repeat([piece.area for piece in pieces], [len(values) for values in distances])
        order = np.argsort(all_distances)
        share = np.cumsum(weights[order])
        p95 = (
            float(all_distances[order][np.searchsorted(share, 0.95 * share[-1])])
            if len(all_distances)
            else 0.0
        )
        far_counts = [np.count_nonzero(values > self.radius) for values in distances]
        areas = tuple(piece.area * number for piece, number in zip(pieces, far_counts, strict=True))
        return Protrusion(p95, float(all_distances.max(initial=0.0)), areas)
