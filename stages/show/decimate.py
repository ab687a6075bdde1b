"""Simplifies a surface, and keeps the borders between its colours closed.

It uses manifold3d because of measurements: fast-simplification leaves three to five times as many of CAD's
long thin triangles, and moves the surface two to eight times as far. manifold3d takes closed manifolds only:
every other mesh is cut along its bad edges, and each border is closed by a cone of triangles, which is
removed afterwards.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.components import components
from linkwright.stages.formats.meshes.surface import Points, Surface, Triangles, weld

if TYPE_CHECKING:
    from manifold3d import Manifold

SNAP = 1e-6
"""Step to whose multiples coordinates are rounded, as a share of the part's diagonal: the last digits of a
simplification may differ between processors."""

_NEXT_CORNERS = np.array([1, 2, 0])
"""The next corner of a triangle after each corner."""

_KEPT_SHARE = 0.7
"""Share of the triangles that the next higher level usually keeps."""


@dataclass(frozen=True, slots=True, eq=False)
class Simplifiable:
    """A surface as a manifold, which can be simplified with any tolerance."""

    surface: Surface
    colours: int
    """Number of colours."""

    body: "Manifold | None"
    """The manifold; None if the surface cannot be simplified."""

    first: int = 0
    """Id of the first colour in the manifold library; the ids of the other colours follow."""

    @staticmethod
    def of(surface: Surface, colour_of: npt.NDArray[np.int64], colours: int = 1) -> "Simplifiable":
        """Makes the manifold of a surface. `colour_of` (m,): the colour of each triangle, from 0 to
        `colours` - 1."""
        # Late: a part from the cache needs no library that makes colliders or decimates.
        from manifold3d import Error, Manifold, Mesh64

        points, triangles, sources = _closed_manifold(surface)
        # A run of triangles for each colour: an edge between two runs only moves along its own line.
        runs = np.where(sources < 0, colours, colour_of[sources])
        order = np.argsort(runs, kind="stable")
        bounds = np.searchsorted(runs[order], np.arange(colours + 2))
        first = Manifold.reserve_ids(colours + 1)
        body = Manifold(
            Mesh64(
                points,
                triangles[order].astype(np.uint64),
                run_index=(bounds * 3).astype(np.uint64),
                run_original_id=np.arange(first, first + colours + 1, dtype=np.uint32),
            )
        )
        return Simplifiable(surface, colours, body if body.status() == Error.NoError else None, first)

    def simplified(self, tolerance: float) -> tuple[Surface, npt.NDArray[np.int64]] | None:
        """Returns the simplified surface, moved by about `tolerance` [m] at most, and the colour of each of
        its triangles; None if it cannot be simplified. A border between two colours stays a common line of
        both.
        """
        if self.body is None:
            return None
        mesh = self.body.simplify(tolerance).to_mesh64()
        corners = np.asarray(mesh.tri_verts).astype(np.int64).reshape(-1, 3)
        ends = np.asarray(mesh.run_index, dtype=np.int64)
        lengths = (ends[1:] - ends[:-1]) // 3
        colours = np.repeat(np.asarray(mesh.run_original_id).astype(np.int64) - self.first, lengths)
        triangles_of_surface = np.flatnonzero(colours < self.colours)
        vertices = _rounded(np.asarray(mesh.vert_properties, dtype=np.float64)[:, :3], self.surface)
        surface, kept_triangles = weld(vertices, corners[triangles_of_surface])
        return (surface, colours[triangles_of_surface][kept_triangles]) if len(surface.triangles) else None


def _rounded(points: Points, surface: Surface) -> Points:
    step = SNAP * float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
    return np.asarray(np.round(points / step) * step + 0.0, dtype=np.float64) if step else points


def _closed_manifold(surface: Surface) -> tuple[Points, Triangles, npt.NDArray[np.int64]]:
    """Returns points and triangles of a closed manifold that contains the surface, and for each triangle its
    index in the surface, or -1 if it closes a border."""
    if _is_manifold(surface):
        return surface.vertices, surface.triangles, np.arange(len(surface.triangles))
    corner, border = _cut(surface)
    points = np.empty((int(corner.max()) + 1, 3))
    points[corner.ravel()] = surface.corners.reshape(-1, 3)
    sources_of_surface = np.arange(len(corner))
    if not len(border):
        return points, corner, sources_of_surface
    apexes, loop = _apexes(points, border, surface)
    cones = np.stack([border[:, 1], border[:, 0], len(points) + loop], axis=1)
    sources = np.concatenate([sources_of_surface, np.full(len(cones), -1)])
    return np.concatenate([points, apexes]), np.concatenate([corner, cones]), sources


def _is_manifold(surface: Surface) -> bool:
    """Tells whether each edge has exactly one triangle on either side."""
    starts, ends = surface.triangles.ravel(), surface.triangles[:, _NEXT_CORNERS].ravel()
    count = np.int64(len(surface.vertices))
    forth, back = np.sort(starts * count + ends), np.sort(ends * count + starts)
    return np.array_equal(forth, back) and bool((forth[1:] > forth[:-1]).all())


def _cut(surface: Surface) -> tuple[Triangles, Triangles]:
    """Cuts a surface along its bad edges: returns the triangles with a separate vertex for each fan of
    triangles around a point, and the edges (k, 2) of the border.

    Two triangles stay connected across an edge only if no third triangle has it, and if they run through it
    in opposite directions.
    """

    starts = surface.triangles.ravel()
    ends = surface.triangles[:, _NEXT_CORNERS].ravel()
    low, high = np.minimum(starts, ends), np.maximum(starts, ends)
    order = np.lexsort((starts, high, low))
    key = np.stack([low[order], high[order]], axis=1)
    new = np.ones(len(key), dtype=bool)
    new[1:] = (key[1:] != key[:-1]).any(axis=1)
    begins = np.flatnonzero(new)
    pairs = begins[np.diff(np.append(begins, len(key))) == 2]
    first, second = order[pairs], order[pairs + 1]
    opposite = starts[first] != starts[second]
    first, second = first[opposite], second[opposite]
    # Half edge i leaves corner i of the flat list of triangles, and ends at the next corner of its triangle.
    following = np.arange(len(starts)).reshape(-1, 3)[:, _NEXT_CORNERS].ravel()
    links = np.concatenate([first, following[first]]), np.concatenate([following[second], second])
    label = components(len(starts), *links)
    open_edges = np.ones(len(starts), dtype=bool)
    open_edges[first] = open_edges[second] = False
    corner = label.reshape(-1, 3)
    return corner, np.stack([label[open_edges], label[following[open_edges]]], axis=1)


def _apexes(points: Points, border: Triangles, surface: Surface) -> tuple[Points, npt.NDArray[np.int64]]:
    """Returns the apex of a cone for each loop of the border, and the loop of each edge.

    The apex is as far away from the loop as the surface is large, so that simplification does not mix the
    cone with the surface.
    """
    vertices_of_border, compact = np.unique(border, return_inverse=True)
    compact = compact.reshape(-1, 2)
    label = components(len(vertices_of_border), compact[:, 0], compact[:, 1])
    count, loop = int(label.max(initial=-1)) + 1, label[compact[:, 0]]
    weights = np.bincount(loop, minlength=count)[:, None]
    middles = np.stack(
        [np.bincount(loop, points[border[:, 0], axis], minlength=count) for axis in range(3)], axis=1
    )
    corner_products = np.cross(points[border[:, 0]], points[border[:, 1]])
    normals = np.stack(
        [np.bincount(loop, corner_products[:, axis], minlength=count) for axis in range(3)], axis=1
    )
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    directions = np.where(lengths > 0, normals / np.where(lengths > 0, lengths, 1.0), [0.0, 0.0, 1.0])
    size = float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
    return middles / weights + size * directions, loop


def lowest_level(
    levels: int, faces: Callable[[int], int], max_faces: int, first_level: int | None = None
) -> int:
    """Returns the lowest level with at most `max_faces` faces; `levels` if there is none. `levels`: the
    number of levels; `faces`: function of a level, fewer for higher levels; `first_level`: the level that is
    tried first, by default the middle."""
    low, high, level = 0, levels, levels // 2 if first_level is None else first_level
    while low < high:
        count = faces(level)
        if count <= max_faces:
            high = level
        else:
            low = level + 1
        # Each level takes a while: the next try is where the number is likely reached.
        step = math.log(max(count, 1) / max(max_faces, 1)) / math.log(1 / _KEPT_SHARE)
        level = min(max(level + math.ceil(step), low), high - 1)
    return low
