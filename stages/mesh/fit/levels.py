"""Where the bulk of a surface lies that faces a way: on a flat face, or around an axis or a point."""

import numpy as np

from linkwright.stages.mesh.fit.outline import Floats, Outline

_FACING = 0.9
_DEEPEST = 0.25
_LEAST = 0.05
_TIE = 1e-9


def flat(outline: Outline, direction: Floats, top: float, depth: float) -> float:
    """The height [m] along `direction` that half of the area which faces there is above, looked for down to a
    quarter of `depth` below `top`; `top` where hardly anything faces there."""
    facing = outline.normals @ direction
    heights = outline.centroids @ direction
    chosen = (facing > _FACING) & (heights > top - _DEEPEST * depth)
    return _median(heights[chosen], outline.areas[chosen], _LEAST * outline.areas.sum() / 6, top)


def around(outline: Outline, centre: Floats, axis: Floats | None, radius: float) -> float:
    """The distance [m] of the planes of the triangles that face away from an axis through `centre`, or from
    the centre itself: the middle one by area; `radius` where hardly anything faces away."""
    offsets, normals = outline.centroids - centre, outline.normals
    if axis is not None:
        offsets = offsets - np.outer(offsets @ axis, axis)
        normals = normals - np.outer(normals @ axis, axis)
    distances = np.linalg.norm(offsets, axis=1)
    heights = (offsets * normals).sum(axis=1)
    chosen = (heights > _FACING * distances) & (heights > (1 - _DEEPEST) * radius)
    return _median(heights[chosen], outline.areas[chosen], _LEAST * outline.areas.sum() / 2, radius)


def centre_of_turn(outline: Outline, axis: Floats | None, near: Floats, radius: float) -> Floats | None:
    """The point that the normals of the surface pass closest to, or in the plane across `axis` through which
    they do, by least squares over the area that faces away from `near` (3,); what passes at more than a tenth
    of `radius` is left out. None where they do not determine it."""
    sideways = np.ones(len(outline.areas), dtype=bool) if axis is None else abs(outline.normals @ axis) < 0.2
    outwards = ((outline.centroids - near) * outline.normals).sum(axis=1) > 0.5 * radius
    chosen = sideways & outwards
    centre = near
    for _ in range(2):
        found = _nearest(outline, chosen, axis, centre)
        if found is None:
            return None
        centre = found
        offsets = outline.centroids - centre
        if axis is not None:
            offsets = offsets - np.outer(offsets @ axis, axis)
        past = offsets - outline.normals * (offsets * outline.normals).sum(axis=1)[:, None]
        chosen = sideways & outwards & (np.linalg.norm(past, axis=1) < 0.1 * radius)
    return centre


def _nearest(outline: Outline, chosen: np.ndarray, axis: Floats | None, near: Floats) -> Floats | None:
    normals, weights = outline.normals[chosen], outline.areas[chosen]
    if weights.sum() < _LEAST * outline.areas.sum():
        return None
    if axis is not None:
        normals = normals - np.outer(normals @ axis, axis)
        normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    offsets = outline.centroids[chosen] - near
    total = weights.sum() * np.eye(3) - np.einsum("ni,nj,n->ij", normals, normals, weights)
    apart = offsets - normals * (offsets * normals).sum(axis=1)[:, None]
    right = (apart * weights[:, None]).sum(axis=0)
    if axis is not None:
        # Along the axis nothing is asked for.
        right = right - axis * float(axis @ right)
    values, vectors = np.linalg.eigh(total)
    if values[0] < 0.02 * weights.sum():
        return None
    return np.asarray(near + vectors @ ((vectors.T @ right) / values), dtype=np.float64)


def _median(values: Floats, weights: Floats, least: float, otherwise: float) -> float:
    """The weighted median; `otherwise` where the weights are less than `least`."""
    if not len(values) or weights.sum() < least:
        return otherwise
    order = np.argsort(values, kind="stable")
    below = np.cumsum(weights[order])
    # Both, where half of the area is below one and half above another.
    middle = np.searchsorted(below, below[-1] * np.array([0.5 - _TIE, 0.5 + _TIE]))
    return float(values[order[middle]].mean())
