"""Finds planes by which a piece of a collider may be cut."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.robot.model.robot import Array

Score = TypeVar("Score", float, tuple[float, float])
Plane = tuple[Points, float]
"""A plane normal·x = height: unit normal (3,) and height [m]."""

_MAX_FACES = 10
"""Largest number of flat faces, the largest faces first."""

_OFFSET = 2e-4
"""Distance [m] of a plane from a flat face, on either side, so that the whole face is on one side of it."""

_QUANTILES = (0.2, 0.35, 0.5, 0.65, 0.8)
_MIN_SHARE_OF_EXTENT = 0.02
"""Smallest share of a piece's extent along a normal that must be on each side of a plane."""


def axes_of(surface: Surface) -> Points:
    """Returns axes (k, 3): x, y and z, and those principal axes of the surface's area that differ from
    them."""
    centres = surface.corners.mean(axis=1)
    weights = np.linalg.norm(surface.normals(), axis=1)
    total = weights.sum()
    if total <= 0:
        return np.eye(3)
    offsets = centres - (centres * weights[:, None]).sum(axis=0) / total
    _, axes = np.linalg.eigh((offsets * weights[:, None]).T @ offsets)
    axes = axes.T * np.where(axes.T[np.arange(3), np.abs(axes.T).argmax(axis=1)] < 0, -1, 1)[:, None]
    oblique_axes = axes[np.abs(axes).max(axis=1) < 0.9998]
    return np.concatenate([np.eye(3), oblique_axes])


def flat_faces(surface: Surface, offset: float = _OFFSET) -> list[Plane]:
    """Returns the planes at a distance of `offset` [m] on both sides of the largest flat faces of a
    surface."""
    normals = surface.normals()
    areas = np.linalg.norm(normals, axis=1)
    has_area = areas > 1e-12
    normals, areas = normals[has_area] / areas[has_area, None], areas[has_area]
    corners = surface.vertices[surface.triangles[has_area, 0]]
    if not len(areas):
        return []
    # Normals of either sense give the same plane.
    nonzero = np.abs(normals) > 1e-3
    sign = np.sign(normals[np.arange(len(normals)), nonzero.argmax(axis=1)])
    normals = normals * sign[:, None]
    heights = np.einsum("ij,ij->i", normals, corners)
    keys = np.column_stack([normals.round(2), (heights / (5 * offset)).round()]) + 0.0
    _, rows, group = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    sums = np.bincount(group.ravel(), areas)
    largest = np.lexsort((rows, -sums))[:_MAX_FACES]
    return [
        (normals[rows[k]], float(heights[rows[k]]) + shift) for k in largest for shift in (-offset, offset)
    ]


def through(axes: Points, points: Points) -> Iterator[Plane]:
    """Yields planes across each axis, at quantiles of the points (n, 3)."""
    for axis in axes:
        for height in np.quantile(points @ axis, _QUANTILES):
            yield axis, float(height)


def past_obstacles(axes: Points, obstacles: Array) -> Iterator[Plane]:
    """Yields planes across each axis that have an obstacle on one side: in all poses, and in the half of the
    poses in which it is farthest on that side. `obstacles`: points (poses, n, 3) of another link in some
    poses."""
    for axis in axes:
        obstacle_heights = obstacles @ axis
        for height in (obstacle_heights.min(axis=1).min(), np.median(obstacle_heights.min(axis=1))):
            yield axis, float(height)
        for height in (obstacle_heights.max(axis=1).max(), np.median(obstacle_heights.max(axis=1))):
            yield axis, float(height)


def crossing(planes: Iterable[Plane], points: Points) -> list[Plane]:
    """Returns the planes that have points on both sides, without duplicates."""
    distinct: dict[tuple[float, ...], Plane] = {}
    for normal, height in planes:
        heights = points @ normal
        low, high = float(heights.min()), float(heights.max())
        if low + _MIN_SHARE_OF_EXTENT * (high - low) < height < high - _MIN_SHARE_OF_EXTENT * (high - low):
            key = *normal.round(6).tolist(), round(height, 6)
            distinct.setdefault(key, (normal, height))
    return list(distinct.values())


def ranked(
    planes: Iterable[Plane], cloud: Points, score: Callable[[Points, Points], Score]
) -> list[tuple[Score, Plane]]:
    """Returns the planes with their scores, the least score first. `score`: function of the points of a cloud
    (n, 3) below and above a plane."""
    results = []
    for normal, height in planes:
        is_above = cloud @ normal > height
        results.append((score(cloud[~is_above], cloud[is_above]), (normal, height)))
    return sorted(results, key=lambda row: row[0])
