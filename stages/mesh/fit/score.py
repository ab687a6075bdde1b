"""The error of a primitive, as the tolerance of colliders sees it."""

from collections.abc import Iterator

import numpy as np

from linkwright.stages.formats.meshes.surface import Points
from linkwright.stages.mesh.fit.outline import Floats, Outline
from linkwright.stages.robot.dynamics.inertia import primitive_area, primitive_volume
from linkwright.stages.robot.model.poses import from_parts
from linkwright.stages.robot.model.robot import Array, Primitive

MOST_OF_TOLERANCE = 3.0
"""How many times the tolerance a collider may stand out at most, where 95 % of it stay within."""

_FINE = (7, 23)
_COARSE = (3, 7)
"""Points along a side, or a generating line, and around an axis: as many as gears seldom have teeth."""


def error(primitive: Primitive, outline: Outline, fine: bool = True) -> float:
    """The least tolerance [m] that a primitive meets: the largest of its greatest bareness, the protrusion
    of 95 % of its surface, and a third of its greatest protrusion; by few points unless it is `fine`."""
    local, weights = _points(primitive, *(_FINE if fine else _COARSE))
    pose = _sampled(primitive, outline)
    protrusion = outline.protrusion(local @ pose[:3, :3].T + pose[:3, 3])
    order = np.argsort(protrusion, kind="stable")
    # Each point stands for a share of the surface around it, half of which is below it.
    covered = np.cumsum(weights[order]) - weights[order] / 2
    most = np.interp(0.95 * weights.sum(), covered, protrusion[order])
    return max(outline.bareness(primitive), float(most), float(protrusion.max()) / MOST_OF_TOLERANCE)


def least_error(primitive: Primitive, outline: Outline) -> float:
    """A bound from below of the error [m]: what a primitive has more volume than the part's hull lies between
    the hull and its own surface, of which 5 % may stand out by more than the error."""
    more = primitive_volume(primitive.kind, primitive.size) - outline.volume
    mean = 0.95 + 0.05 * MOST_OF_TOLERANCE
    return more / (mean * primitive_area(primitive.kind, primitive.size))


def _sampled(primitive: Primitive, outline: Outline) -> Array:
    """The pose of the points: around its axis a primitive has no place of its own, so it is turned to the
    farthest vertex of the part, and a sphere's axis to the farthest from its centre."""
    pose = primitive.link_from_shape
    if primitive.kind == "box":
        return pose
    apart = outline.corners - pose[:3, 3]
    axis = pose[:3, 2]
    if primitive.kind == "sphere":
        axis = apart[_farthest(apart, outline)]
        axis = axis / np.linalg.norm(axis)
    sideways = apart - np.outer(apart @ axis, axis)
    first = sideways[_farthest(sideways, outline)]
    first = first / np.linalg.norm(first)
    return from_parts(np.stack([first, np.cross(axis, first), axis], axis=1), pose[:3, 3])


def _farthest(vectors: Points, outline: Outline) -> int:
    """Index of the longest of the vectors that belong to the hull's vertices; of several, as a symmetric hull
    has them, that of the vertex that is farthest from the middle of the surface itself."""
    squares = (vectors**2).sum(axis=1)
    longest = squares >= squares.max() * (1 - 1e-6)
    middle = np.average(outline.centroids, axis=0, weights=outline.areas)
    return int(np.where(longest, ((outline.corners - middle) ** 2).sum(axis=1), -1.0).argmax())


def _points(primitive: Primitive, along: int, around: int) -> tuple[Points, Floats]:
    """Points (n, 3) all over a primitive's surface in its own frame, its edges and corners among them, and
    the share of the surface that each stands for."""
    if primitive.kind == "box":
        return _box(primitive.size, along)
    rings = np.array(list(_rings(primitive, along)))
    turns = np.arange(around) * (2 * np.pi / around)
    radii, heights, areas = (np.repeat(column, around) for column in rings.T)
    cosines, sines = np.tile(np.cos(turns), len(rings)), np.tile(np.sin(turns), len(rings))
    return np.stack([radii * cosines, radii * sines, heights], axis=1), areas


def _rings(primitive: Primitive, along: int) -> Iterator[tuple[float, float, float]]:
    """Radius and height of each ring of points, and its area but for a common factor."""
    radius = primitive.size[0]
    half = 0.0 if primitive.kind == "sphere" else primitive.size[1] / 2
    if half:
        for k in range(along):
            end = k in (0, along - 1)
            yield radius, half * (2 * k / (along - 1) - 1), 2 * half * radius / (along - 1) / (1 + end)
    for k in range(along):
        for sign in (-1, 1):
            if primitive.kind == "cylinder":
                step = radius / (along - 1)
                yield step * k, sign * half, step * max(step * k, step / 4) / (1 + (k == along - 1))
            else:
                angle = np.pi / 2 * k / (along - 1)
                step = np.pi / 2 / (along - 1)
                width = max(np.cos(angle), step / 8) / (1 + (k == 0))
                height = sign * (half + radius * np.sin(angle))
                yield radius * np.cos(angle), height, radius**2 * step * width


def _box(lengths: tuple[float, ...], along: int) -> tuple[Points, Floats]:
    """The middles of cells, and the corners, which stand out most but have no area."""
    steps = (np.arange(along) + 0.5) / along - 0.5
    ends = np.array([-0.5, 0.5])
    points = [np.stack(np.meshgrid(ends, ends, ends), axis=-1).reshape(-1, 3) * lengths]
    weights = [np.zeros(len(points[0]))]
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in ends:
            face = np.empty((along, along, 3))
            face[:, :, axis] = side
            face[:, :, u], face[:, :, v] = np.meshgrid(steps, steps)
            points.append(face.reshape(-1, 3) * lengths)
            weights.append(np.full(along * along, lengths[u] * lengths[v]))
    return np.concatenate(points), np.concatenate(weights)
