"""Tells whether points are in the union of a collider's pieces, and how far from it they are."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, Surface, joined
from linkwright.stages.mesh.measure.tree import BoxTree, Corners, Indices, Nearest, Numbers
from linkwright.stages.mesh.surfaces.pieces import Distances, Piece, beyond_piece, signed_distance, surface_of
from linkwright.stages.robot.model.robot import Primitive


@dataclass(frozen=True, slots=True, eq=False)
class Union:
    """The union of convex pieces."""

    tree: BoxTree
    """Triangles of all pieces."""
    owners: Indices
    """Index of the piece of each triangle of the tree (m,)."""
    normals: Points
    """Unit normal of each triangle of the tree (m, 3)."""
    pieces: tuple[Piece, ...]
    beyond: tuple[Distances, ...]
    """Function `beyond_piece` of each piece."""
    low: Points
    high: Points
    """Bounds of each piece (k, 3) [m]."""
    hulls: Nearest | None
    """Distances from the pieces that are not primitives; None without such pieces."""
    surfaces: tuple[Surface, ...]
    """Closed surface of each piece."""

    @staticmethod
    def of(pieces: Sequence[Piece]) -> "Union":
        """Returns the union of pieces; raises ValueError without pieces."""
        if not pieces:
            msg = "a collider without pieces has no measures"
            raise ValueError(msg)
        surfaces = tuple(surface_of(piece) for piece in pieces)
        whole = joined(surfaces)
        owners = np.repeat(np.arange(len(surfaces)), [len(surface.triangles) for surface in surfaces])
        tree = BoxTree.of(whole)
        normals = unit_normals(whole)
        hulls = [piece for piece in pieces if isinstance(piece, Surface)]
        nearest = None
        if hulls:
            nearest = Nearest.of(tree if len(hulls) == len(surfaces) else BoxTree.of(joined(hulls)))
        low, high = (
            np.array([getattr(surface.vertices, side)(axis=0) for surface in surfaces])
            for side in ("min", "max")
        )
        # The polyhedron of a primitive lies inside the primitive in some places.
        slack = 0.005 * (high - low).max(axis=1, keepdims=True)
        return Union(
            tree,
            owners[tree.faces],
            normals[tree.faces],
            tuple(pieces),
            tuple(map(beyond_piece, pieces)),
            low - slack,
            high + slack,
            nearest,
            surfaces,
        )

    def corners(self, max_triangles: int) -> tuple[Corners, Indices, Points]:
        """Returns the triangles (m, 3, 3) of all pieces with at most `max_triangles`, except spheres and
        capsules, which have no corners; and the index of the piece and the unit normal of each triangle."""
        piece_indices = [
            number
            for number, body in enumerate(self.pieces)
            if len(self.surfaces[number].triangles) <= max_triangles
            and not (isinstance(body, Primitive) and body.kind in ("sphere", "capsule"))
        ]
        if not piece_indices:
            return np.zeros((0, 3, 3)), np.zeros(0, dtype=np.int64), np.zeros((0, 3))
        surfaces = [self.surfaces[number] for number in piece_indices]
        owners = np.repeat(piece_indices, [len(surface.triangles) for surface in surfaces])
        chosen_surface = joined(surfaces)
        return chosen_surface.corners, owners, unit_normals(chosen_surface)

    def depth(self, points: Points, without: Indices | None = None) -> Numbers:
        """Returns how deep [m] (n,) each point is in the pieces, except in the piece whose index `without`
        has for it. The value is −inf outside the bounds of all pieces, and at most 0 outside the pieces."""
        result = np.full(len(points), -np.inf)
        for number, beyond in enumerate(self.beyond):
            in_bounds = ((points >= self.low[number]) & (points <= self.high[number])).all(axis=1)
            if without is not None:
                in_bounds &= without != number
            indices = np.flatnonzero(in_bounds)
            if len(indices):
                result[indices] = np.maximum(result[indices], -beyond(points[indices]))
        return result

    def distance(self, points: Points, exact_from: Numbers | float) -> tuple[Numbers, npt.NDArray[np.bool_]]:
        """Returns the distance [m] of points (n, 3) outside of the union, and whether it is exact. Distances
        of `exact_from` (n,) or more are exact; other values may be upper bounds."""
        distances, exact = np.full(len(points), np.inf), np.ones(len(points), dtype=bool)
        for body in self.pieces:
            if isinstance(body, Primitive):
                distances = np.minimum(distances, signed_distance(body, points))
        if self.hulls is not None:
            hull_distances, exact = self.hulls(points, exact_from)
            exact |= distances <= 0
            distances = np.minimum(distances, hull_distances)
        return np.maximum(distances, 0.0), exact


def unit_normals(surface: Surface) -> Points:
    """Returns the unit normal of each triangle (m, 3); (0, 0, 0) for a triangle without area."""
    normals = surface.normals()
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    result: Points = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    return result
