"""Finds where most of a surface lies: the height of a flat face, or the radius about an axis or a point."""

import numpy as np

from linkwright.stages.mesh.fit.outline import Floats, Outline

_MIN_FACING_COSINE = 0.9
"""Smallest cosine between a normal and a direction for a triangle that faces that way."""

_MAX_DEPTH_SHARE = 0.25
"""Share of the depth or radius below the outermost point within which triangles count."""

_MIN_AREA_SHARE = 0.05
"""Smallest share of the area, of a box's face or of half a surface, that determines a result."""

_MEDIAN_TOLERANCE = 1e-9
"""Share of the area by which the median may be missed: rounding must not decide it."""


def face_height(outline: Outline, direction: Floats, top: float, depth: float) -> float:
    """Returns the area-weighted median height [m] along `direction` of the triangles that face that way and
    lie at most a quarter of `depth` below `top`; `top` if almost no triangles do."""
    facing = outline.normals @ direction
    heights = outline.centroids @ direction
    mask = (facing > _MIN_FACING_COSINE) & (heights > top - _MAX_DEPTH_SHARE * depth)
    # A sixth of the surface: one face of a cube.
    return _median(heights[mask], outline.areas[mask], _MIN_AREA_SHARE * outline.areas.sum() / 6, top)


def median_radius(outline: Outline, centre: Floats, axis: Floats | None, radius: float) -> float:
    """Returns the area-weighted median radius [m]: the distance of the planes of outward-facing triangles
    from an axis through `centre`, or from `centre` itself; `radius` if almost no triangles face outwards."""
    offsets, normals = outline.centroids - centre, outline.normals
    if axis is not None:
        offsets = offsets - np.outer(offsets @ axis, axis)
        normals = normals - np.outer(normals @ axis, axis)
    distances = np.linalg.norm(offsets, axis=1)
    heights = (offsets * normals).sum(axis=1)
    mask = (heights > _MIN_FACING_COSINE * distances) & (heights > (1 - _MAX_DEPTH_SHARE) * radius)
    return _median(heights[mask], outline.areas[mask], _MIN_AREA_SHARE * outline.areas.sum() / 2, radius)


def revolution_centre(
    outline: Outline, axis: Floats | None, estimate: Floats, radius: float
) -> Floats | None:
    """Finds the centre of a surface of revolution: the point closest to the lines of its normals, by
    area-weighted least squares. With `axis`, only the position across the axis is found.

    `estimate` (3,): first estimate; only triangles that face away from it count. Normals that pass the centre
    at more than a tenth of `radius` are left out in a second round. None if the normals do not determine it.
    """
    sideways = np.ones(len(outline.areas), dtype=bool) if axis is None else abs(outline.normals @ axis) < 0.2
    outwards = ((outline.centroids - estimate) * outline.normals).sum(axis=1) > 0.5 * radius
    mask = sideways & outwards
    centre = estimate
    for _ in range(2):
        nearest = _nearest_to_normals(outline, mask, axis, centre)
        if nearest is None:
            return None
        centre = nearest
        offsets = outline.centroids - centre
        if axis is not None:
            offsets = offsets - np.outer(offsets @ axis, axis)
        misses = offsets - outline.normals * (offsets * outline.normals).sum(axis=1)[:, None]
        mask = sideways & outwards & (np.linalg.norm(misses, axis=1) < 0.1 * radius)
    return centre


def _nearest_to_normals(
    outline: Outline, mask: np.ndarray, axis: Floats | None, estimate: Floats
) -> Floats | None:
    normals, weights = outline.normals[mask], outline.areas[mask]
    if weights.sum() < _MIN_AREA_SHARE * outline.areas.sum():
        return None
    if axis is not None:
        normals = normals - np.outer(normals @ axis, axis)
        normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    offsets = outline.centroids[mask] - estimate
    # The point c with the least Σ a |(I − n nᵀ)(x − c)|² solves Σ a (I − n nᵀ) c = Σ a (I − n nᵀ) x.
    normal_matrix = weights.sum() * np.eye(3) - np.einsum("ni,nj,n->ij", normals, normals, weights)
    offsets_across = offsets - normals * (offsets * normals).sum(axis=1)[:, None]
    right_hand_side = (offsets_across * weights[:, None]).sum(axis=0)
    if axis is not None:
        # The position along the axis is free.
        right_hand_side = right_hand_side - axis * float(axis @ right_hand_side)
    values, vectors = np.linalg.eigh(normal_matrix)
    # Normals that are nearly parallel, or lie nearly in a plane without `axis`, leave a direction free.
    if values[0] < 0.02 * weights.sum():
        return None
    return np.asarray(estimate + vectors @ ((vectors.T @ right_hand_side) / values), dtype=np.float64)


def _median(values: Floats, weights: Floats, least_weight: float, fallback: float) -> float:
    """Returns the weighted median; `fallback` if the weights add up to less than `least_weight`."""
    if not len(values) or weights.sum() < least_weight:
        return fallback
    order = np.argsort(values, kind="stable")
    cumulated = np.cumsum(weights[order])
    # If exactly half of the area is below a gap between two values, the median is their mean.
    middle = np.searchsorted(
        cumulated, cumulated[-1] * np.array([0.5 - _MEDIAN_TOLERANCE, 0.5 + _MEDIAN_TOLERANCE])
    )
    return float(values[order[middle]].mean())
