"""Finds directions along which a part may be made, and the smallest boxes around it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy

from linkwright.stages.formats.meshes.surface import Points
from linkwright.stages.mesh.fit.outline import Floats, Outline

_SNAP_COSINE = np.cos(np.radians(0.5))
"""Directions nearer to a coordinate axis become that axis."""

_SAME_COSINE = np.cos(np.radians(0.25))
"""Directions nearer to each other count as the same."""

_FLAT_COSINE = np.cos(np.radians(1.0))
"""Triangles whose normals are nearer to a seed's normal belong to its flat face."""

_SEPARATE_COSINE = np.cos(np.radians(10.0))
"""After a flat face is found, triangles whose normals are nearer to its normal are left out."""

_MAX_SEEDS = 24
"""Largest number of triangles, the largest first, that are tried as seeds of a flat face."""

_MIN_TRIANGLE_SHARE = 1e-4
_MIN_FACE_SHARE = 0.02
"""Smallest triangles and flat faces that count, as shares of the whole area."""

_MAX_FACES = 5
_MAX_BOXES = 3
_EQUAL_SHARE = 1e-6
"""Relative difference up to which areas and volumes count as equal, so that rounding decides nothing."""


def directions(outline: Outline) -> list[Floats]:
    """Returns unit vectors (3,) without duplicates and opposites: the coordinate axes, the normals of large
    flat faces, the principal axes of all normals (the axis of a tube is among them), and the principal axes
    of the surface's area."""
    centroid = np.average(outline.centroids, axis=0, weights=outline.areas)
    offsets = outline.centroids - centroid
    candidates = [*np.eye(3), *_face_normals(outline), *_principal_axes(outline.normals, outline.areas)]
    candidates += _principal_axes(offsets, outline.areas)
    distinct: list[Floats] = []
    for direction in map(snapped, candidates):
        if all(abs(direction @ other) < _SAME_COSINE for other in distinct):
            distinct.append(direction)
    return distinct


def snapped(direction: Floats) -> Floats:
    """Returns the direction with a positive largest component, or a coordinate axis within 0.5° of it."""
    largest = int(np.abs(direction).argmax())
    if abs(direction[largest]) > _SNAP_COSINE:
        return np.asarray(np.eye(3)[largest], dtype=np.float64)
    return np.asarray(direction * np.sign(direction[largest]), dtype=np.float64)


def axes_across(direction: Floats) -> tuple[Floats, Floats]:
    """Returns two unit vectors that make a right-handed frame with a direction; for a coordinate axis they
    are coordinate axes."""
    largest = int(np.abs(direction).argmax())
    first = np.eye(3)[(largest + 1) % 3]
    first = first - direction * direction[(largest + 1) % 3]
    first /= np.linalg.norm(first)
    return first, np.cross(direction, first)


@dataclass(frozen=True, slots=True, eq=False)
class Silhouette:
    """The silhouette of a part, seen along an axis."""

    axis: Floats
    """Unit vector (3,) of the view."""
    u: Floats
    v: Floats
    """Unit vectors (3,) that make a right-handed frame with the axis."""
    ring: npt.NDArray[np.float64]
    """Convex polygon around the part (k, 2) [m], in coordinates along `u` and `v`."""
    low: float
    high: float
    """Lowest and highest point of the part along the axis [m]."""


def silhouettes(outline: Outline) -> list[Silhouette]:
    """Returns the silhouette along each direction of a part, except those that are nearly a line."""
    result = []
    for axis in directions(outline):
        u, v = axes_across(axis)
        projected = np.stack([outline.hull_vertices @ u, outline.hull_vertices @ v], axis=1)
        heights = outline.hull_vertices @ axis
        try:
            ring = projected[scipy.spatial.ConvexHull(projected).vertices]
        except scipy.spatial.QhullError:
            continue
        result.append(Silhouette(axis, u, v, ring, float(heights.min()), float(heights.max())))
    return result


def frames(outline: Outline, part_silhouettes: Sequence[Silhouette]) -> list[npt.NDArray[np.float64]]:
    """Returns the axes, as the columns of rotations (3, 3), of at most three different boxes around the part:
    the smallest of the boxes along the coordinate axes and along the silhouettes."""
    rotations = [np.eye(3), *(_smallest_box(silhouette) for silhouette in part_silhouettes)]
    # Of equal boxes only the first is kept.
    volumes = [float(np.prod(np.ptp(outline.hull_vertices @ frame, axis=0))) for frame in rotations]
    ranks = np.round(np.log(volumes) / _EQUAL_SHARE)
    _, first = np.unique(ranks, return_index=True)
    return [rotations[index] for index in first[:_MAX_BOXES]]


def upright(axes: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Returns a small rotation (3, 3) whose columns are the columns of `axes`, reordered and reversed to be
    near x, y and z; an axis within 0.5° of a coordinate axis becomes that axis."""
    order = []
    for axis in range(3):
        remaining = [column for column in range(3) if column not in order]
        order.append(max(remaining, key=lambda column: round(abs(float(axes[axis, column])), 6)))
    rotation = axes[:, order] * np.sign(np.diag(axes[:, order]) + (np.diag(axes[:, order]) == 0))
    exact_axes = [axis for axis in range(3) if rotation[axis, axis] > _SNAP_COSINE]
    if len(exact_axes) > 1:
        return np.eye(3)
    for axis in exact_axes:
        second, third = (axis + 1) % 3, (axis + 2) % 3
        angle = np.arctan2(rotation[third, second], rotation[second, second])
        rotation = np.eye(3)
        rotation[second, second] = rotation[third, third] = np.cos(angle)
        rotation[third, second], rotation[second, third] = np.sin(angle), -np.sin(angle)
    if np.linalg.det(rotation) < 0:
        rotation[:, 2] *= -1
    return np.asarray(rotation, dtype=np.float64)


def _principal_axes(vectors: Points, weights: Floats) -> list[Floats]:
    """Returns the eigenvectors of the vectors' second moment whose eigenvalues differ from the others."""
    values, axes = np.linalg.eigh(np.einsum("ni,nj,n->ij", vectors, vectors, weights))
    gaps = np.diff(values) > 1e-3 * values[-1]
    certain = [gaps[0], gaps[0] and gaps[1], gaps[1]]
    return [axes[:, index] for index in range(3) if certain[index]]


def _face_normals(outline: Outline) -> list[Floats]:
    """Returns the normals of the largest flat faces, the largest first."""
    total = outline.areas.sum()
    is_large = outline.areas > _MIN_TRIANGLE_SHARE * total
    areas, normals = outline.areas[is_large], outline.normals[is_large]
    face_normals: list[Floats] = []
    for _ in range(_MAX_FACES):
        seeds = np.argsort(-areas, kind="stable")[:_MAX_SEEDS]
        cosines = normals @ normals[seeds].T
        near_seed = np.abs(cosines) > _FLAT_COSINE
        if not near_seed.any():
            break
        weights = (near_seed * areas[:, None]).sum(axis=0)
        best = int((weights >= weights.max() * (1 - _EQUAL_SHARE)).argmax())
        if weights[best] <= _MIN_FACE_SHARE * total:
            break
        signs = np.sign(cosines[:, best]) * near_seed[:, best] * areas
        mean = (normals * signs[:, None]).sum(axis=0)
        face_normals.append(mean / np.linalg.norm(mean))
        areas[np.abs(cosines[:, best]) > _SEPARATE_COSINE] = 0.0
    return face_normals


def _smallest_box(silhouette: Silhouette) -> npt.NDArray[np.float64]:
    """Returns the axes of the smallest box around a part with two sides across the silhouette's axis."""
    edges = np.roll(silhouette.ring, -1, axis=0) - silhouette.ring
    lengths = np.linalg.norm(edges, axis=1)
    edges = edges[lengths > 0] / lengths[lengths > 0, None]
    along_edges = edges @ silhouette.ring.T
    across_edges = np.stack([-edges[:, 1], edges[:, 0]], axis=1) @ silhouette.ring.T
    areas = np.ptp(along_edges, axis=1) * np.ptp(across_edges, axis=1)
    best = int((areas <= areas.min() * (1 + _EQUAL_SHARE)).argmax())
    first = edges[best, 0] * silhouette.u + edges[best, 1] * silhouette.v
    return upright(np.stack([first, np.cross(silhouette.axis, first), silhouette.axis], axis=1))
