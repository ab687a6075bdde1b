"""Triangles of the compiled model, and how the page has them: 16 bits a coordinate, welded."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.show.live.pack import Buffers
from linkwright.stages.show.live.rounding import vector

STEPS = 65_535
_SHORT = 65_536
"""Meshes with at most so many points have indices of 2 bytes."""

Points = npt.NDArray[np.float64]
Corners = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Facets:
    """Triangles: `points` (n, 3) [m], `corners` (m, 3), and how many triangles there were before thinning."""

    points: Points
    corners: Corners
    of_faces: int

    @property
    def size(self) -> float:
        """The diagonal [m]."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0))) if len(self.points) else 0.0


def of_mesh(model: Any, index: int) -> Facets:
    """A mesh of the model, in the frame that the positions of its geoms mean; of one without triangles, which
    a point cloud is, its convex hull."""
    first, count = int(model.mesh_vertadr[index]), int(model.mesh_vertnum[index])
    points = model.mesh_vert[first : first + count].astype(np.float64)
    first, count = int(model.mesh_faceadr[index]), int(model.mesh_facenum[index])
    corners = model.mesh_face[first : first + count].astype(np.int64)
    if not len(corners):
        corners = hull_of(model, index)
    return Facets(points, corners, len(corners))


def hull_of(model: Any, index: int) -> Corners:
    """(m, 3): the triangles of a mesh's convex hull, as points of the mesh; none where MuJoCo made no hull.

    Layout of `mesh_graph`: numbers of vertices and faces, then for each vertex its edges' address and its
    number among the mesh's points, the edges, and the faces (mjmodel.h).
    """
    start = int(model.mesh_graphadr[index])
    if start < 0:
        return np.empty((0, 3), dtype=np.int64)
    vertices, faces = (int(one) for one in model.mesh_graph[start : start + 2])
    begin = start + 2 + 2 * vertices + vertices + 3 * faces
    return np.asarray(model.mesh_graph[begin : begin + 3 * faces], dtype=np.int64).reshape(-1, 3)


def of_hfield(model: Any, index: int) -> Facets:
    """The surface of a height field."""
    rows, columns = int(model.hfield_nrow[index]), int(model.hfield_ncol[index])
    x, y, height, _ = (float(one) for one in model.hfield_size[index])
    start = int(model.hfield_adr[index])
    heights = model.hfield_data[start : start + rows * columns].astype(np.float64) * height
    across, along = np.meshgrid(np.linspace(-x, x, columns), np.linspace(-y, y, rows))
    points = np.stack([across.ravel(), along.ravel(), heights], axis=1)
    grid = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    corners = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    return Facets(points, corners.astype(np.int64), len(corners))


def stored(facets: Facets, buffers: Buffers) -> dict[str, Any]:
    """A mesh's entry in the header: positions as multiples of a step from an origin. Points that fall
    together are one, and triangles without three different points are left out."""
    points = facets.points if len(facets.points) else np.zeros((1, 3))
    origin = np.array(vector(points.min(axis=0)))
    step = np.array(vector(np.ptp(points, axis=0) / STEPS))
    scaled = (points - origin) / np.where(step > 0.0, step, 1.0)
    steps = np.clip(np.rint(scaled), 0, STEPS).astype(np.uint16)
    places, corners = _welded(steps, facets.corners)
    width = 2 if len(places) <= _SHORT else 4
    kind = "<u2" if width == 2 else "<u4"
    return {
        "positions": {
            "at": buffers.add(places.astype("<u2").tobytes()),
            "count": len(places),
            "origin": origin.tolist(),
            "step": step.tolist(),
        },
        "indices": {"at": buffers.add(corners.astype(kind).tobytes()), "count": corners.size, "bytes": width},
        "faces": len(corners),
        "of_faces": facets.of_faces,
    }


def _welded(steps: npt.NDArray[np.uint16], corners: Corners) -> tuple[npt.NDArray[np.uint16], Corners]:
    """The points in the order in which the triangles have them, each once, and the triangles."""
    keys = steps.astype(np.int64) @ np.array([1 << 32, 1 << 16, 1])
    _, first, same = np.unique(keys, return_index=True, return_inverse=True)
    mapped = same.ravel()[corners]
    whole = (mapped[:, 0] != mapped[:, 1]) & (mapped[:, 1] != mapped[:, 2]) & (mapped[:, 2] != mapped[:, 0])
    mapped = mapped[whole]
    used, appears = np.unique(mapped, return_index=True)
    order = used[np.argsort(appears, kind="stable")]
    place = np.zeros(len(first), dtype=np.int64)
    place[order] = np.arange(len(order))
    return steps[first[order]], place[mapped]
