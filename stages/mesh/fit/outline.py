"""Prepares a surface and its hull for fits: distances from the surface are found by samples in a tree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import scipy

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.configuration.collider_settings import MIN_TOLERANCE, TOLERANCE_SHARE
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.pieces import signed_distance

if TYPE_CHECKING:
    from linkwright.stages.robot.model.robot import Primitive

Floats = npt.NDArray[np.float64]

_TARGET_SAMPLES = 2000
"""Number of samples if all triangles are of equal size."""

_MAX_SAMPLES = 40_000
"""Largest number of samples."""

_NEAREST_SAMPLES = 4
"""Number of samples near a point whose triangles are searched for the nearest one."""

_MAX_HALVINGS = 12  # of a triangle, so that slivers end it

_EDGE_OF_UNIT_TRIANGLE = 1.5
"""About the edge of an equilateral triangle of area 1."""

_EQUAL_LENGTHS = 1e-6
"""Relative difference up to which two edges count as equally long."""

_EQUAL_SQUARES = 1e-6, 1e-24
"""Relative and absolute [m²] difference up to which two squared distances count as equal."""

_LEAST_SQUARE = 1e-300
"""Least squared length [m²] by which is divided."""


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """A surface and its hull. Triangles without area are left out."""

    hull_vertices: Points
    """Vertices (k, 3) of the hull [m]."""
    hull: Surface
    volume: float
    """Volume of the hull [m³]."""
    triangles: Floats
    """Corners of the triangles (m, 3, 3) [m]."""
    centroids: Points
    """Centroids of the triangles (m, 3) [m]."""
    normals: Points
    """Unit normals of the triangles (m, 3)."""
    areas: Floats
    """Areas of the triangles (m,) [m²]."""
    tree: scipy.spatial.cKDTree
    """Samples all over the surface."""
    sample_triangles: npt.NDArray[np.int64]
    """Index of each sample's triangle (s,)."""
    size: float
    """Diagonal of the hull's bounding box [m]."""

    @property
    def tolerance(self) -> float:
        """Default tolerance of a part of this size [m]."""
        return max(MIN_TOLERANCE, TOLERANCE_SHARE * self.size)

    def bareness(self, primitive: Primitive) -> float:
        """Returns how far [m] the part stands out of a primitive at most, which is at a vertex of its
        hull."""
        return max(0.0, float(signed_distance(primitive, self.hull_vertices).max()))

    def protrusion(self, points: Points) -> Floats:
        """Returns how far [m] (n,) each point (n, 3) is outside of the part; 0 inside."""
        distances, in_front = self._distances_and_sides(points)
        return np.where(in_front, distances, 0.0)

    def distance(self, points: Points) -> Floats:
        """Returns the distance [m] (n,) of each point (n, 3) from the surface."""
        return self._distances_and_sides(points)[0]

    def _distances_and_sides(self, points: Points) -> tuple[Floats, npt.NDArray[np.bool_]]:
        """Returns the distance [m] (n,) of each point (n, 3) from the surface, and whether the point is in
        front of it (n,)."""
        _, nearest_samples = self.tree.query(points, k=min(_NEAREST_SAMPLES, len(self.sample_triangles)))
        indices = self.sample_triangles[np.asarray(nearest_samples).reshape(len(points), -1)]
        return _distances(points, self.triangles[indices], self.normals[indices])


def outline_of(surface: Surface) -> Outline | None:
    """Returns the outline of a surface; None if it lies in a plane."""
    hull = convex_hull(surface.vertices)
    if hull is None:
        return None
    if surface.volume() < 0:
        surface = surface.flipped()
    doubled_normals = surface.normals()
    lengths = np.linalg.norm(doubled_normals, axis=1)
    has_area = lengths > 0
    triangles, areas = surface.corners[has_area], lengths[has_area] / 2
    points, owners = _samples(triangles, areas)
    return Outline(
        hull_vertices=hull.vertices,
        hull=hull,
        volume=hull.volume(),
        triangles=triangles,
        centroids=triangles.mean(axis=1),
        normals=doubled_normals[has_area] / lengths[has_area, None],
        areas=areas,
        tree=scipy.spatial.cKDTree(points),
        sample_triangles=owners,
        size=hull.diagonal,
    )


def _samples(triangles: Floats, areas: Floats) -> tuple[Points, npt.NDArray[np.int64]]:
    """Returns points all over the triangles, dense enough to find the nearest triangle by the nearest points,
    and the index of each point's triangle.

    A triangle is halved at its longest edge, or quartered if two edges are equally long, so that the order of
    its corners does not matter.
    """
    max_edge = _EDGE_OF_UNIT_TRIANGLE * np.sqrt(areas.sum() / _TARGET_SAMPLES)
    owners = np.arange(len(triangles))
    sample_points: list[Points] = []
    sample_owners: list[npt.NDArray[np.int64]] = []
    for _ in range(_MAX_HALVINGS):
        edges = np.linalg.norm(np.roll(triangles, -1, axis=1) - triangles, axis=2)
        is_fine = edges.max(axis=1) <= max_edge
        sample_points.append(triangles[is_fine].mean(axis=1))
        sample_owners.append(owners[is_fine])
        triangles, owners, edges = triangles[~is_fine], owners[~is_fine], edges[~is_fine]
        has_too_many = sum(map(len, sample_owners)) + 2 * len(triangles) > _MAX_SAMPLES
        if not len(triangles) or has_too_many:
            break
        triangles, owners = _divided(triangles, owners, edges)
    # The rest stays coarse.
    sample_points.append(triangles.mean(axis=1))
    sample_owners.append(owners)
    return np.concatenate(sample_points), np.concatenate(sample_owners)


def _divided(
    triangles: Floats, owners: npt.NDArray[np.int64], edges: Floats
) -> tuple[Floats, npt.NDArray[np.int64]]:
    """Returns the halves or quarters of triangles (n, 3, 3), and the owner of each. `edges`: the lengths of
    their edges (n, 3), the first from the first corner to the second."""
    rows = np.arange(len(triangles))
    longest = edges.argmax(axis=1)
    second = np.sort(edges, axis=1)[:, 1]
    is_tied = second > edges[rows, longest] * (1 - _EQUAL_LENGTHS)
    # The corners begin at the longest edge.
    order = (longest[:, None] + np.arange(3)) % 3
    a, b, c = np.moveaxis(np.take_along_axis(triangles, order[:, :, None], axis=1), 1, 0)
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    halves = [(a, ab, c), (ab, b, c)]
    quarters = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    parts = [np.stack(half, axis=1)[~is_tied] for half in halves]
    parts += [np.stack(quarter, axis=1)[is_tied] for quarter in quarters]
    return np.concatenate(parts), np.concatenate([*[owners[~is_tied]] * 2, *[owners[is_tied]] * 4])


def _distances(points: Points, triangles: Floats, normals: Floats) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """Returns the distance (n,) of each point from the nearest of its triangles (n, k, 3, 3) with `normals`
    (n, k, 3), and whether the point is in front of it (n,). If several triangles are equally near, the sum of
    the signed heights above them decides."""
    from_corners = points[:, None, None] - triangles
    edges = np.roll(triangles, -1, axis=2) - triangles
    squares = np.maximum((edges * edges).sum(axis=3), _LEAST_SQUARE)
    edge_fractions = np.clip((from_corners * edges).sum(axis=3) / squares, 0.0, 1.0)
    to_edges = ((from_corners - edge_fractions[..., None] * edges) ** 2).sum(axis=3)
    is_above_triangle = ((np.cross(edges, from_corners) * normals[:, :, None]).sum(axis=3) >= 0).all(axis=2)
    heights = (from_corners[:, :, 0] * normals).sum(axis=2)
    squared = np.where(is_above_triangle, heights**2, to_edges.min(axis=2))
    least_squared = squared.min(axis=1, keepdims=True)
    relative, absolute = _EQUAL_SQUARES
    is_nearest = squared <= least_squared * (1 + relative) + absolute
    in_front = (heights * is_nearest).sum(axis=1) > 0
    return np.sqrt(least_squared[:, 0]), in_front
