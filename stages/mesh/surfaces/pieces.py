"""The pieces of a collider: closed convex surfaces and primitives, and what they have in common."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, Surface, moved
from linkwright.stages.robot.dynamics.inertia import primitive_volume
from linkwright.stages.robot.model.robot import Array, Primitive, frozen

Piece = Surface | Primitive
"""A `Surface` here is closed, convex and faces outwards."""

Distances = Callable[[Points], npt.NDArray[np.float64]]
"""A distance [m] for each of the points (n, 3)."""

_AROUND = 64
_UPWARDS = 32
_MOST = 1 << 20  # elements of one intermediate array


def vertices(piece: Piece) -> int:
    """How many vertices an engine has to look at; a primitive has none."""
    return len(piece.vertices) if isinstance(piece, Surface) else 0


def volume(piece: Piece) -> float:
    """The volume [m³]."""
    return piece.volume() if isinstance(piece, Surface) else primitive_volume(piece.kind, piece.size)


def placed(piece: Piece, transform: Array) -> Piece:
    """The piece under `transform` (4, 4), a rotation or mirroring and a shift."""
    if isinstance(piece, Surface):
        return moved(piece, transform)
    rows = [[_product(row, column) for column in piece.link_from_shape.T] for row in transform]
    pose = np.array(rows)
    if np.linalg.det(pose[:3, :3]) < 0:
        pose[:, 0] *= -1  # each kind is its own mirror image
    return replace(piece, link_from_shape=frozen(pose))


def half_spaces(surface: Surface) -> tuple[Points, npt.NDArray[np.float64]]:
    """A convex surface as planes: unit normals (k, 3) and heights (k,) [m], with n·x ≤ height inside.

    Each plane touches a vertex and has all others behind it, however badly the normal of a sliver is known.
    Planes that are equal to nine digits come once.
    """
    normals = surface.normals()
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals[lengths > 0] / lengths[lengths > 0, None]
    _, first = np.unique(normals.round(9) + 0.0, axis=0, return_index=True)
    normals = normals[first]
    step = max(1, _MOST // max(1, len(surface.vertices)))
    heights = [
        along(normals[begin : begin + step], surface.vertices).max(axis=1)
        for begin in range(0, len(normals), step)
    ]
    return normals, np.concatenate(heights) if heights else np.zeros(0)


def along(normals: Points, points: Points) -> npt.NDArray[np.float64]:
    """(k, n): each of the points (n, 3) along each of the normals (k, 3).

    Written out by element: a matrix product may round differently from one processor to the next.
    """
    result = normals[:, 0, None] * points[:, 0]
    result += normals[:, 1, None] * points[:, 1]
    result += normals[:, 2, None] * points[:, 2]
    return result


def beyond(normals: Points, heights: npt.NDArray[np.float64], points: Points) -> npt.NDArray[np.float64]:
    """(n,): how far points (n, 3) are beyond that of the planes of which they are farthest: less than 0
    inside, and at most the distance [m] from the solid outside."""
    return np.asarray((along(normals, points) - heights[:, None]).max(axis=0))


def beyond_piece(piece: Piece) -> Distances:
    """A bound of how far [m] points are from a piece, negative inside: exact of a primitive, of others how
    far they are beyond its planes."""
    if isinstance(piece, Primitive):
        return partial(signed_distance, piece)
    normals, heights = half_spaces(piece)
    step = max(1, _MOST // 4 // max(1, len(normals)))

    def distances(points: Points) -> npt.NDArray[np.float64]:
        parts = range(0, max(1, len(points)), step)
        return np.concatenate([beyond(normals, heights, points[at : at + step]) for at in parts])

    return distances


def signed_distance(primitive: Primitive, points: Points) -> npt.NDArray[np.float64]:
    """(n,): the distance [m] of points (n, 3) from the primitive's surface, negative inside; exact."""
    x, y, z = _local(primitive, points).T
    if primitive.kind == "sphere":
        return np.asarray(np.sqrt(x * x + y * y + z * z) - primitive.size[0], dtype=np.float64)
    if primitive.kind == "capsule":
        radius, length = primitive.size
        beyond = np.maximum(np.abs(z) - length / 2, 0.0)
        return np.asarray(np.sqrt(x * x + y * y + beyond * beyond) - radius, dtype=np.float64)
    if primitive.kind == "cylinder":
        radius, length = primitive.size
        return _outside([np.sqrt(x * x + y * y) - radius, np.abs(z) - length / 2])
    lengths = primitive.size
    return _outside([np.abs(axis) - length / 2 for axis, length in zip((x, y, z), lengths, strict=True)])


def surface_of(piece: Piece) -> Surface:
    """The closed surface of a piece, for booleans and sampling.

    A curved one becomes a polyhedron of 64 sides that has the primitive's exact volume; no point of it is
    further than 0.2 % of the radius from the primitive's surface.
    """
    if isinstance(piece, Surface):
        return piece
    if piece.kind == "box":
        local = _box(piece.size)
    else:
        local = _turned(_profile(piece))
        wanted = primitive_volume(piece.kind, piece.size)
        # The volume of what is turned grows with the square of its widths.
        wider = math.sqrt(wanted / local.volume())
        local = Surface(local.vertices * [wider, wider, 1.0], local.triangles)
    return moved(local, piece.link_from_shape)


def around(primitive: Primitive) -> Points:
    """(n, 3): points whose convex hull contains the shape and hardly more."""
    middle = primitive.link_from_shape[:3, 3]
    # A box has its corners; no point of another is further out of its polyhedron.
    wider = 1.0 if primitive.kind == "box" else 1.0025
    return np.asarray(middle + wider * (surface_of(primitive).vertices - middle), dtype=np.float64)


def _product(row: Array, column: Array) -> float:
    return float(sum(a * b for a, b in zip(row.tolist(), column.tolist(), strict=True)))


def _local(primitive: Primitive, points: Points) -> Points:
    """The points in the primitive's own frame, whose axes are the columns of its pose."""
    pose = primitive.link_from_shape
    return along(pose[:3, :3].T, points - pose[:3, 3]).T


def _outside(beyond: list[npt.NDArray[np.float64]]) -> npt.NDArray[np.float64]:
    """The signed distance from a product of intervals, by how far each coordinate is beyond its own."""
    far = np.sqrt(sum(np.maximum(one, 0.0) ** 2 for one in beyond))
    return np.asarray(far + np.minimum(np.maximum.reduce(beyond), 0.0), dtype=np.float64)


def _box(lengths: tuple[float, ...]) -> Surface:
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * lengths
    squares = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [half for a, b, c, d in squares for half in ((a, b, c), (a, c, d))]
    return Surface(corners, np.array(triangles, dtype=np.int64))


def _profile(primitive: Primitive) -> list[tuple[float, float]]:
    """Radius and height of each ring around the axis, from below."""
    radius = primitive.size[0]
    half = 0.0 if primitive.kind == "sphere" else primitive.size[1] / 2
    if primitive.kind == "cylinder":
        return [(radius, -half), (radius, half)]
    angles = [math.pi / _UPWARDS * k for k in range(1, _UPWARDS // 2 + 1)]
    lower = [(radius * math.sin(angle), -half - radius * math.cos(angle)) for angle in angles]
    upper = [(r, -z) for r, z in reversed(lower)]
    return lower + (upper if half else upper[1:])


def _turned(profile: list[tuple[float, float]]) -> Surface:
    """The closed surface of rings around z; their discs close it where it is no pole."""
    bottom, top = profile[0][1], profile[-1][1]
    if len(profile) > 2:
        radius = profile[0][0] / math.sin(math.pi / _UPWARDS)
        cap = radius * (1 - math.cos(math.pi / _UPWARDS))
        bottom, top = bottom - cap, top + cap
    turns = [2 * math.pi / _AROUND * k for k in range(_AROUND)]
    rings = [(r * math.cos(turn), r * math.sin(turn), z) for r, z in profile for turn in turns]
    points = np.array([(0.0, 0.0, bottom), *rings, (0.0, 0.0, top)])
    here = np.arange(_AROUND)
    there = (here + 1) % _AROUND
    last = 1 + (len(profile) - 1) * _AROUND
    faces = [np.stack([np.zeros_like(here), there + 1, here + 1], axis=1)]
    for start in range(1, last, _AROUND):
        a, b, c, d = start + here, start + there, start + there + _AROUND, start + here + _AROUND
        faces += [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
    faces.append(np.stack([last + here, last + there, np.full_like(here, len(points) - 1)], axis=1))
    return Surface(points, np.concatenate(faces).astype(np.int64))
