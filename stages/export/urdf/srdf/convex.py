"""How far apart convex bodies are at least, at many poses at once.

Gilbert's algorithm on the difference of two bodies ("An iterative procedure for computing the minimum of a
quadratic form on a convex set", SIAM J. Control 4, 1966): every step knows a plane between the bodies, and
the distance along its normal is one that they have at least, whether the algorithm has converged or not.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.points import mesh_points
from linkwright.stages.robot.model.geometry import Geometry, Role, Shape
from linkwright.stages.robot.model.robot import Array, Primitive

_STEPS = (1, 1, 2, 4, 8)
"""Steps of the algorithm, after which bodies are left out that cannot be the nearest ones."""

_GUESSED = 4
"""Steps by which a pose's likely nearest bodies are looked at before all others."""

_SIDES = 16
"""Sides of the prism around a cylinder."""

_MOST = 512
"""A mesh with more points counts as the box around it."""


@dataclass(frozen=True, slots=True, eq=False)
class ConvexBodies:
    """The colliders of a link, each the convex hull of balls.

    `points` (b, v, 3) and `radii` (b, v) [m], in the frame of the link, the first ball repeated where a body
    has fewer; `middles` (b, 3): a point within each; `reaches` (b,): how far it goes from there. `middle`
    (3,), `reach`: of the ball around all; `box`: the box around all, as a body of its own.
    """

    points: Array
    radii: Array
    middles: Array
    reaches: Array
    middle: Array
    reach: float
    box: "ConvexBodies | None" = None

    def of(self, rows: npt.NDArray[np.intp]) -> "Part":
        """Some of the bodies."""
        return self.points[rows], self.radii[rows]


def bodies_of(
    geometry: Geometry, groups: Mapping[str, Sequence[tuple[str, Array]]]
) -> dict[str, ConvexBodies]:
    """By link the colliders of all links that are part of it, each with holder_from_link (4, 4). Links
    without any are left out."""
    shapes = geometry.by_link()
    made = {link: _of_link(geometry, shapes, held) for link, held in groups.items()}
    return {link: one for link, one in made.items() if one is not None}


def _of_link(
    geometry: Geometry,
    shapes: Mapping[tuple[str, Role], Sequence[Shape]],
    held: Sequence[tuple[str, Array]],
) -> ConvexBodies | None:
    found = [
        (points @ pose[:3, :3].T + pose[:3, 3], radii)
        for link, pose in held
        for points, radii in (_balls(shape, geometry) for shape in shapes[link, "collision"])
    ]
    if not found:
        return None
    low = np.min([(points - radii[:, None]).min(axis=0) for points, radii in found], axis=0)
    high = np.max([(points + radii[:, None]).max(axis=0) for points, radii in found], axis=0)
    corners = _corners(low, high)
    return _bodies(found, _bodies([(corners, np.zeros(8))]))


def at_least(first: ConvexBodies, second: ConvexBodies, first_from_second: Array, close: float) -> Array:
    """(n,) [m]: the distance that two links have at least where the second is at these poses (n, 4, 4) in the
    frame of the first; nothing is known of them where it is not positive. The work ends, with less known of
    the rest, at the first pose that has them no further apart than `close` [m]."""
    count = len(first_from_second)
    turns, shifts = first_from_second[:, :3, :3], first_from_second[:, :3, 3]
    # (n, a, b): of each pair of bodies, how far their middles, and the balls around them, are apart.
    middles = np.einsum("nij,bj->nbi", turns, second.middles) + shifts[:, None]
    between = np.linalg.norm(first.middles[None, :, None] - middles[:, None], axis=3)
    gaps = between - first.reaches[None, :, None] - second.reaches
    most = between.reshape(count, -1).min(axis=1)
    found = np.full(count, np.inf)
    if most.min() <= close:
        blind: Array = gaps.reshape(count, -1).min(axis=1)
        return blind
    if gaps[0].size > 1:
        most = np.minimum(most, _first_guess(first, second, turns, shifts, middles, gaps))
    near = gaps < most[:, None, None]
    np.minimum(found, np.where(near, np.inf, gaps).reshape(count, -1).min(axis=1), out=found)
    rows, ones, others = np.nonzero(near)
    best = gaps[near]
    point = first.middles[ones] - middles[rows, others]
    for steps in _STEPS:
        pair = first.of(ones), second.of(others)
        best, point = _narrowed(*pair, turns[rows], shifts[rows], best, point, steps)
        np.minimum.at(most, rows, np.linalg.norm(point, axis=1))
        # Of one pose only the bodies matter that may be the nearest ones.
        open_ = best < most[rows]
        np.minimum.at(found, rows[~open_], best[~open_])
        rows, ones, others, best, point = (each[open_] for each in (rows, ones, others, best, point))
        if most.min() <= close or not len(rows):
            break
    np.minimum.at(found, rows, best)
    return found


def _first_guess(
    first: ConvexBodies, second: ConvexBodies, turns: Array, shifts: Array, middles: Array, gaps: Array
) -> Array:
    """(n,) [m]: how far apart two links are at most, by the two bodies whose balls are the nearest."""
    poses: npt.NDArray[np.intp] = np.arange(len(gaps))
    ones, others = np.divmod(gaps.reshape(len(gaps), -1).argmin(axis=1), gaps.shape[2])
    point = first.middles[ones] - middles[poses, others]
    best = gaps[poses, ones, others]
    point = _narrowed(first.of(ones), second.of(others), turns, shifts, best, point, _GUESSED)[1]
    found: Array = np.linalg.norm(point, axis=1)
    return found


Part = tuple[Array, Array]
"""Points (m, v, 3) and radii (m, v) of bodies."""


def _narrowed(
    first: Part, second: Part, turns: Array, shifts: Array, best: Array, point: Array, steps: int
) -> tuple[Array, Array]:
    """After so many more steps: (m,) [m] the largest distance of two parallel planes between each two
    bodies, as far as it is found, and the shortest way (m, 3) from the second to the first."""
    for _ in range(steps):
        size = np.linalg.norm(point, axis=1)
        towards = -point / np.maximum(size, 1e-12)[:, None]
        far = _support(first, towards)
        near = _support(second, -np.einsum("mji,mj->mi", turns, towards))
        corner = far - np.einsum("mij,mj->mi", turns, near) - shifts
        best = np.maximum(best, -np.einsum("mi,mi->m", corner, towards))
        way = corner - point
        length = np.einsum("mi,mi->m", way, way)
        share = np.einsum("mi,mi->m", -point, way) / np.maximum(length, 1e-24)
        point = point + np.clip(share, 0.0, 1.0)[:, None] * way
    return best, point


def _support(part: Part, towards: Array) -> Array:
    """The point (m, 3) of each body that is furthest in a direction (m, 3)."""
    points, radii = part
    along = np.matmul(points, towards[:, :, None])[:, :, 0] + radii
    best = along.argmax(axis=1)
    rows: npt.NDArray[np.intp] = np.arange(len(best))
    found: Array = points[rows, best] + radii[rows, best][:, None] * towards
    return found


def _bodies(balls: Sequence[tuple[Array, Array]], box: ConvexBodies | None = None) -> ConvexBodies:
    most = max(len(radii) for _, radii in balls)
    points = np.stack([np.concatenate([p, np.repeat(p[:1], most - len(p), axis=0)]) for p, _ in balls])
    radii = np.stack([np.concatenate([r, np.repeat(r[:1], most - len(r))]) for _, r in balls])
    middles = points.mean(axis=1)
    reaches = (np.linalg.norm(points - middles[:, None], axis=2) + radii).max(axis=1)
    low, high = points.min(axis=(0, 1)), points.max(axis=(0, 1))
    middle = (low + high) / 2
    reach = float((np.linalg.norm(points - middle, axis=2) + radii).max())
    return ConvexBodies(points, radii, middles, reaches, middle, reach, box)


def _balls(shape: Shape, geometry: Geometry) -> tuple[Array, Array]:
    """Points (v, 3) and radii (v,) of balls whose convex hull has the whole shape in it."""
    if shape.primitive is not None:
        return _of_primitive(shape.primitive)
    assert shape.file is not None
    points = np.unique(mesh_points(shape.file, geometry.files[shape.file]), axis=0)
    if len(points) > _MOST:
        points = _corners(points.min(axis=0), points.max(axis=0))
    return points, np.zeros(len(points))


def _of_primitive(primitive: Primitive) -> tuple[Array, Array]:
    size, pose = primitive.size, primitive.link_from_shape
    radius = 0.0
    if primitive.kind == "box":
        half = np.array(size) / 2
        points = _corners(-half, half)
    elif primitive.kind == "sphere":
        radius, points = size[0], np.zeros((1, 3))
    elif primitive.kind == "capsule":
        radius, points = size[0], np.array([[0, 0, -size[1] / 2], [0, 0, size[1] / 2]])
    else:
        angles = 2 * np.pi * np.arange(_SIDES) / _SIDES
        ring = size[0] / np.cos(np.pi / _SIDES) * np.column_stack([np.cos(angles), np.sin(angles)])
        ends = (-size[1] / 2, size[1] / 2)
        points = np.concatenate([np.column_stack([ring, np.full(_SIDES, end)]) for end in ends])
    return points @ pose[:3, :3].T + pose[:3, 3], np.full(len(points), radius)


def _corners(low: Array, high: Array) -> Array:
    """(8, 3) of a box."""
    ends = np.stack([low, high])
    return np.array([[ends[one, axis] for axis, one in enumerate(pick)] for pick in np.ndindex(2, 2, 2)])
