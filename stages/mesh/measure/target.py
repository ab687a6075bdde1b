"""Prepares a part for comparison with colliders."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.measure.samples import Samples, even, thinned
from linkwright.stages.mesh.measure.tree import BoxTree, Nearest
from linkwright.stages.mesh.measure.union import Union
from linkwright.stages.mesh.measure.volumes import Cloud, Shares, Solid
from linkwright.stages.mesh.surfaces.clean import clean
from linkwright.stages.mesh.surfaces.inside import Inside
from linkwright.stages.mesh.surfaces.shells import Shells

SAMPLE_COUNT = 3000  # points on the part
_GRID_SHARE = 1 / 100  # of the diagonal
_MAX_OVERLAP = 10  # measuring then takes seconds; parts of robots have less than 1


@dataclass(frozen=True, slots=True, eq=False)
class Target:
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
    inside: Inside
    """Test whether points are inside."""
    samples: Samples
    """Points spread evenly over the surface."""
    corners: Points
    """Vertices of the surface, at most one in each cell of a grid."""
    solid: Solid | None
    """The part for boolean operations; None if they are impossible."""
    _cloud: list[Cloud] = field(default_factory=list)

    @staticmethod
    def of(surface: Surface) -> "Target":
        """Prepares a surface with at least one triangle, closed or not. Raises ValueError if it has no
        extent, or if so many faces cross each other everywhere that no tree of them is fast."""
        used_vertices = (
            surface.vertices[np.unique(surface.triangles)] if len(surface.triangles) else np.zeros((1, 3))
        )
        diagonal = float(np.linalg.norm(np.ptp(used_vertices, axis=0)))
        if not diagonal > 0 or not np.isfinite(used_vertices).all():
            msg = "there is nothing to measure: the surface has no extent, or not all of it is finite"
            raise ValueError(msg)
        tree = BoxTree.of(surface)
        if _overlap(tree) > _MAX_OVERLAP:
            msg = "its faces intersect each other in too many places to measure"
            raise ValueError(msg)
        closed = surface.closed()
        solid = Solid.of(_solids(surface)) if closed else None
        return Target(
            surface,
            diagonal,
            closed,
            solid.volume if solid else surface.volume(),
            tree,
            Nearest.of(tree),
            Inside.of(surface),
            even(tree.corners, SAMPLE_COUNT),
            thinned(Surface(used_vertices, surface.triangles), _GRID_SHARE * diagonal),
            solid,
        )

    def shares(self, union: Union) -> Shares:
        """Returns the volumes that a collider has too much and too little, by booleans if they are
        possible."""
        shares = self.solid.shares(union) if self.solid else None
        if shares is not None:
            return shares
        if not self._cloud:
            self._cloud.append(Cloud.of(self.surface, self.inside))
        return self._cloud[0].shares(union)


def _overlap(tree: BoxTree) -> float:
    """Returns in how many of the boxes around single triangles a place is, on average."""
    lows, highs = tree.boxes[0]
    whole = np.maximum(highs.max(axis=0) - lows.min(axis=0), 1e-9 * tree.diagonal)
    return float(np.prod(np.maximum(highs - lows, 1e-9 * tree.diagonal) / whole, axis=1).sum())


def _solids(surface: Surface) -> Sequence[Surface]:
    """Returns the solids of a closed surface, which may overlap."""
    return clean(surface).solids if len(Shells.of(surface).closed) > 1 else (surface,)
