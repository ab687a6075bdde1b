"""A closed surface around triangles that bound nothing: sheets with gaps, edges of three faces, holes.

It lies at a given distance around them, and what it encloses is filled. Found on a grid: the distance of
each node near the triangles, a flood from outside that stops at that distance, and marching tetrahedra,
which leave no hole (Doi and Koide 1991: six to each cube of the grid, alike in all of them).
"""

from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt

from stages.mesh.surface import Points, Surface, Triangles

_DENSE = 0.5
"""The greatest distance of the points that stand for a triangle, in pitches of the grid."""

_MARGIN = 3
_MOST_NODES = 16_000_000

_Field = npt.NDArray[np.float64]


def closed_around(surface: Surface, distance: float) -> Surface:
    """The closed surface `distance` [m] around the triangles; gaps of up to twice that are bridged."""
    points = dense(surface, distance * _DENSE)
    low = points.min(axis=0) - _MARGIN * distance
    shape = np.ceil((points.max(axis=0) - low) / distance).astype(np.int64) + _MARGIN + 1
    if np.prod(shape.astype(np.float64)) > _MOST_NODES:
        return Surface(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))
    vertices, triangles = marched(_depth(points, low, shape, distance))
    return Surface(vertices * distance + low, triangles)


def dense(surface: Surface, spacing: float) -> Points:
    """Points on the triangles, their corners among them, nowhere further apart than `spacing` [m]."""
    corners = surface.corners
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    pieces = np.maximum(1, np.ceil(longest / spacing)).astype(np.int64)
    found = [surface.vertices]
    for count in np.unique(pieces).tolist():
        steps = np.array([(a, b) for a in range(count + 1) for b in range(count + 1 - a)]) / count
        a, b, c = np.moveaxis(corners[pieces == count], 1, 0)
        across = a[:, None] + steps[:, 0, None] * (b - a)[:, None] + steps[:, 1, None] * (c - a)[:, None]
        found.append(across.reshape(-1, 3))
    return np.concatenate(found)


def one_a_cell(points: Points, side: float) -> Points:
    """The first of the points in each cube of a grid with sides of that length [m]."""
    _, first = np.unique(np.rint(points / side).astype(np.int64), axis=0, return_index=True)
    return np.asarray(points[np.sort(first)], dtype=np.float64)


def _depth(points: Points, low: Points, shape: npt.NDArray[np.int64], pitch: float) -> _Field:
    """At each node how deep it lies within the surface to be, in pitches: negative outside."""
    from scipy.ndimage import binary_dilation, label
    from scipy.spatial import cKDTree

    near = np.zeros(shape, dtype=bool)
    near[tuple(np.rint((points - low) / pitch).astype(np.int64).T)] = True
    near = binary_dilation(near, iterations=2, structure=np.ones((3, 3, 3)))
    away, _ = cKDTree(points).query(np.argwhere(near) * pitch + low)
    depth = np.full(shape, -1.0)
    depth[near] = 1.0 - away / pitch
    regions, _ = label(depth < 0)
    depth[(depth < 0) & (regions != regions[0, 0, 0])] = 1.0
    # A node exactly on the surface would make it touch itself.
    return np.where(np.abs(depth) < 1e-6, 1e-6, depth)


def marched(depth: _Field) -> tuple[Points, Triangles]:
    """The closed surface where `depth` is 0, around what is positive; the border must be negative."""
    shape = np.array(depth.shape)
    strides = np.array([shape[1] * shape[2], shape[2], 1])
    flat = depth.ravel()
    crossed = _crossed_cubes(depth)
    starts, ends = [], []
    for order in itertools.permutations(range(3)):
        # From one corner of the cube to the opposite one along its edges: six ways, six tetrahedra.
        corners = np.stack([crossed + strides[list(order[:k])].sum() for k in range(4)], axis=1)
        odd = order in ((0, 2, 1), (1, 0, 2), (2, 1, 0))
        for start, end in _faces(corners, flat[corners] > 0, odd):
            starts.append(start)
            ends.append(end)
    edges = np.stack([np.concatenate(starts).ravel(), np.concatenate(ends).ravel()], axis=1)
    edges.sort(axis=1)
    distinct, index = np.unique(edges, axis=0, return_inverse=True)
    a, b = flat[distinct[:, 0]], flat[distinct[:, 1]]
    places = np.stack(np.unravel_index(distinct, depth.shape), axis=-1).astype(np.float64)
    share = (a / (a - b))[:, None]
    return places[:, 0] + share * (places[:, 1] - places[:, 0]), index.reshape(-1, 3).astype(np.int64)


def _crossed_cubes(depth: _Field) -> npt.NDArray[np.int64]:
    """The first nodes of the cubes through which the surface goes."""
    inside = depth > 0
    count = np.zeros(tuple(side - 1 for side in depth.shape), dtype=np.int8)
    for x, y, z in itertools.product((0, 1), repeat=3):
        nx, ny, nz = count.shape
        count += inside[x : x + nx, y : y + ny, z : z + nz]
    where = np.argwhere((count > 0) & (count < 8))
    return np.asarray(np.ravel_multi_index(tuple(where.T), depth.shape), dtype=np.int64)


_SPLITS = [
    ((0,), (1, 2, 3)),
    ((1,), (0, 3, 2)),
    ((2,), (0, 1, 3)),
    ((3,), (0, 2, 1)),
    ((0, 1), (2, 3)),
    ((0, 2), (3, 1)),
    ((0, 3), (1, 2)),
]
"""Corners of a tetrahedron on one side, and the others, in even order."""


def _faces(
    corners: npt.NDArray[np.int64], inside: npt.NDArray[np.bool_], odd: bool
) -> list[tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]]:
    """The triangles in tetrahedra (n, 4), as the two ends of the grid's edges on which their corners lie."""
    found = []
    for one, other in _SPLITS:
        for of_one in (True, False):
            chosen = (inside[:, one] == of_one).all(axis=1) & (inside[:, other] != of_one).all(axis=1)
            cut = corners[chosen]
            if len(one) == 1:
                triangles = [[(one[0], end) for end in other]]
            else:
                (a, b), (c, d) = one, other
                triangles = [[(a, c), (a, d), (b, d)], [(a, c), (b, d), (b, c)]]
            for triangle in triangles:
                turned = triangle if of_one != odd else triangle[::-1]
                found.append((cut[:, [edge[0] for edge in turned]], cut[:, [edge[1] for edge in turned]]))
    return found
