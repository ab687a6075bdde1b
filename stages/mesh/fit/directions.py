"""Directions that a part may be made along, and the boxes around it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points
from linkwright.stages.mesh.fit.outline import Floats, Outline

_SNAP = np.cos(np.radians(0.5))
_SAME = np.cos(np.radians(0.25))
_FLAT = np.cos(np.radians(1.0))
_APART = np.cos(np.radians(10.0))
_SEEDS = 24
_SPECK = 1e-4
_LEAST_FLAT = 0.02
_FLATS = 5
_BOXES = 3
_TIE = 1e-6


def directions(outline: Outline) -> list[Floats]:
    """Unit vectors (3,), none of them twice nor with its opposite: the coordinate axes, the normals of large
    flat faces, the axes of the distribution of all normals (of a tube one is its own), and those of the mass
    of the surface."""
    middle = np.average(outline.centroids, axis=0, weights=outline.areas)
    spread = outline.centroids - middle
    found = [*np.eye(3), *_flats(outline), *_main(outline.normals, outline.areas)]
    found += _main(spread, outline.areas)
    distinct: list[Floats] = []
    for direction in map(snapped, found):
        if all(abs(direction @ other) < _SAME for other in distinct):
            distinct.append(direction)
    return distinct


def snapped(direction: Floats) -> Floats:
    """The direction, upwards along its largest component; a coordinate axis within 0.5° of it."""
    largest = int(np.abs(direction).argmax())
    if abs(direction[largest]) > _SNAP:
        return np.asarray(np.eye(3)[largest], dtype=np.float64)
    return np.asarray(direction * np.sign(direction[largest]), dtype=np.float64)


def across(direction: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors that make a right-handed frame with a direction; coordinate axes where it is one."""
    largest = int(np.abs(direction).argmax())
    first = np.eye(3)[(largest + 1) % 3]
    first = first - direction * direction[(largest + 1) % 3]
    first /= np.linalg.norm(first)
    return first, np.cross(direction, first)


@dataclass(frozen=True, slots=True, eq=False)
class Silhouette:
    """What a part looks like along a direction `axis`: `ring` (k, 2) [m], the convex polygon around it in
    terms of `u` and `v`, and the lowest and highest point along the axis."""

    axis: Floats
    u: Floats
    v: Floats
    ring: npt.NDArray[np.float64]
    low: float
    high: float


def silhouettes(outline: Outline) -> list[Silhouette]:
    """A part along each of its directions, but where it is too close to a line."""
    # Late: a part from the cache needs no library that makes colliders or decimates.
    from scipy.spatial import ConvexHull, QhullError

    found = []
    for axis in directions(outline):
        u, v = across(axis)
        flat = np.stack([outline.corners @ u, outline.corners @ v], axis=1)
        heights = outline.corners @ axis
        try:
            ring = flat[ConvexHull(flat).vertices]
        except QhullError:
            continue
        found.append(Silhouette(axis, u, v, ring, float(heights.min()), float(heights.max())))
    return found


def frames(outline: Outline, seen: Sequence[Silhouette]) -> list[npt.NDArray[np.float64]]:
    """The axes of the smallest boxes around the part, as rotations (3, 3) with the axes as columns."""
    found = [np.eye(3), *(_around(one) for one in seen)]
    # Equal boxes come once, by the first of them.
    volumes = [float(np.prod(np.ptp(outline.corners @ frame, axis=0))) for frame in found]
    ranks = np.round(np.log(volumes) / _TIE)
    _, first = np.unique(ranks, return_index=True)
    return [found[index] for index in first[:_BOXES]]


def upright(axes: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The rotation nearest to none that has these axes (3, 3), its columns, in any order and sense; where one
    of them is within 0.5° of a coordinate axis, it is that axis."""
    order = []
    for axis in range(3):
        left = [column for column in range(3) if column not in order]
        order.append(max(left, key=lambda column: round(abs(float(axes[axis, column])), 6)))
    turned = axes[:, order] * np.sign(np.diag(axes[:, order]) + (np.diag(axes[:, order]) == 0))
    exact = [axis for axis in range(3) if turned[axis, axis] > _SNAP]
    if len(exact) > 1:
        return np.eye(3)
    for axis in exact:
        second, third = (axis + 1) % 3, (axis + 2) % 3
        angle = np.arctan2(turned[third, second], turned[second, second])
        turned = np.eye(3)
        turned[second, second] = turned[third, third] = np.cos(angle)
        turned[third, second], turned[second, third] = np.sin(angle), -np.sin(angle)
    if np.linalg.det(turned) < 0:
        turned[:, 2] *= -1
    return np.asarray(turned, dtype=np.float64)


def _main(vectors: Points, weights: Floats) -> list[Floats]:
    """The eigenvectors of the vectors' second moment, but where they are not determined."""
    values, axes = np.linalg.eigh(np.einsum("ni,nj,n->ij", vectors, vectors, weights))
    gaps = np.diff(values) > 1e-3 * values[-1]
    certain = [gaps[0], gaps[0] and gaps[1], gaps[1]]
    return [axes[:, index] for index in range(3) if certain[index]]


def _flats(outline: Outline) -> list[Floats]:
    """The normals of the largest flat faces, the largest first."""
    total = outline.areas.sum()
    large = outline.areas > _SPECK * total
    areas, normals = outline.areas[large], outline.normals[large]
    found: list[Floats] = []
    for _ in range(_FLATS):
        seeds = np.argsort(-areas, kind="stable")[:_SEEDS]
        cosines = normals @ normals[seeds].T
        near = np.abs(cosines) > _FLAT
        if not near.any():
            break
        weights = (near * areas[:, None]).sum(axis=0)
        best = int((weights >= weights.max() * (1 - _TIE)).argmax())
        if weights[best] <= _LEAST_FLAT * total:
            break
        signs = np.sign(cosines[:, best]) * near[:, best] * areas
        mean = (normals * signs[:, None]).sum(axis=0)
        found.append(mean / np.linalg.norm(mean))
        areas[np.abs(cosines[:, best]) > _APART] = 0.0
    return found


def _around(seen: Silhouette) -> npt.NDArray[np.float64]:
    """The axes of the smallest box that has a side across the direction."""
    edges = np.roll(seen.ring, -1, axis=0) - seen.ring
    lengths = np.linalg.norm(edges, axis=1)
    edges = edges[lengths > 0] / lengths[lengths > 0, None]
    along = edges @ seen.ring.T
    beside = np.stack([-edges[:, 1], edges[:, 0]], axis=1) @ seen.ring.T
    areas = np.ptp(along, axis=1) * np.ptp(beside, axis=1)
    best = int((areas <= areas.min() * (1 + _TIE)).argmax())
    first = edges[best, 0] * seen.u + edges[best, 1] * seen.v
    return upright(np.stack([first, np.cross(seen.axis, first), seen.axis], axis=1))
