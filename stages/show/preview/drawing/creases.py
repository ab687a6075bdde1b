"""Computes vertex normals that are smooth across shallow edges, and keep sharp edges (creases) sharp."""

import numpy as np

from linkwright.stages.show.preview.drawing.vectors import cross, dot, unit_vectors
from linkwright.stages.show.preview.surface import Single
from linkwright.stages.show.raster import Indices

_CREASE_COSINE = np.float32(np.cos(np.radians(32.0)))
"""Cosine of the crease angle: edges between faces at a larger angle stay sharp."""

_MAX_PAIRS = 12_000_000
"""Largest number of pairs of adjacent faces. With more, faces are drawn flat: they are too small to see."""

_TABLE_SIZE = 1 << 22
"""Slots of the hash table; a power of two."""

_PRIMES = np.array([73856093, 19349663, 83492791], dtype=np.int64)
"""Factors of the usual spatial hash (Teschner et al., 2003)."""


def normals_of(corners: Single, geom: Indices, selected: Indices) -> Single:
    """Returns the unit normals (n, 3, 3) at the corners of the `selected` triangles (n,) among all triangles
    `corners` (m, 3, 3): averages, weighted by area, over the adjacent faces at less than the crease angle.

    Triangles of different geoms `geom` (m,) are not adjacent. The normals of a degenerate triangle are zero.
    """
    adjacent, vertex = _with_adjacent(corners, geom, selected)
    faces = corners[adjacent]
    areas = cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    flat_normals = unit_vectors(areas)
    result = np.repeat(flat_normals[: len(selected), None], 3, axis=1)
    # All corners sorted by their vertex: those of a vertex are a run of `count` from `start`.
    order = np.argsort(vertex.reshape(-1), kind="stable")
    count = np.bincount(vertex.reshape(-1))
    start = np.cumsum(count) - count
    selected_vertex = vertex[: len(selected)].reshape(-1)
    face_count = count[selected_vertex]
    if int(face_count.sum()) > _MAX_PAIRS:
        return result
    # A pair for each corner of a selected triangle and each face at its vertex.
    corner = np.repeat(np.arange(len(selected_vertex)), face_count)
    rank = np.arange(len(corner)) - np.repeat(np.cumsum(face_count) - face_count, face_count)
    adjacent_face = order[start[selected_vertex[corner]] + rank] // 3
    smooth_pairs = dot(flat_normals[corner // 3], flat_normals[adjacent_face]) > _CREASE_COSINE
    corner, adjacent_face = corner[smooth_pairs], adjacent_face[smooth_pairs]
    normal_sums = np.stack(
        [
            np.bincount(corner, areas[adjacent_face, axis], minlength=len(selected_vertex))
            for axis in range(3)
        ],
        axis=1,
    )
    smooth_normals = unit_vectors(normal_sums.astype(np.float32))
    valid = dot(smooth_normals, smooth_normals) > 0
    result.reshape(-1, 3)[valid] = smooth_normals[valid]
    return result


def _with_adjacent(corners: Single, geom: Indices, selected: Indices) -> tuple[Indices, Indices]:
    """Returns the indices of the `selected` triangles, followed by those that share a corner with them; and
    for each of their corners (k, 3) the number of its vertex, equal for coincident corners of a geom.

    Corners are matched by a spatial hash of their coordinates' bits: a table of booleans finds the candidates
    without sorting all triangles of the robot. A collision of two hashes can only smooth a normal wrongly.
    """
    # Adding 0.0 turns -0.0 into 0.0, which has other bits.
    bits = np.ascontiguousarray(corners + np.float32(0.0)).view(np.int32).reshape(-1, 3)
    hashes = dot(bits.astype(np.int64), _PRIMES).reshape(-1, 3)
    hashes += (geom * 2654435761)[:, None]
    # The upper bits are folded into the slot, which else depends on the lowest bits only.
    slot = (hashes ^ (hashes >> 22)) & (_TABLE_SIZE - 1)
    table = np.zeros(_TABLE_SIZE, dtype=np.bool_)
    table[slot[selected]] = True
    adjacent = table[slot[:, 0]] | table[slot[:, 1]] | table[slot[:, 2]]
    adjacent[selected] = False
    indices = np.concatenate([selected, np.flatnonzero(adjacent)])
    _, vertex = np.unique(hashes[indices], return_inverse=True)
    return indices, vertex.reshape(-1, 3)
