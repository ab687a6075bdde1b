"""Prepares a part for comparison with its colliders."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.measure.samples import Samples, evenly_spread, one_per_cell
from linkwright.stages.mesh.measure.tree import BoxTree, Nearest
from linkwright.stages.mesh.measure.union import PieceUnion
from linkwright.stages.mesh.measure.volumes import Cloud, Shares, Solid
from linkwright.stages.mesh.surfaces.clean import clean
from linkwright.stages.mesh.surfaces.inside import InsideTest
from linkwright.stages.mesh.surfaces.shells import Shells

SAMPLE_COUNT = 3000
"""Number of points on the part."""

_CELL_SHARE = 1 / 100
"""Size of the grid's cells, as a share of the diagonal."""

_MAX_BOXES_PER_POINT = 10
"""Largest `_mean_boxes_per_point` of a part that is measured: beyond it, measuring takes seconds. Usual parts
have less than 1."""

_MIN_SIDE_SHARE = 1e-9
"""Smallest side of a box in `_mean_boxes_per_point`, as a share of the diagonal: a flat box has no volume to
divide by."""


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredPart:
    """A part that is prepared for comparison with colliders."""

    surface: Surface
    diagonal: float
    """Diagonal of the bounding box [m]."""
    closed: bool
    """Whether the surface is closed."""
    volume: float
    """Volume of the union of the part's solids [m³]; 0 if it is not closed."""
    tree: BoxTree
    """Triangles of the part."""
    nearest: Nearest
    """Distances from the surface."""
    inside: InsideTest
    """Test whether points are inside."""
    samples: Samples
    """Points spread evenly over the surface."""
    corners: Points
    """Vertices of the surface, at most one in each cell of a grid."""
    solid: Solid | None
    """The part for boolean operations; None if they are impossible."""
    _cloud: list[Cloud] = field(default_factory=list)
    """Points in the part's box, once `shares` needs them; a list, since the class is frozen."""

    @staticmethod
    def of(surface: Surface) -> "MeasuredPart":
        """Prepares a surface, closed or not. Raises ValueError if it has no extent, or if its faces overlap
        so much that no tree of boxes is fast."""
        used_vertices = (
            surface.vertices[np.unique(surface.triangles)] if len(surface.triangles) else np.zeros((1, 3))
        )
        diagonal = float(np.linalg.norm(np.ptp(used_vertices, axis=0)))
        if not diagonal > 0 or not np.isfinite(used_vertices).all():
            msg = "the surface cannot be measured: it has no extent, or coordinates that are not finite"
            raise ValueError(msg)
        tree = BoxTree.of(surface)
        if _mean_boxes_per_point(tree) > _MAX_BOXES_PER_POINT:
            msg = "the surface cannot be measured: too many of its faces overlap"
            raise ValueError(msg)
        closed = surface.is_closed()
        solid = Solid.of(_solids(surface)) if closed else None
        return MeasuredPart(
            surface,
            diagonal,
            closed,
            solid.volume if solid else surface.volume(),
            tree,
            Nearest.of(tree),
            InsideTest.of(surface),
            evenly_spread(tree.corners, SAMPLE_COUNT),
            one_per_cell(Surface(used_vertices, surface.triangles), _CELL_SHARE * diagonal),
            solid,
        )

    def shares(self, union: PieceUnion) -> Shares:
        """Returns the volume of a collider outside the part, and of the part outside the collider, as shares
        of the part's volume. They are computed by boolean operations if possible, else by sampling."""
        shares = self.solid.shares(union) if self.solid else None
        if shares is not None:
            return shares
        if not self._cloud:
            self._cloud.append(Cloud.of(self.surface, self.inside))
        return self._cloud[0].shares(union)


def _mean_boxes_per_point(tree: BoxTree) -> float:
    """Returns the average number of triangles whose boxes contain a point of the part's box."""
    lows, highs = tree.boxes[0]
    min_side = _MIN_SIDE_SHARE * tree.diagonal
    part_sides = np.maximum(highs.max(axis=0) - lows.min(axis=0), min_side)
    return float(np.prod(np.maximum(highs - lows, min_side) / part_sides, axis=1).sum())


def _solids(surface: Surface) -> Sequence[Surface]:
    """Returns the solids of a closed surface, which may overlap."""
    return clean(surface).solids if len(Shells.of(surface).closed) > 1 else (surface,)
