"""A piece of a collider: some triangles of a link, and the convex solid around them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.fit import capped_hull
from linkwright.stages.mesh.surfaces.convex_hull import outwards
from linkwright.stages.mesh.surfaces.pieces import Piece, surface_of
from linkwright.stages.mesh.surfaces.snapping import snapped
from linkwright.stages.robot.contact.clearance import engine

_THIN = 1e-6
"""A hull of less volume than its area times this [m] is flat."""

_MOST_NEIGHBOURS = 254
"""Coal counts a corner's neighbours with a byte (3.0.3), and raises an error where it has more."""

_CLOUD = 30
"""Cells along the diagonal of a piece, of each of which one point stands for all."""


@dataclass(frozen=True, slots=True, eq=False)
class Chunk:
    """`surface`: triangles in the link's frame, none of a piece that stays as it is; `piece`: the solid
    around them; `convex`: the same in the engine; `volume` [m³]; `group`: of which of its link's colliders
    it is."""

    surface: Surface
    piece: Piece
    convex: Any
    volume: float
    group: int = -1
    _cloud: list[Points] = field(default_factory=list)

    @staticmethod
    def of(surface: Surface, piece: Piece, group: int = -1) -> Chunk:
        """A primitive is compared as the polyhedron that stands for it."""
        solid = surface_of(piece)
        return Chunk(surface, piece, _in_engine(solid), solid.volume(), group)

    @staticmethod
    def around(surface: Surface, whole: Surface, max_vertices: int, group: int) -> Chunk | None:
        """Of a surface whose hull is `whole`, with at most `max_vertices`, as it is written; None where that
        is flat."""
        hull = capped_hull(whole, max_vertices)
        return None if hull is None else Chunk.of(surface, snapped(hull), group)

    def __reduce__(self) -> tuple[Any, ...]:
        """As a pickle: without the engine's own form."""
        return Chunk.of, (self.surface, self.piece, self.group)

    @property
    def stays(self) -> bool:
        """Whether it is neither cut nor joined."""
        return not len(self.surface.triangles)

    @property
    def corners(self) -> Points:
        """(n, 3): of the solid."""
        return surface_of(self.piece).vertices

    def cloud(self) -> Points:
        """(n, 3): points all over the triangles, as few as show their shape."""
        if not self._cloud:
            self._cloud.append(cloud_of(self.surface))
        return self._cloud[0]


def hull_of(points: Points) -> Any | None:
    """Qhull's hull of points (n, 3); None where it is flat."""
    # Late: a part from the cache needs no library that makes colliders or decimates.
    from scipy.spatial import ConvexHull, QhullError

    if len(points) < 4:
        return None
    try:
        hull = ConvexHull(points)
    except QhullError:
        return None
    return hull if hull.volume > hull.area * _THIN else None


def rough(points: Points) -> tuple[Any, float] | None:
    """The hull of points in the engine, with all corners, and its volume [m³]; None where it is flat."""
    hull = hull_of(points)
    if hull is None:
        return None
    surface = _faced(hull, points)
    return _in_engine(surface), float(hull.volume)


def _in_engine(solid: Surface) -> Any:
    """A convex solid as the engine keeps it, with fewer corners where one of them has too many neighbours."""
    if np.bincount(solid.triangles.ravel()).max() > _MOST_NEIGHBOURS:
        solid = capped_hull(solid, _MOST_NEIGHBOURS) or solid
    return engine().convex(solid.vertices, solid.triangles)


def whole_hull(points: Points) -> Surface | None:
    """The hull of points (n, 3) with all its corners; None where it is flat."""
    hull = hull_of(points)
    return None if hull is None else _faced(hull, points)


def _faced(hull: Any, points: Points) -> Surface:
    """Qhull's hull of these points as a surface that faces outwards."""
    place = np.empty(len(points), dtype=np.int64)
    place[hull.vertices] = np.arange(len(hull.vertices))
    surface = Surface(points[hull.vertices], place[hull.simplices])
    return Surface(surface.vertices, outwards(surface, hull))


def hulled(surface: Surface, max_vertices: int, group: int) -> Chunk | None:
    """The piece around a surface that has no other points; None where that is flat."""
    # Of thousands of points those that matter first: it takes a third of the time.
    whole = whole_hull(surface.vertices)
    return None if whole is None else Chunk.around(surface, whole, max_vertices, group)


def cloud_of(surface: Surface, along: int = _CLOUD) -> Points:
    """(n, 3): points all over the triangles of a surface, at most one in each of the cells of which there are
    so many `along` its diagonal."""
    points = surface.vertices
    low = points.min(axis=0)
    size = float(np.linalg.norm(np.ptp(points, axis=0))) / along
    # A large triangle has points inside, too.
    large = surface.corners[np.linalg.norm(surface.normals(), axis=1) > 2 * size * size]
    inner = [np.einsum("mij,i->mj", large, np.array(weights)) for weights in _WEIGHTS]
    every = np.concatenate([points, *inner])
    cells = np.floor((every - low) / size).astype(np.int64)
    _, first = np.unique(cells @ np.array([1, 1 << 12, 1 << 24]), return_index=True)
    return every[np.sort(first)]


_WEIGHTS = [
    (a / 6, b / 6, (6 - a - b) / 6) for a in range(7) for b in range(7 - a) if max(a, b, 6 - a - b) < 6
]
"""Of the corners of a triangle: points spread over it."""
