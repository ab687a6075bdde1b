"""Computes lower bounds of the distance of convex bodies, at many poses at once.

Gilbert's algorithm is applied to the difference of two bodies ("An iterative procedure for computing the
minimum of a quadratic form on a convex set", SIAM J. Control 4, 1966). Every step knows a plane between the
bodies, and the distance along its normal is a lower bound, whether the algorithm has converged or not.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.points import mesh_points
from linkwright.stages.robot.model.geometry import Geometry, Role, Shape
from linkwright.stages.robot.model.robot import Array, Primitive

_STEPS = (1, 1, 2, 4, 8)
"""Numbers of steps of the algorithm. After each of them the pairs of bodies that cannot be the nearest are
dropped."""

_GUESS_STEPS = 4
"""Number of steps for the two bodies whose balls are nearest in a pose, which are examined before all
others."""

_PRISM_SIDES = 16
"""Number of sides of the prism around a cylinder."""

_MAX_POINTS = 512
"""Largest number of points of a mesh: a larger mesh counts as the box around it."""


@dataclass(frozen=True, slots=True, eq=False)
class ConvexBodies:
    """The colliders of a link, each the convex hull of balls. Lengths are in metres, in the link's frame."""

    points: Array
    """Centres (b, v, 3) of the balls of each body. A body with fewer balls repeats its first."""

    radii: Array
    """Radii (b, v) of the balls."""

    middles: Array
    """A point (b, 3) within each body."""

    reaches: Array
    """Radii (b,) of the balls around `middles` that contain each body."""

    middle: Array
    """Centre (3,) of the ball around all bodies."""

    reach: float
    """Radius of the ball around all bodies."""

    box: "ConvexBodies | None" = None
    """The box around all bodies, as a body of its own."""

    def rows(self, indices: npt.NDArray[np.intp]) -> "Part":
        """Returns the points and radii of the bodies with these indices."""
        return self.points[indices], self.radii[indices]


def bodies_of(
    geometry: Geometry, groups: Mapping[str, Sequence[tuple[str, Array]]]
) -> dict[str, ConvexBodies]:
    """Returns link → its colliders, without links that have none. `groups`: link → all links that are part of
    it, each with holder_from_link (4, 4)."""
    shapes = geometry.by_link()
    bodies = {link: _bodies_of_link(geometry, shapes, links) for link, links in groups.items()}
    return {link: body for link, body in bodies.items() if body is not None}


def _bodies_of_link(
    geometry: Geometry,
    shapes: Mapping[tuple[str, Role], Sequence[Shape]],
    links: Sequence[tuple[str, Array]],
) -> ConvexBodies | None:
    """Returns the colliders of `links`, each link at its pose (4, 4); None without colliders."""
    clouds = [
        (points @ pose[:3, :3].T + pose[:3, 3], radii)
        for link, pose in links
        for points, radii in (_balls(shape, geometry) for shape in shapes[link, "collision"])
    ]
    if not clouds:
        return None
    low = np.min([(points - radii[:, None]).min(axis=0) for points, radii in clouds], axis=0)
    high = np.max([(points + radii[:, None]).max(axis=0) for points, radii in clouds], axis=0)
    corners = _corners(low, high)
    return _bodies(clouds, _bodies([(corners, np.zeros(8))]))


def distance_bounds(
    first: ConvexBodies, second: ConvexBodies, first_from_second: Array, min_distance: float
) -> Array:
    """Returns lower bounds (n,) [m] of the distance of two links. `first_from_second` (n, 4, 4): the poses of
    the second link in the frame of the first.

    Links with a bound that is not positive may touch. As soon as the links are known to be no further apart
    than `min_distance` [m] in one pose, the other poses keep the weaker bounds that they have.
    """
    count = len(first_from_second)
    turns, shifts = first_from_second[:, :3, :3], first_from_second[:, :3, 3]
    # (n, a, b): the distances of the middles, and of the balls around the bodies, of each pair of bodies.
    middles = np.einsum("nij,bj->nbi", turns, second.middles) + shifts[:, None]
    distances = np.linalg.norm(first.middles[None, :, None] - middles[:, None], axis=3)
    gaps = distances - first.reaches[None, :, None] - second.reaches
    upper_bounds = distances.reshape(count, -1).min(axis=1)
    bounds = np.full(count, np.inf)
    if upper_bounds.min() <= min_distance:
        gap_bounds: Array = gaps.reshape(count, -1).min(axis=1)
        return gap_bounds
    if gaps[0].size > 1:
        upper_bounds = np.minimum(upper_bounds, _first_guess(first, second, turns, shifts, middles, gaps))
    may_be_nearest = gaps < upper_bounds[:, None, None]
    np.minimum(bounds, np.where(may_be_nearest, np.inf, gaps).reshape(count, -1).min(axis=1), out=bounds)
    poses, in_first, in_second = np.nonzero(may_be_nearest)
    best = gaps[may_be_nearest]
    point = first.middles[in_first] - middles[poses, in_second]
    for steps in _STEPS:
        pair = first.rows(in_first), second.rows(in_second)
        best, point = _narrowed(*pair, turns[poses], shifts[poses], best, point, steps)
        np.minimum.at(upper_bounds, poses, np.linalg.norm(point, axis=1))
        # In each pose only the pairs of bodies matter that may be the nearest.
        is_open = best < upper_bounds[poses]
        np.minimum.at(bounds, poses[~is_open], best[~is_open])
        poses, in_first, in_second, best, point = (
            array[is_open] for array in (poses, in_first, in_second, best, point)
        )
        if upper_bounds.min() <= min_distance or not len(poses):
            break
    np.minimum.at(bounds, poses, best)
    return bounds


def _first_guess(
    first: ConvexBodies, second: ConvexBodies, turns: Array, shifts: Array, middles: Array, gaps: Array
) -> Array:
    """Returns upper bounds (n,) [m] of the distance of two links, from the two bodies whose balls are
    nearest."""
    poses: npt.NDArray[np.intp] = np.arange(len(gaps))
    in_first, in_second = np.divmod(gaps.reshape(len(gaps), -1).argmin(axis=1), gaps.shape[2])
    point = first.middles[in_first] - middles[poses, in_second]
    best = gaps[poses, in_first, in_second]
    pair = first.rows(in_first), second.rows(in_second)
    _, point = _narrowed(*pair, turns, shifts, best, point, _GUESS_STEPS)
    distances: Array = np.linalg.norm(point, axis=1)
    return distances


Part = tuple[Array, Array]
"""Points (m, v, 3) and radii (m, v) of bodies."""


def _narrowed(
    first: Part, second: Part, turns: Array, shifts: Array, best: Array, point: Array, steps: int
) -> tuple[Array, Array]:
    """Returns the state of m pairs of bodies after `steps` more steps: the largest distance (m,) [m] of
    parallel planes between the bodies so far, and the shortest vector (m, 3) from the second to the first.
    `turns` (m, 3, 3), `shifts` (m, 3): the pose of the second in the frame of the first; `best`, `point`: the
    state before."""
    for _ in range(steps):
        # The smallest divisors only prevent divisions by zero.
        size = np.linalg.norm(point, axis=1)
        direction = -point / np.maximum(size, 1e-12)[:, None]
        first_point = _support(first, direction)
        second_point = _support(second, -np.einsum("mji,mj->mi", turns, direction))
        corner = first_point - np.einsum("mij,mj->mi", turns, second_point) - shifts
        best = np.maximum(best, -np.einsum("mi,mi->m", corner, direction))
        step_vector = corner - point
        length = np.einsum("mi,mi->m", step_vector, step_vector)
        share = np.einsum("mi,mi->m", -point, step_vector) / np.maximum(length, 1e-24)
        point = point + np.clip(share, 0.0, 1.0)[:, None] * step_vector
    return best, point


def _support(part: Part, direction: Array) -> Array:
    """Returns the point (m, 3) of each body that is furthest in a direction (m, 3)."""
    points, radii = part
    along = np.matmul(points, direction[:, :, None])[:, :, 0] + radii
    best = along.argmax(axis=1)
    rows: npt.NDArray[np.intp] = np.arange(len(best))
    points_of_support: Array = points[rows, best] + radii[rows, best][:, None] * direction
    return points_of_support


def _bodies(balls: Sequence[tuple[Array, Array]], box: ConvexBodies | None = None) -> ConvexBodies:
    """Returns bodies from the centres (v, 3) and radii (v,) of the balls of each; v may differ."""
    ball_count = max(len(radii) for _, radii in balls)
    points = np.stack([np.concatenate([p, np.repeat(p[:1], ball_count - len(p), axis=0)]) for p, _ in balls])
    radii = np.stack([np.concatenate([r, np.repeat(r[:1], ball_count - len(r))]) for _, r in balls])
    middles = points.mean(axis=1)
    reaches = (np.linalg.norm(points - middles[:, None], axis=2) + radii).max(axis=1)
    low, high = points.min(axis=(0, 1)), points.max(axis=(0, 1))
    middle = (low + high) / 2
    reach = float((np.linalg.norm(points - middle, axis=2) + radii).max())
    return ConvexBodies(points, radii, middles, reaches, middle, reach, box)


def _balls(shape: Shape, geometry: Geometry) -> tuple[Array, Array]:
    """Returns points (v, 3) and radii (v,) of balls whose convex hull contains the whole shape."""
    if shape.primitive is not None:
        return _balls_of_primitive(shape.primitive)
    assert shape.file is not None
    points = np.unique(mesh_points(shape.file, geometry.files[shape.file]), axis=0)
    if len(points) > _MAX_POINTS:
        points = _corners(points.min(axis=0), points.max(axis=0))
    return points, np.zeros(len(points))


def _balls_of_primitive(primitive: Primitive) -> tuple[Array, Array]:
    """Returns points and radii of balls whose convex hull contains a primitive, in its link's frame."""
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
        angles = 2 * np.pi * np.arange(_PRISM_SIDES) / _PRISM_SIDES
        # The prism is circumscribed, so that it contains the cylinder.
        ring = size[0] / np.cos(np.pi / _PRISM_SIDES) * np.column_stack([np.cos(angles), np.sin(angles)])
        ends = (-size[1] / 2, size[1] / 2)
        points = np.concatenate([np.column_stack([ring, np.full(_PRISM_SIDES, end)]) for end in ends])
    return points @ pose[:3, :3].T + pose[:3, 3], np.full(len(points), radius)


def _corners(low: Array, high: Array) -> Array:
    """Returns the corners (8, 3) of a box."""
    ends = np.stack([low, high])
    return np.array([[ends[end, axis] for axis, end in enumerate(pick)] for pick in np.ndindex(2, 2, 2)])
