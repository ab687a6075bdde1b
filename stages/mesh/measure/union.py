"""The union of a collider's pieces: what is in it, and how far from it points are."""

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
    """Convex pieces together. `tree` has the surfaces of all, `owners` (m,) which piece each of its triangles
    is of, `normals` (m, 3) where that faces; `beyond`: of each how far points are beyond it, see
    `beyond_piece`; `hulls` measures from those that are no primitives."""

    tree: BoxTree
    owners: Indices
    normals: Points
    pieces: tuple[Piece, ...]
    beyond: tuple[Distances, ...]
    low: Points
    high: Points
    hulls: Nearest | None
    surfaces: tuple[Surface, ...]

    @staticmethod
    def of(pieces: Sequence[Piece]) -> "Union":
        """ValueError where there is no piece."""
        if not pieces:
            msg = "a collider without pieces has no measures"
            raise ValueError(msg)
        surfaces = tuple(surface_of(piece) for piece in pieces)
        every = joined(surfaces)
        owners = np.repeat(np.arange(len(surfaces)), [len(surface.triangles) for surface in surfaces])
        tree = BoxTree.of(every)
        normals = unit_normals(every)
        hulls = [piece for piece in pieces if isinstance(piece, Surface)]
        nearest = None
        if hulls:
            nearest = Nearest.of(tree if len(hulls) == len(surfaces) else BoxTree.of(joined(hulls)))
        low, high = (
            np.array([getattr(surface.vertices, side)(axis=0) for surface in surfaces])
            for side in ("min", "max")
        )
        # The polyhedra of primitives lie a little within them here and there.
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

    def corners(self, most: int) -> tuple[Corners, Indices, Points]:
        """The corners (m, 3, 3) of the pieces of at most so many triangles: hulls, boxes and cylinders; the
        piece and the unit normal of each triangle. Of what is round no point is a corner."""
        chosen = [
            number
            for number, body in enumerate(self.pieces)
            if len(self.surfaces[number].triangles) <= most
            and not (isinstance(body, Primitive) and body.kind in ("sphere", "capsule"))
        ]
        if not chosen:
            return np.zeros((0, 3, 3)), np.zeros(0, dtype=np.int64), np.zeros((0, 3))
        surfaces = [self.surfaces[number] for number in chosen]
        owners = np.repeat(chosen, [len(surface.triangles) for surface in surfaces])
        every = joined(surfaces)
        return every.corners, owners, unit_normals(every)

    def depth(self, points: Points, without: Indices | None = None) -> Numbers:
        """(n,): how deep [m] each point is in some piece, but not in its own of `without`; −inf where it is
        in none, and at most 0 where only its bounds have it."""
        result = np.full(len(points), -np.inf)
        for number, beyond in enumerate(self.beyond):
            near = ((points >= self.low[number]) & (points <= self.high[number])).all(axis=1)
            if without is not None:
                near &= without != number
            some = np.flatnonzero(near)
            if len(some):
                result[some] = np.maximum(result[some], -beyond(points[some]))
        return result

    def distance(self, points: Points, from_on: Numbers | float) -> tuple[Numbers, npt.NDArray[np.bool_]]:
        """The distance [m] of points (n, 3) outside from the union, and whether it is exact: it is, where it
        is `from_on` (n,) or more; elsewhere it is no more than the first value."""
        best, exact = np.full(len(points), np.inf), np.ones(len(points), dtype=bool)
        for body in self.pieces:
            if isinstance(body, Primitive):
                best = np.minimum(best, signed_distance(body, points))
        if self.hulls is not None:
            far, exact = self.hulls(points, from_on)
            exact |= best <= 0
            best = np.minimum(best, far)
        return np.maximum(best, 0.0), exact


def unit_normals(surface: Surface) -> Points:
    """(m, 3): where each triangle faces; (0, 0, 0) for one without area."""
    normals = surface.normals()
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    result: Points = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    return result
