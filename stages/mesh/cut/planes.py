"""Planes by which a piece of a collider may be cut."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.robot.model.robot import Array

Score = TypeVar("Score", float, tuple[float, float])
Plane = tuple[Points, float]
"""A unit normal (3,) and a height [m]: normal·x = height."""

_FACES = 10
"""How many flat faces, the largest first."""

_ASIDE = 2e-4
"""A plane beside a flat face [m], on either side of it, so that the face is on one side as a whole."""

_QUANTILES = (0.2, 0.35, 0.5, 0.65, 0.8)
_EDGE = 0.02
"""The share of a piece's extent along a normal that must be on each side of a plane."""


def axes_of(surface: Surface) -> Points:
    """(k, 3): x, y and z, and the principal axes of a surface, by area."""
    centres = surface.corners.mean(axis=1)
    weights = np.linalg.norm(surface.normals(), axis=1)
    total = weights.sum()
    if total <= 0:
        return np.eye(3)
    apart = centres - (centres * weights[:, None]).sum(axis=0) / total
    _, axes = np.linalg.eigh((apart * weights[:, None]).T @ apart)
    axes = axes.T * np.where(axes.T[np.arange(3), np.abs(axes.T).argmax(axis=1)] < 0, -1, 1)[:, None]
    askew = axes[np.abs(axes).max(axis=1) < 0.9998]
    return np.concatenate([np.eye(3), askew])


def flat_faces(surface: Surface, aside: float = _ASIDE) -> list[Plane]:
    """The planes of the largest flat faces of a surface, by area, beside them on both sides, `aside` [m]."""
    normals = surface.normals()
    areas = np.linalg.norm(normals, axis=1)
    kept = areas > 1e-12
    normals, areas = normals[kept] / areas[kept, None], areas[kept]
    corners = surface.vertices[surface.triangles[kept, 0]]
    if not len(areas):
        return []
    # A face and its back are one plane.
    first = np.abs(normals) > 1e-3
    sign = np.sign(normals[np.arange(len(normals)), first.argmax(axis=1)])
    normals = normals * sign[:, None]
    heights = np.einsum("ij,ij->i", normals, corners)
    keys = np.column_stack([normals.round(2), (heights / (5 * aside)).round()]) + 0.0
    _, found, group = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    sums = np.bincount(group.ravel(), areas)
    largest = np.lexsort((found, -sums))[:_FACES]
    return [
        (normals[found[k]], float(heights[found[k]]) + shift) for k in largest for shift in (-aside, aside)
    ]


def through(axes: Points, points: Points) -> Iterator[Plane]:
    """Planes across each axis, at quantiles of the points (n, 3)."""
    for axis in axes:
        for height in np.quantile(points @ axis, _QUANTILES):
            yield axis, float(height)


def past(axes: Points, obstacles: Array) -> Iterator[Plane]:
    """Planes across each axis that an obstacle touches from one side: all of its places, and the half of them
    that are farthest. `obstacles`: the points (poses, n, 3) of another link in some poses."""
    for axis in axes:
        along = obstacles @ axis
        for height in (along.min(axis=1).min(), np.median(along.min(axis=1))):
            yield axis, float(height)
        for height in (along.max(axis=1).max(), np.median(along.max(axis=1))):
            yield axis, float(height)


def crossing(planes: Iterator[Plane], points: Points) -> list[Plane]:
    """Those of the planes that leave something of the points on both sides, each once."""
    found: dict[tuple[float, ...], Plane] = {}
    for normal, height in planes:
        along = points @ normal
        low, high = float(along.min()), float(along.max())
        if low + _EDGE * (high - low) < height < high - _EDGE * (high - low):
            key = *normal.round(6).tolist(), round(height, 6)
            found.setdefault(key, (normal, height))
    return list(found.values())


def ranked(
    every: Iterable[Plane], cloud: Points, score: Callable[[Points, Points], Score]
) -> list[tuple[Score, Plane]]:
    """Planes and their scores by the points of a cloud (n, 3) below and above, the least first."""
    found = []
    for normal, height in every:
        above = cloud @ normal > height
        found.append((score(cloud[~above], cloud[above]), (normal, height)))
    return sorted(found, key=lambda one: one[0])
