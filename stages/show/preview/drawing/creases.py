"""Normals of a surface that is smooth where its faces meet at a small angle, and has an edge elsewhere."""

import numpy as np

from linkwright.stages.show.preview.drawing.vectors import cross, dot, unit
from linkwright.stages.show.preview.surface import Single
from linkwright.stages.show.raster import Indices

_CREASE = np.float32(np.cos(np.radians(32.0)))
_MOST_PAIRS = 12_000_000
"""With more pairs of faces at a corner each face is flat, which at that density is not seen."""

_TABLE = 1 << 22
_PRIMES = np.array([73856093, 19349663, 83492791], dtype=np.int64)


def normals_of(corners: Single, geom: Indices, wanted: Indices) -> Single:
    """(n, 3, 3): the unit normal at each corner of the `wanted` (n,) of the triangles (m, 3, 3); of a
    triangle without area zero. Faces of different geoms (m,) do not meet."""
    near, place = _beside(corners, geom, wanted)
    faces = corners[near]
    areas = cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    flat = unit(areas)
    result = np.repeat(flat[: len(wanted), None], 3, axis=1)
    order = np.argsort(place.reshape(-1), kind="stable")
    count = np.bincount(place.reshape(-1))
    start = np.cumsum(count) - count
    own = place[: len(wanted)].reshape(-1)
    number = count[own]
    if int(number.sum()) > _MOST_PAIRS:
        return result
    corner = np.repeat(np.arange(len(own)), number)
    within = np.arange(len(corner)) - np.repeat(np.cumsum(number) - number, number)
    other = order[start[own[corner]] + within] // 3
    alike = dot(flat[corner // 3], flat[other]) > _CREASE
    corner, other = corner[alike], other[alike]
    total = np.stack(
        [np.bincount(corner, areas[other, axis], minlength=len(own)) for axis in range(3)], axis=1
    )
    smooth = unit(total.astype(np.float32))
    found = dot(smooth, smooth) > 0
    result.reshape(-1, 3)[found] = smooth[found]
    return result


def _beside(corners: Single, geom: Indices, wanted: Indices) -> tuple[Indices, Indices]:
    """The wanted triangles, and after them those that have a corner with one of them; and of each corner of
    these (n, 3) its place, by number."""
    bits = np.ascontiguousarray(corners + np.float32(0.0)).view(np.int32).reshape(-1, 3)
    hashed = dot(bits.astype(np.int64), _PRIMES).reshape(-1, 3)
    hashed += (geom * 2654435761)[:, None]
    slot = (hashed ^ (hashed >> 22)) & (_TABLE - 1)
    table = np.zeros(_TABLE, dtype=np.bool_)
    table[slot[wanted]] = True
    near = table[slot[:, 0]] | table[slot[:, 1]] | table[slot[:, 2]]
    near[wanted] = False
    both = np.concatenate([wanted, np.flatnonzero(near)])
    _, place = np.unique(hashed[both], return_inverse=True)
    return both, place.reshape(-1, 3)
