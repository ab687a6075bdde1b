"""Defines a piece of a collider: some triangles of a link, and the convex solid around them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.fit import capped_hull
from linkwright.stages.mesh.surfaces.convex_hull import outwards
from linkwright.stages.mesh.surfaces.pieces import Piece, surface_of
from linkwright.stages.mesh.surfaces.snapping import snapped
from linkwright.stages.robot.contact.clearance import engine

_MIN_THICKNESS = 1e-6
"""Smallest ratio [m] between the volume and the area of a hull that is not flat."""

_MAX_NEIGHBOURS = 254
"""Largest number of neighbours of a corner: Coal (3.0.3) counts them in a byte, and raises an error for
more."""

_CELLS_ALONG_DIAGONAL = 30
"""Number of cells along the diagonal of a piece; each has at most one point of its cloud."""


@dataclass(frozen=True, slots=True, eq=False)
class Chunk:
    """A piece of a collider with the triangles that it encloses."""

    surface: Surface
    """Triangles in the link's frame; none for a piece that stays as it is."""
    piece: Piece
    """Solid around the triangles."""
    convex: Any
    """The solid in the form of the collision engine."""
    volume: float
    """Volume of the solid [m³]."""
    group: int = -1
    """Index of the collider in the link."""
    _cloud: list[Points] = field(default_factory=list)

    @staticmethod
    def of(surface: Surface, piece: Piece, group: int = -1) -> Chunk:
        """Returns the chunk of a piece; the engine gets the polyhedron of a primitive."""
        solid = surface_of(piece)
        return Chunk(surface, piece, _in_engine(solid), solid.volume(), group)

    @staticmethod
    def around(surface: Surface, whole: Surface, max_vertices: int, group: int) -> Chunk | None:
        """Returns the chunk of a surface whose hull is `whole`; its piece has at most `max_vertices`, and is
        snapped to the grid of files. None if the piece is flat."""
        hull = capped_hull(whole, max_vertices)
        return None if hull is None else Chunk.of(surface, snapped(hull), group)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickles the chunk without the engine's form of the solid."""
        return Chunk.of, (self.surface, self.piece, self.group)

    @property
    def stays(self) -> bool:
        """Whether the piece is neither cut nor joined."""
        return not len(self.surface.triangles)

    @property
    def corners(self) -> Points:
        """Corners of the solid (n, 3)."""
        return surface_of(self.piece).vertices

    def cloud(self) -> Points:
        """Returns points (n, 3) all over the triangles, as few as show their shape."""
        if not self._cloud:
            self._cloud.append(cloud_of(self.surface))
        return self._cloud[0]


def hull_of(points: Points) -> Any | None:
    """Returns Qhull's hull of points (n, 3); None if it is flat."""
    if len(points) < 4:
        return None
    try:
        hull = scipy.spatial.ConvexHull(points)
    except scipy.spatial.QhullError:
        return None
    return hull if hull.volume > hull.area * _MIN_THICKNESS else None


def rough(points: Points) -> tuple[Any, float] | None:
    """Returns the engine's form of the hull of points, with all corners, and its volume [m³]; None if
    flat."""
    hull = hull_of(points)
    if hull is None:
        return None
    surface = _faced(hull, points)
    return _in_engine(surface), float(hull.volume)


def _in_engine(solid: Surface) -> Any:
    """Returns the engine's form of a convex solid, with fewer corners if a corner has too many neighbours."""
    if np.bincount(solid.triangles.ravel()).max() > _MAX_NEIGHBOURS:
        solid = capped_hull(solid, _MAX_NEIGHBOURS) or solid
    return engine().convex(solid.vertices, solid.triangles)


def whole_hull(points: Points) -> Surface | None:
    """Returns the hull of points (n, 3) with all its corners; None if it is flat."""
    hull = hull_of(points)
    return None if hull is None else _faced(hull, points)


def _faced(hull: Any, points: Points) -> Surface:
    """Converts Qhull's hull of these points to a surface that faces outwards."""
    place = np.empty(len(points), dtype=np.int64)
    place[hull.vertices] = np.arange(len(hull.vertices))
    surface = Surface(points[hull.vertices], place[hull.simplices])
    return Surface(surface.vertices, outwards(surface, hull))


def hulled(surface: Surface, max_vertices: int, group: int) -> Chunk | None:
    """Returns the piece around a surface whose vertices are all used; None if it is flat."""
    # The hull of all points first: that takes a third of the time.
    whole = whole_hull(surface.vertices)
    return None if whole is None else Chunk.around(surface, whole, max_vertices, group)


def cloud_of(surface: Surface, along: int = _CELLS_ALONG_DIAGONAL) -> Points:
    """Returns points (n, 3) all over the triangles of a surface, at most one in each cell of a grid; `along`:
    number of cells along the diagonal."""
    points = surface.vertices
    low = points.min(axis=0)
    size = float(np.linalg.norm(np.ptp(points, axis=0))) / along
    # Large triangles get points inside, too.
    large = surface.corners[np.linalg.norm(surface.normals(), axis=1) > 2 * size * size]
    inner = [np.einsum("mij,i->mj", large, np.array(weights)) for weights in _INNER_WEIGHTS]
    all_points = np.concatenate([points, *inner])
    cells = np.floor((all_points - low) / size).astype(np.int64)
    _, first = np.unique(cells @ np.array([1, 1 << 12, 1 << 24]), return_index=True)
    return all_points[np.sort(first)]


_INNER_WEIGHTS = [
    (a / 6, b / 6, (6 - a - b) / 6) for a in range(7) for b in range(7 - a) if max(a, b, 6 - a - b) < 6
]
"""Weights of a triangle's corners that give points spread over it."""
