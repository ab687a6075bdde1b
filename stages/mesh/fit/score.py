"""Computes the error of a primitive as a collider: the smallest tolerance that it meets."""

from collections.abc import Iterator

import numpy as np

from linkwright.stages.formats.meshes.surface import Points
from linkwright.stages.mesh.fit.outline import Floats, Outline
from linkwright.stages.robot.dynamics.inertia import primitive_area, primitive_volume
from linkwright.stages.robot.model.poses import from_parts
from linkwright.stages.robot.model.robot import Array, Primitive

MAX_PROTRUSION_TOLERANCES = 3.0
"""Largest allowed protrusion of a collider, in tolerances; 95 % of its surface must be within one
tolerance."""

_FINE_GRID = (7, 23)
_COARSE_GRID = (3, 7)
"""Numbers of points along a side or a generating line, and around an axis. Few gears have that many teeth, so
the points do not all fall on the teeth, or all between them."""


def primitive_error(primitive: Primitive, outline: Outline, fine: bool = True) -> float:
    """Returns the smallest tolerance [m] that a primitive meets. It is the largest of three values: how far
    the part stands out of the primitive at most, the 95 % quantile of how far the primitive stands out of the
    part, and a third of the latter's maximum. Without `fine`, few points are sampled."""
    local, weights = _points(primitive, *(_FINE_GRID if fine else _COARSE_GRID))
    pose = _sample_pose(primitive, outline)
    protrusion = outline.protrusion(local @ pose[:3, :3].T + pose[:3, 3])
    order = np.argsort(protrusion, kind="stable")
    # Each point represents the surface around it, half of which counts as standing out less than the point.
    covered = np.cumsum(weights[order]) - weights[order] / 2
    p95 = np.interp(0.95 * weights.sum(), covered, protrusion[order])
    return max(outline.bareness(primitive), float(p95), float(protrusion.max()) / MAX_PROTRUSION_TOLERANCES)


def error_lower_bound(primitive: Primitive, outline: Outline) -> float:
    """Returns a lower bound of the error [m], from the volume by which a primitive exceeds the part's hull.
    It lies between the hull and the primitive's surface: 95 % of this surface stand out by at most the error,
    and the rest by at most three times as much."""
    extra_volume = primitive_volume(primitive.kind, primitive.size) - outline.volume
    mean_protrusion = 0.95 + 0.05 * MAX_PROTRUSION_TOLERANCES
    return extra_volume / (mean_protrusion * primitive_area(primitive.kind, primitive.size))


def _sample_pose(primitive: Primitive, outline: Outline) -> Array:
    """Returns the pose of the sample points. The pose of a round primitive is arbitrary around its axis, so
    its points are turned towards the farthest vertex of the part; the axis of a sphere's points goes through
    the vertex that is farthest from its centre."""
    pose = primitive.link_from_shape
    if primitive.kind == "box":
        return pose
    from_centre = outline.hull_vertices - pose[:3, 3]
    axis = pose[:3, 2]
    if primitive.kind == "sphere":
        axis = from_centre[_farthest(from_centre, outline)]
        axis = axis / np.linalg.norm(axis)
    sideways = from_centre - np.outer(from_centre @ axis, axis)
    first = sideways[_farthest(sideways, outline)]
    first = first / np.linalg.norm(first)
    return from_parts(np.stack([first, np.cross(axis, first), axis], axis=1), pose[:3, 3])


def _farthest(vectors: Points, outline: Outline) -> int:
    """Returns the index of the longest of the vectors, one for each vertex of the hull. If several are
    equally long, as in a symmetric hull, the vertex farthest from the centroid of the surface is chosen."""
    squares = (vectors**2).sum(axis=1)
    longest = squares >= squares.max() * (1 - 1e-6)
    middle = np.average(outline.centroids, axis=0, weights=outline.areas)
    return int(np.where(longest, ((outline.hull_vertices - middle) ** 2).sum(axis=1), -1.0).argmax())


def _points(primitive: Primitive, along: int, around: int) -> tuple[Points, Floats]:
    """Returns points (n, 3) all over a primitive's surface in its own frame, edges and corners included, and
    the weight of each point: its share of the surface."""
    if primitive.kind == "box":
        return _box_points(primitive.size, along)
    rings = np.array(list(_rings(primitive, along)))
    angles = np.arange(around) * (2 * np.pi / around)
    radii, heights, areas = (np.repeat(column, around) for column in rings.T)
    cosines, sines = np.tile(np.cos(angles), len(rings)), np.tile(np.sin(angles), len(rings))
    return np.stack([radii * cosines, radii * sines, heights], axis=1), areas


def _rings(primitive: Primitive, along: int) -> Iterator[tuple[float, float, float]]:
    """Yields the radius and height of each ring of points, and its area divided by 2 π."""
    radius = primitive.size[0]
    half_length = 0.0 if primitive.kind == "sphere" else primitive.size[1] / 2
    if half_length:
        yield from _barrel_rings(radius, half_length, along)
    if primitive.kind == "cylinder":
        yield from _disc_rings(radius, half_length, along)
    else:
        yield from _half_sphere_rings(radius, half_length, along)


def _barrel_rings(radius: float, half_length: float, along: int) -> Iterator[tuple[float, float, float]]:
    """Yields the rings of the barrel of a cylinder or capsule (see `_rings`)."""
    for k in range(along):
        # The rings at both ends have half a step of the barrel.
        is_end = k in (0, along - 1)
        area = 2 * half_length * radius / (along - 1) / (1 + is_end)
        yield radius, half_length * (2 * k / (along - 1) - 1), area


def _disc_rings(radius: float, half_length: float, along: int) -> Iterator[tuple[float, float, float]]:
    """Yields the rings of both discs of a cylinder (see `_rings`)."""
    step = radius / (along - 1)
    for k in range(along):
        # The centre is a disc of half a step; the rim is half a step wide.
        area = step * max(step * k, step / 8) / (1 + (k == along - 1))
        for sign in (-1, 1):
            yield step * k, sign * half_length, area


def _half_sphere_rings(radius: float, half_length: float, along: int) -> Iterator[tuple[float, float, float]]:
    """Yields the rings of both halves of a sphere, which the barrel of a capsule separates (see `_rings`)."""
    angle_step = np.pi / 2 / (along - 1)
    for k in range(along):
        angle = np.pi / 2 * k / (along - 1)
        # Both halves, or a half and the barrel, share the equator; the pole is a cap of half a step.
        width = max(np.cos(angle), angle_step / 8) / (1 + (k == 0))
        for sign in (-1, 1):
            height = sign * (half_length + radius * np.sin(angle))
            yield radius * np.cos(angle), height, radius**2 * angle_step * width


def _box_points(size: tuple[float, ...], along: int) -> tuple[Points, Floats]:
    """Returns the centres (n, 3) of cells on a box of the lengths `size`, and their weights. Its corners,
    which stand out most, are among the points, with weight 0."""
    steps = (np.arange(along) + 0.5) / along - 0.5
    ends = np.array([-0.5, 0.5])
    points = [np.stack(np.meshgrid(ends, ends, ends), axis=-1).reshape(-1, 3) * size]
    weights = [np.zeros(len(points[0]))]
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in ends:
            face = np.empty((along, along, 3))
            face[:, :, axis] = side
            face[:, :, u], face[:, :, v] = np.meshgrid(steps, steps)
            points.append(face.reshape(-1, 3) * size)
            weights.append(np.full(along * along, size[u] * size[v]))
    return np.concatenate(points), np.concatenate(weights)
