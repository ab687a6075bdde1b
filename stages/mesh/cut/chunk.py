"""Defines chunks, pieces of a collider with the triangles of the link that they enclose, and portions of a
part that are to become pieces."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import scipy

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.fit import capped_hull
from linkwright.stages.mesh.surfaces.convex_hull import outwards
from linkwright.stages.mesh.surfaces.pieces import Distances, Piece, surface_of
from linkwright.stages.mesh.surfaces.snapping import snapped
from linkwright.stages.robot.contact.clearance import engine

Numbers = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

_MIN_THICKNESS = 1e-6
"""Smallest ratio [m] of volume to area of a hull that does not count as flat."""

_MAX_NEIGHBOURS = 254
"""Largest number of neighbours of a corner: Coal (3.0.3) counts them in a byte, and raises an error for
more."""

_CELLS_ALONG_DIAGONAL = 30
"""Number of grid cells along the diagonal of a piece; its cloud has at most one point in each cell."""

_FREE_DISTANCE = 0.3
"""Distance outside of the part, in tolerances, that costs nothing: a point farther out costs the rest of its
distance."""


@dataclass(frozen=True, slots=True, eq=False)
class Chunk:
    """A convex piece of a collider, with the triangles of the link from which it was made."""

    surface: Surface
    """Triangles in the link's frame; empty if the piece must not change."""
    piece: Piece
    """Solid around the triangles."""
    engine_solid: Any
    """The solid in the form of the collision engine."""
    volume: float
    """Volume of the solid [m³]."""
    collider_index: int = -1
    """Index of the collider in the link; -1 for a piece that is already fixed."""
    _cloud: list[Points] = field(default_factory=list)
    """The points that `cloud` returns, once they are computed; a list, since the class is frozen."""

    @staticmethod
    def of(surface: Surface, piece: Piece, collider_index: int = -1) -> Chunk:
        """Returns the chunk of a piece. For the engine, a primitive is approximated by a polyhedron."""
        solid = surface_of(piece)
        return Chunk(surface, piece, _engine_form(solid), solid.volume(), collider_index)

    @staticmethod
    def of_hull(surface: Surface, hull: Surface, max_vertices: int, collider_index: int) -> Chunk | None:
        """Returns the chunk of a surface with the hull `hull`. The piece has at most `max_vertices`, on the
        grid to which files round. Returns None if the piece is flat."""
        reduced_hull = capped_hull(hull, max_vertices)
        return None if reduced_hull is None else Chunk.of(surface, snapped(reduced_hull), collider_index)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickles the chunk without the engine's form of the solid, which is made again."""
        return Chunk.of, (self.surface, self.piece, self.collider_index)

    @property
    def is_final(self) -> bool:
        """Whether the piece may neither be cut nor merged."""
        return not len(self.surface.triangles)

    @property
    def vertices(self) -> Points:
        """Vertices of the solid (n, 3)."""
        return surface_of(self.piece).vertices

    def cloud(self) -> Points:
        """Returns sample points (n, 3) of the triangles, at most one in each cell of a grid."""
        if not self._cloud:
            self._cloud.append(cloud_of(self.surface))
        return self._cloud[0]


@dataclass(frozen=True, slots=True, eq=False)
class Portion:
    """A portion of a part with its hull. The hull becomes a piece, unless the portion is cut or joined."""

    surface: Surface
    """Triangles of the part in this portion; of joined portions, their common hull."""
    hull: Surface
    """Hull of the triangles, with all corners."""
    volume: float
    """Volume of the hull [m³]."""
    points: Points
    """Points on the hull (n, 3) [m]."""
    distances: Numbers
    """Distance of each point outside of the part (n,), in tolerances; 0 inside."""
    point_area: float
    """Area that each point represents [m²]."""
    distances_beyond: Distances
    """Function that returns how far points are beyond the hull."""
    low: Points
    high: Points
    """Bounds of the hull (3,) [m]."""
    original: Piece | None = None
    """The piece itself, if it was made elsewhere."""

    def cost(self, outer: Flags | None = None) -> float:
        """Returns the total excess of all points, or of the `outer` points, times the area of each [m²]."""
        return self.point_area * total_excess(self.distances if outer is None else self.distances[outer])


def total_excess(distances: Numbers) -> float:
    """Returns the sum of the distances (n,) beyond `_FREE_DISTANCE`, all in tolerances."""
    return float(np.maximum(distances - _FREE_DISTANCE, 0.0).sum())


def qhull(points: Points) -> Any | None:
    """Returns Qhull's hull of points (n, 3); None if the hull is flat."""
    if len(points) < 4:
        return None
    try:
        hull = scipy.spatial.ConvexHull(points)
    except scipy.spatial.QhullError:
        return None
    return hull if hull.volume > hull.area * _MIN_THICKNESS else None


class EngineHull(NamedTuple):
    """A hull in the form of the collision engine, with all its corners, and its volume [m³]."""

    solid: Any
    volume: float


def engine_hull(points: Points) -> EngineHull | None:
    """Returns the hull of points (n, 3) for the engine; None if the hull is flat."""
    hull = qhull(points)
    if hull is None:
        return None
    surface = _surface_of_hull(hull, points)
    return EngineHull(_engine_form(surface), float(hull.volume))


def _engine_form(solid: Surface) -> Any:
    """Returns the engine's form of a convex solid, with fewer corners if a corner has too many neighbours."""
    if np.bincount(solid.triangles.ravel()).max() > _MAX_NEIGHBOURS:
        solid = capped_hull(solid, _MAX_NEIGHBOURS) or solid
    return engine().convex(solid.vertices, solid.triangles)


def hull_surface(points: Points) -> Surface | None:
    """Returns the hull of points (n, 3) with all its corners; None if the hull is flat."""
    hull = qhull(points)
    return None if hull is None else _surface_of_hull(hull, points)


def _surface_of_hull(hull: Any, points: Points) -> Surface:
    """Converts Qhull's hull of these points to a surface that faces outwards."""
    new_index = np.empty(len(points), dtype=np.int64)
    new_index[hull.vertices] = np.arange(len(hull.vertices))
    surface = Surface(points[hull.vertices], new_index[hull.simplices])
    return Surface(surface.vertices, outwards(surface, hull))


def hull_chunk(surface: Surface, max_vertices: int, collider_index: int) -> Chunk | None:
    """Returns the chunk of a surface with the surface's hull as its piece; None if the hull is flat. Each
    vertex must belong to a triangle."""
    # Reducing the hull takes a third of the time of reducing the surface, which has far more triangles.
    hull = hull_surface(surface.vertices)
    return None if hull is None else Chunk.of_hull(surface, hull, max_vertices, collider_index)


_INNER_WEIGHTS = [
    (a / 6, b / 6, (6 - a - b) / 6) for a in range(7) for b in range(7 - a) if max(a, b, 6 - a - b) < 6
]
"""Barycentric coordinates of sample points of a triangle, in steps of 1/6, without its corners."""

_CELL_STRIDE = 1 << 12
"""Factor from the index of a cell along an axis to the next axis: more than the number of cells along any
axis, so that each cell has its own number."""


def cloud_of(surface: Surface, cells_along_diagonal: int = _CELLS_ALONG_DIAGONAL) -> Points:
    """Returns sample points (n, 3) of the triangles of a surface, at most one in each cell of a grid."""
    points = surface.vertices
    low = points.min(axis=0)
    cell_size = float(np.linalg.norm(np.ptp(points, axis=0))) / cells_along_diagonal
    # Triangles that are larger than the face of a cell get points inside, too. The length of a normal is
    # twice the area of its triangle.
    large = surface.corners[np.linalg.norm(surface.normals(), axis=1) > 2 * cell_size**2]
    inner = [np.einsum("mij,i->mj", large, np.array(weights)) for weights in _INNER_WEIGHTS]
    all_points = np.concatenate([points, *inner])
    cells = np.floor((all_points - low) / cell_size).astype(np.int64)
    _, first = np.unique(cells @ np.array([1, _CELL_STRIDE, _CELL_STRIDE**2]), return_index=True)
    return all_points[np.sort(first)]
