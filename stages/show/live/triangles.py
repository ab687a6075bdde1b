"""Reads triangles of the compiled model, and stores them welded, with 16 bits a coordinate."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.show.live.pack import Buffers
from linkwright.stages.show.live.rounding import rounded_list

STEPS = 65_535
"""Number of steps along each axis of a mesh: a coordinate is stored in 16 bits."""

_MAX_SHORT = 65_536
"""Largest number of points of a mesh whose indices are stored in 2 bytes; others take 4."""

Points = npt.NDArray[np.float64]
Corners = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Facets:
    """Triangles: `points` (n, 3) [m], `corners` (m, 3), and the number of triangles before simplification."""

    points: Points
    corners: Corners
    of_faces: int

    @property
    def size(self) -> float:
        """The diagonal [m]."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0))) if len(self.points) else 0.0


def facets_of_mesh(model: Any, index: int) -> Facets:
    """Returns the triangles of a mesh as MuJoCo has centred and turned it: geoms' poses refer to this frame.
    For a point cloud, which has no triangles, returns those of its convex hull."""
    first, count = int(model.mesh_vertadr[index]), int(model.mesh_vertnum[index])
    points = model.mesh_vert[first : first + count].astype(np.float64)
    first, count = int(model.mesh_faceadr[index]), int(model.mesh_facenum[index])
    corners = model.mesh_face[first : first + count].astype(np.int64)
    if not len(corners):
        corners = hull_of(model, index)
    return Facets(points, corners, len(corners))


def hull_of(model: Any, index: int) -> Corners:
    """Returns the triangles (m, 3) of a mesh's convex hull, as indices of its points; empty without a hull.

    `mesh_graph` contains the numbers of vertices and faces, then for each vertex its edges' address and its
    index among the mesh's points, the edges, and the faces (mjmodel.h).
    """
    start = int(model.mesh_graphadr[index])
    if start < 0:
        return np.empty((0, 3), dtype=np.int64)
    vertices, faces = (int(number) for number in model.mesh_graph[start : start + 2])
    begin = start + 2 + 2 * vertices + vertices + 3 * faces
    return np.asarray(model.mesh_graph[begin : begin + 3 * faces], dtype=np.int64).reshape(-1, 3)


def facets_of_hfield(model: Any, index: int) -> Facets:
    """Returns the triangles of a height field's surface."""
    rows, columns = int(model.hfield_nrow[index]), int(model.hfield_ncol[index])
    x, y, height, _ = (float(length) for length in model.hfield_size[index])
    start = int(model.hfield_adr[index])
    heights = model.hfield_data[start : start + rows * columns].astype(np.float64) * height
    grid_x, grid_y = np.meshgrid(np.linspace(-x, x, columns), np.linspace(-y, y, rows))
    points = np.stack([grid_x.ravel(), grid_y.ravel(), heights], axis=1)
    grid = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    corners = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    return Facets(points, corners.astype(np.int64), len(corners))


def store(facets: Facets, buffers: Buffers) -> dict[str, Any]:
    """Stores a mesh and returns its entry in the header. Positions are multiples of a step from an origin;
    equal points are merged, and triangles without three different points are dropped."""
    points = facets.points if len(facets.points) else np.zeros((1, 3))
    origin = np.array(rounded_list(points.min(axis=0)))
    step = np.array(rounded_list(np.ptp(points, axis=0) / STEPS))
    scaled = (points - origin) / np.where(step > 0.0, step, 1.0)
    steps = np.clip(np.rint(scaled), 0, STEPS).astype(np.uint16)
    positions, corners = _welded(steps, facets.corners)
    width = 2 if len(positions) <= _MAX_SHORT else 4
    kind = "<u2" if width == 2 else "<u4"
    return {
        "positions": {
            "at": buffers.add(positions.astype("<u2").tobytes()),
            "count": len(positions),
            "origin": origin.tolist(),
            "step": step.tolist(),
        },
        "indices": {"at": buffers.add(corners.astype(kind).tobytes()), "count": corners.size, "bytes": width},
        "faces": len(corners),
        "of_faces": facets.of_faces,
    }


def _welded(steps: npt.NDArray[np.uint16], corners: Corners) -> tuple[npt.NDArray[np.uint16], Corners]:
    """Merges equal points; returns the points in the order in which triangles use them, and the triangles."""
    keys = steps.astype(np.int64) @ np.array([1 << 32, 1 << 16, 1])
    _, first_index, index_of_point = np.unique(keys, return_index=True, return_inverse=True)
    welded_corners = index_of_point.ravel()[corners]
    has_area = (
        (welded_corners[:, 0] != welded_corners[:, 1])
        & (welded_corners[:, 1] != welded_corners[:, 2])
        & (welded_corners[:, 2] != welded_corners[:, 0])
    )
    welded_corners = welded_corners[has_area]
    used_points, first_use = np.unique(welded_corners, return_index=True)
    order = used_points[np.argsort(first_use, kind="stable")]
    new_index = np.zeros(len(first_index), dtype=np.int64)
    new_index[order] = np.arange(len(order))
    return steps[first_index[order]], new_index[welded_corners]
