"""What is fitted: a surface with its hull, prepared for questions of distance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.configuration.collider_settings import LEAST_TOLERANCE, TOLERANCE_OF_SIZE
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.pieces import signed_distance

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

    from linkwright.stages.robot.model.robot import Primitive

Floats = npt.NDArray[np.float64]

_SAMPLES = 2000
_MOST_SAMPLES = 40_000
_NEAREST = 4
_ROUNDS = 12
_TIE = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """A surface and its hull.

    `corners` (k, 3): the hull's vertices [m]; `volume`: of the hull [m³]. `centroids`, `normals` (m, 3) and
    `areas` (m,) [m²]: of the surface's triangles that have an area. `sample_faces` (s,): which of them each
    sample of the tree is on.
    """

    corners: Points
    hull: Surface
    volume: float
    faces: npt.NDArray[np.float64]
    centroids: Points
    normals: Points
    areas: Floats
    tree: cKDTree
    sample_faces: npt.NDArray[np.int64]
    size: float

    @property
    def tolerance(self) -> float:
        """The usual tolerance of a part of this size [m]."""
        return max(LEAST_TOLERANCE, TOLERANCE_OF_SIZE * self.size)

    def bareness(self, primitive: Primitive) -> float:
        """How far [m] the part stands out of a primitive, at most: that is at a vertex of its hull."""
        return max(0.0, float(signed_distance(primitive, self.corners).max()))

    def protrusion(self, points: Points) -> Floats:
        """(n,): how far [m] each point (n, 3) is outside of the part; 0 inside."""
        distances, ahead = self._nearest(points)
        return np.where(ahead, distances, 0.0)

    def distance(self, points: Points) -> Floats:
        """(n,): how far [m] each point (n, 3) is from the surface."""
        return self._nearest(points)[0]

    def _nearest(self, points: Points) -> tuple[Floats, npt.NDArray[np.bool_]]:
        _, near = self.tree.query(points, k=min(_NEAREST, len(self.sample_faces)))
        faces = self.sample_faces[np.asarray(near).reshape(len(points), -1)]
        return _apart(points, self.faces[faces], self.normals[faces])


def outline_of(surface: Surface) -> Outline | None:
    """The outline of a surface; None where it lies in a plane."""
    # Late: a part from the cache needs no library that makes colliders or decimates.
    from scipy.spatial import cKDTree

    hull = convex_hull(surface.vertices)
    if hull is None:
        return None
    if surface.volume() < 0:
        surface = surface.flipped()
    doubled = surface.normals()
    lengths = np.linalg.norm(doubled, axis=1)
    real = lengths > 0
    faces, areas = surface.corners[real], lengths[real] / 2
    points, owners = _samples(faces, areas)
    return Outline(
        corners=hull.vertices,
        hull=hull,
        volume=hull.volume(),
        faces=faces,
        centroids=faces.mean(axis=1),
        normals=doubled[real] / lengths[real, None],
        areas=areas,
        tree=cKDTree(points),
        sample_faces=owners,
        size=hull.diagonal,
    )


def _samples(faces: npt.NDArray[np.float64], areas: Floats) -> tuple[Points, npt.NDArray[np.int64]]:
    """Points all over the triangles, close enough to find the nearest triangle by, and the triangle of each.

    A triangle is halved at its longest edge, or quartered where two are as long, so that the order of its
    corners does not matter.
    """
    wanted = 1.5 * np.sqrt(areas.sum() / _SAMPLES)
    owners = np.arange(len(faces))
    small: list[Points] = []
    found: list[npt.NDArray[np.int64]] = []
    for _ in range(_ROUNDS):
        edges = np.linalg.norm(np.roll(faces, -1, axis=1) - faces, axis=2)
        enough = edges.max(axis=1) <= wanted
        small.append(faces[enough].mean(axis=1))
        found.append(owners[enough])
        faces, owners, edges = faces[~enough], owners[~enough], edges[~enough]
        if not len(faces) or sum(map(len, found)) + 2 * len(faces) > _MOST_SAMPLES:
            break
        faces, owners = _divided(faces, owners, edges)
    small.append(faces.mean(axis=1))
    found.append(owners)
    return np.concatenate(small), np.concatenate(found)


def _divided(
    faces: npt.NDArray[np.float64], owners: npt.NDArray[np.int64], edges: Floats
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    rows = np.arange(len(faces))
    longest = edges.argmax(axis=1)
    second = np.sort(edges, axis=1)[:, 1]
    tied = second > edges[rows, longest] * (1 - _TIE)
    # Turned so that the longest edge is the first.
    turned = np.take_along_axis(faces, ((longest[:, None] + np.arange(3)) % 3)[:, :, None], axis=1)
    a, b, c = np.moveaxis(turned, 1, 0)
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    halves = [(a, ab, c), (ab, b, c)]
    quarters = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    parts = [np.stack(half, axis=1)[~tied] for half in halves]
    parts += [np.stack(quarter, axis=1)[tied] for quarter in quarters]
    return np.concatenate(parts), np.concatenate([*[owners[~tied]] * 2, *[owners[tied]] * 4])


def _apart(
    points: Points, faces: npt.NDArray[np.float64], normals: npt.NDArray[np.float64]
) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """(n,): the distance of each point from the nearest of its triangles (n, k, 3, 3), and whether it is in
    front of it; of several that are as near, in front of them together."""
    offset = points[:, None, None] - faces
    edges = np.roll(faces, -1, axis=2) - faces
    squares = np.maximum((edges * edges).sum(axis=3), 1e-300)
    along = np.clip((offset * edges).sum(axis=3) / squares, 0.0, 1.0)
    to_edges = ((offset - along[..., None] * edges) ** 2).sum(axis=3)
    inside = ((np.cross(edges, offset) * normals[:, :, None]).sum(axis=3) >= 0).all(axis=2)
    heights = (offset[:, :, 0] * normals).sum(axis=2)
    squared = np.where(inside, heights**2, to_edges.min(axis=2))
    least = squared.min(axis=1, keepdims=True)
    nearest = squared <= least * (1 + 1e-6) + 1e-24
    ahead = (heights * nearest).sum(axis=1) > 0
    return np.sqrt(least[:, 0]), ahead
