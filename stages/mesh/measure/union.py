"""Tells whether points are in the union of a collider's pieces, and how far they are from it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, Surface, join_surfaces
from linkwright.stages.mesh.measure.tree import BoxTree, Corners, Indices, Nearest, Numbers
from linkwright.stages.mesh.surfaces.pieces import Distances, Piece, beyond_piece, signed_distance, surface_of
from linkwright.stages.robot.model.robot import Primitive

_SLACK = 0.005
"""Distance by which the box of a piece is widened, as a share of its longest side: the polyhedron of a
primitive lies inside the primitive by less than that."""


@dataclass(frozen=True, slots=True, eq=False)
class PieceUnion:
    """The union of convex pieces."""

    tree: BoxTree
    """Triangles of all pieces."""
    piece_indices: Indices
    """Index of the piece of each triangle of the tree (m,)."""
    normals: Points
    """Unit normal of each triangle of the tree (m, 3)."""
    pieces: tuple[Piece, ...]
    distance_functions: tuple[Distances, ...]
    """For each piece, the function that `beyond_piece` returns."""
    low: Points
    """Lowest corner of the box around each piece (k, 3) [m]."""
    high: Points
    """Highest corner of the box around each piece (k, 3) [m]."""
    hull_distance: Nearest | None
    """Distances from the pieces that are not primitives; None without such pieces."""
    surfaces: tuple[Surface, ...]
    """Closed surface of each piece."""

    @staticmethod
    def of(pieces: Sequence[Piece]) -> "PieceUnion":
        """Returns the union of pieces; raises ValueError if there are none."""
        if not pieces:
            msg = "a collider without pieces has no measures"
            raise ValueError(msg)
        surfaces = tuple(surface_of(piece) for piece in pieces)
        joined_surface = join_surfaces(surfaces)
        owners = np.repeat(np.arange(len(surfaces)), [len(surface.triangles) for surface in surfaces])
        tree = BoxTree.of(joined_surface)
        normals = unit_normals(joined_surface)
        hull_pieces = [piece for piece in pieces if isinstance(piece, Surface)]
        hull_distance = None
        if hull_pieces:
            has_only_hulls = len(hull_pieces) == len(surfaces)
            hull_distance = Nearest.of(tree if has_only_hulls else BoxTree.of(join_surfaces(hull_pieces)))
        low = np.array([surface.vertices.min(axis=0) for surface in surfaces])
        high = np.array([surface.vertices.max(axis=0) for surface in surfaces])
        # The polyhedron of a primitive lies partly inside the primitive, so the boxes are widened.
        slack = _SLACK * (high - low).max(axis=1, keepdims=True)
        return PieceUnion(
            tree,
            owners[tree.faces],
            normals[tree.faces],
            tuple(pieces),
            tuple(map(beyond_piece, pieces)),
            low - slack,
            high + slack,
            hull_distance,
            surfaces,
        )

    def triangles(self, max_triangles: int) -> tuple[Corners, Indices, Points]:
        """Returns the triangles (m, 3, 3) of the pieces that have at most `max_triangles`, with each
        triangle's piece index and unit normal. Spheres and capsules are left out, since they have no
        corners."""
        piece_indices = [
            index
            for index, piece in enumerate(self.pieces)
            if len(self.surfaces[index].triangles) <= max_triangles
            and not (isinstance(piece, Primitive) and piece.kind in ("sphere", "capsule"))
        ]
        if not piece_indices:
            return np.zeros((0, 3, 3)), np.zeros(0, dtype=np.int64), np.zeros((0, 3))
        surfaces = [self.surfaces[index] for index in piece_indices]
        owners = np.repeat(piece_indices, [len(surface.triangles) for surface in surfaces])
        chosen_surface = join_surfaces(surfaces)
        return chosen_surface.corners, owners, unit_normals(chosen_surface)

    def depth(self, points: Points, ignored_piece: Indices | None = None) -> Numbers:
        """Returns how deep (n,) [m] each point (n, 3) is in the pieces: at most 0 outside them, and −inf
        outside all their boxes. `ignored_piece` (n,): index of the piece that is ignored for each
        point."""
        result = np.full(len(points), -np.inf)
        for index, beyond in enumerate(self.distance_functions):
            in_box = ((points >= self.low[index]) & (points <= self.high[index])).all(axis=1)
            if ignored_piece is not None:
                in_box &= ignored_piece != index
            rows = np.flatnonzero(in_box)
            if len(rows):
                result[rows] = np.maximum(result[rows], -beyond(points[rows]))
        return result

    def distance(self, points: Points, exact_from: Numbers | float) -> tuple[Numbers, npt.NDArray[np.bool_]]:
        """Returns the distance (n,) [m] of points (n, 3) from the union, 0 inside, and whether it is exact.
        Distances of at least `exact_from` are exact; smaller distances may be upper bounds."""
        distances, exact = np.full(len(points), np.inf), np.ones(len(points), dtype=bool)
        for piece in self.pieces:
            if isinstance(piece, Primitive):
                distances = np.minimum(distances, signed_distance(piece, points))
        if self.hull_distance is not None:
            hull_distances, exact = self.hull_distance(points, exact_from)
            exact |= distances <= 0
            distances = np.minimum(distances, hull_distances)
        return np.maximum(distances, 0.0), exact


def unit_normals(surface: Surface) -> Points:
    """Returns the unit normal of each triangle (m, 3); (0, 0, 0) for a triangle without area."""
    normals = surface.normals()
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    result: Points = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    return result
