"""Normals of a mesh that is smooth where its faces meet at a small angle, and has an edge elsewhere."""

import numpy as np

from stages.mesh.view.raster import Corners, Indices, Numbers

_CREASE = np.cos(np.radians(32.0))
_MOST_PAIRS = 12_000_000
"""With more pairs of faces at a corner each face is flat, which at that density is not seen."""


def normals_of(vertices: Numbers, faces: Indices) -> Corners:
    """(m, 3, 3): the unit normal at each corner of the faces (m, 3) of `vertices` (n, 3) [m]; of a face
    without area zero."""
    corners = vertices[faces]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat = _unit(np.asarray(areas, dtype=np.float64))
    result = np.repeat(flat[:, None], 3, axis=1)
    # By place: a file may have each vertex once for each face.
    _, place = np.unique(vertices, axis=0, return_inverse=True)
    corner_place = place.reshape(-1)[faces].reshape(-1)
    order = np.argsort(corner_place, kind="stable")
    count = np.bincount(corner_place)
    if int((count.astype(np.int64) ** 2).sum()) > _MOST_PAIRS:
        return result
    start = np.cumsum(count) - count
    own = np.arange(len(corner_place))
    number = count[corner_place]
    one = np.repeat(own, number)
    within = np.arange(len(one)) - np.repeat(np.cumsum(number) - number, number)
    other = order[start[corner_place[one]] + within]
    alike = (flat[one // 3] * flat[other // 3]).sum(axis=1) > _CREASE
    one, other = one[alike], other[alike]
    total: Numbers = np.stack(
        [np.bincount(one, areas[other // 3, axis], minlength=len(own)) for axis in range(3)], axis=1
    )
    smooth = _unit(total)
    found = (smooth * smooth).sum(axis=1) > 0
    flat_corners = result.reshape(-1, 3)
    flat_corners[found] = smooth[found]
    return result


def _unit(vectors: Numbers) -> Numbers:
    lengths = np.sqrt((vectors * vectors).sum(axis=-1, keepdims=True))
    return np.asarray(np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0))
