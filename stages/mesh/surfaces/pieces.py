"""Defines the pieces of a collider, closed convex surfaces and primitives, and their common functions."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, Surface, transform_surface
from linkwright.stages.robot.dynamics.inertia import primitive_volume
from linkwright.stages.robot.model.robot import Array, Primitive, frozen

Piece = Surface | Primitive
"""A piece of a collider. As a `Surface` it is closed, convex, and faces outwards."""

Distances = Callable[[Points], npt.NDArray[np.float64]]
"""Function that returns a distance [m] for each of the points (n, 3)."""

_SIDES_AROUND = 64
_SIDES_FROM_POLE_TO_POLE = 32
"""Numbers of sides of a curved primitive's polyhedron, around its axis and along a half circle."""

_MAX_ELEMENTS = 1 << 20  # of an intermediate array


def vertices(piece: Piece) -> int:
    """Returns the number of vertices that an engine has to process; 0 for a primitive."""
    return len(piece.vertices) if isinstance(piece, Surface) else 0


def volume(piece: Piece) -> float:
    """Returns the volume [m³]."""
    return piece.volume() if isinstance(piece, Surface) else primitive_volume(piece.kind, piece.size)


def placed(piece: Piece, transform: Array) -> Piece:
    """Returns the piece moved by `transform` (4, 4): a rotation or reflection, and a translation."""
    if isinstance(piece, Surface):
        return transform_surface(piece, transform)
    rows = [[_product(row, column) for column in piece.link_from_shape.T] for row in transform]
    pose = np.array(rows)
    if np.linalg.det(pose[:3, :3]) < 0:
        pose[:, 0] *= -1  # each kind is its own mirror image
    return replace(piece, link_from_shape=frozen(pose))


def half_spaces(surface: Surface) -> tuple[Points, npt.NDArray[np.float64]]:
    """Returns a convex surface as planes: unit normals (k, 3) and heights (k,) [m], with n·x ≤ height inside.

    Each plane touches a vertex and has all others behind it, even if the normal of a sliver is inaccurate.
    Planes whose normals are equal to nine digits are merged.
    """
    normals = surface.normals()
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals[lengths > 0] / lengths[lengths > 0, None]
    _, first = np.unique(normals.round(9) + 0.0, axis=0, return_index=True)
    normals = normals[first]
    step = max(1, _MAX_ELEMENTS // max(1, len(surface.vertices)))
    heights = [
        along(normals[begin : begin + step], surface.vertices).max(axis=1)
        for begin in range(0, len(normals), step)
    ]
    return normals, np.concatenate(heights) if heights else np.zeros(0)


def along(normals: Points, points: Points) -> npt.NDArray[np.float64]:
    """Returns the dot products (k, n) of normals (k, 3) and points (n, 3).

    They are written out by element, since a matrix product may round differently on another processor.
    """
    result = normals[:, 0, None] * points[:, 0]
    result += normals[:, 1, None] * points[:, 1]
    result += normals[:, 2, None] * points[:, 2]
    return result


def beyond(normals: Points, heights: npt.NDArray[np.float64], points: Points) -> npt.NDArray[np.float64]:
    """Returns how far [m] (n,) each of the points (n, 3) is beyond the plane that it is farthest beyond:
    negative inside; outside, at most the distance from the solid."""
    return np.asarray((along(normals, points) - heights[:, None]).max(axis=0))


def beyond_piece(piece: Piece) -> Distances:
    """Returns a function that gives a lower bound of the distance [m] of points from a piece, negative
    inside. It is exact for a primitive; for a surface it is how far the points are beyond its planes."""
    if isinstance(piece, Primitive):
        return partial(signed_distance, piece)
    normals, heights = half_spaces(piece)
    step = max(1, _MAX_ELEMENTS // 4 // max(1, len(normals)))

    def distances(points: Points) -> npt.NDArray[np.float64]:
        parts = range(0, max(1, len(points)), step)
        return np.concatenate([beyond(normals, heights, points[begin : begin + step]) for begin in parts])

    return distances


def signed_distance(primitive: Primitive, points: Points) -> npt.NDArray[np.float64]:
    """Returns the exact distance [m] (n,) of points (n, 3) from a primitive's surface, negative inside."""
    x, y, z = _local(primitive, points).T
    if primitive.kind == "sphere":
        return np.asarray(np.sqrt(x * x + y * y + z * z) - primitive.size[0], dtype=np.float64)
    if primitive.kind == "capsule":
        radius, length = primitive.size
        beyond_cap = np.maximum(np.abs(z) - length / 2, 0.0)
        return np.asarray(np.sqrt(x * x + y * y + beyond_cap * beyond_cap) - radius, dtype=np.float64)
    if primitive.kind == "cylinder":
        radius, length = primitive.size
        return _distance_from_product([np.sqrt(x * x + y * y) - radius, np.abs(z) - length / 2])
    lengths = primitive.size
    return _distance_from_product(
        [np.abs(axis) - length / 2 for axis, length in zip((x, y, z), lengths, strict=True)]
    )


def surface_of(piece: Piece) -> Surface:
    """Returns the closed surface of a piece, for booleans and sampling.

    A curved primitive becomes a polyhedron with 64 sides around its axis and the primitive's exact volume; no
    point of it is further than 0.2 % of the radius from the primitive's surface.
    """
    if isinstance(piece, Surface):
        return piece
    if piece.kind == "box":
        local = _box(piece.size)
    else:
        local = _surface_of_revolution(_profile(piece))
        exact_volume = primitive_volume(piece.kind, piece.size)
        # The volume of a turned solid grows with the square of its width.
        growth = math.sqrt(exact_volume / local.volume())
        local = Surface(local.vertices * [growth, growth, 1.0], local.triangles)
    return transform_surface(local, piece.link_from_shape)


def enclosing_points(primitive: Primitive) -> Points:
    """Returns points (n, 3) whose convex hull contains the primitive, and hardly more."""
    centre = primitive.link_from_shape[:3, 3]
    # A box has its exact corners; a curved shape is inside its polyhedron enlarged by this factor.
    growth = 1.0 if primitive.kind == "box" else 1.0025
    return np.asarray(centre + growth * (surface_of(primitive).vertices - centre), dtype=np.float64)


def _product(row: Array, column: Array) -> float:
    return float(sum(a * b for a, b in zip(row.tolist(), column.tolist(), strict=True)))


def _local(primitive: Primitive, points: Points) -> Points:
    """Returns the points in the primitive's frame, whose axes are the columns of its pose."""
    pose = primitive.link_from_shape
    return along(pose[:3, :3].T, points - pose[:3, 3]).T


def _distance_from_product(excesses: list[npt.NDArray[np.float64]]) -> npt.NDArray[np.float64]:
    """Returns the signed distance [m] (n,) from a product of solids such as a disc and an interval.
    `excesses`: signed distance (n,) from each of them."""
    outside_distance = np.sqrt(sum(np.maximum(distance, 0.0) ** 2 for distance in excesses))
    return np.asarray(outside_distance + np.minimum(np.maximum.reduce(excesses), 0.0), dtype=np.float64)


def _box(lengths: tuple[float, ...]) -> Surface:
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * lengths
    squares = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [half for a, b, c, d in squares for half in ((a, b, c), (a, c, d))]
    return Surface(corners, np.array(triangles, dtype=np.int64))


def _profile(primitive: Primitive) -> list[tuple[float, float]]:
    """Returns the radius and height of each ring around the axis, from below."""
    radius = primitive.size[0]
    half = 0.0 if primitive.kind == "sphere" else primitive.size[1] / 2
    if primitive.kind == "cylinder":
        return [(radius, -half), (radius, half)]
    angles = [math.pi / _SIDES_FROM_POLE_TO_POLE * k for k in range(1, _SIDES_FROM_POLE_TO_POLE // 2 + 1)]
    lower = [(radius * math.sin(angle), -half - radius * math.cos(angle)) for angle in angles]
    upper = [(r, -z) for r, z in reversed(lower)]
    return lower + (upper if half else upper[1:])


def _surface_of_revolution(profile: list[tuple[float, float]]) -> Surface:
    """Returns the closed surface through rings around z, with a disc or a pole at either end."""
    bottom, top = profile[0][1], profile[-1][1]
    if len(profile) > 2:
        radius = profile[0][0] / math.sin(math.pi / _SIDES_FROM_POLE_TO_POLE)
        cap = radius * (1 - math.cos(math.pi / _SIDES_FROM_POLE_TO_POLE))
        bottom, top = bottom - cap, top + cap
    turns = [2 * math.pi / _SIDES_AROUND * k for k in range(_SIDES_AROUND)]
    rings = [(r * math.cos(turn), r * math.sin(turn), z) for r, z in profile for turn in turns]
    points = np.array([(0.0, 0.0, bottom), *rings, (0.0, 0.0, top)])
    columns = np.arange(_SIDES_AROUND)
    next_columns = (columns + 1) % _SIDES_AROUND
    last = 1 + (len(profile) - 1) * _SIDES_AROUND
    faces = [np.stack([np.zeros_like(columns), next_columns + 1, columns + 1], axis=1)]
    for start in range(1, last, _SIDES_AROUND):
        a, b, c, d = (
            start + columns,
            start + next_columns,
            start + next_columns + _SIDES_AROUND,
            start + columns + _SIDES_AROUND,
        )
        faces += [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
    faces.append(
        np.stack([last + columns, last + next_columns, np.full_like(columns, len(points) - 1)], axis=1)
    )
    return Surface(points, np.concatenate(faces).astype(np.int64))
