"""A part made ready to be compared with colliders."""

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

SAMPLES = 3000
_GRID = 1 / 100  # of the diagonal
_TANGLE = 10  # where it takes seconds; parts of robots have less than 1


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """A part: its triangles in a tree, what is inside, and points all over it.

    `diagonal` [m] of its bounds; `volume` [m³] of the union of its solids, 0 where it is not closed;
    `solid`: None where booleans with it are not possible.
    """

    surface: Surface
    diagonal: float
    closed: bool
    volume: float
    tree: BoxTree
    nearest: Nearest
    inside: Inside
    samples: Samples
    corners: Points
    solid: Solid | None
    _cloud: list[Cloud] = field(default_factory=list)

    @staticmethod
    def of(surface: Surface) -> "Target":
        """Of a surface with at least one triangle, closed or not; ValueError where it has no extent, or its
        faces are a tangle: where many lie across each other everywhere, no order of them helps."""
        used = surface.vertices[np.unique(surface.triangles)] if len(surface.triangles) else np.zeros((1, 3))
        diagonal = float(np.linalg.norm(np.ptp(used, axis=0)))
        if not diagonal > 0 or not np.isfinite(used).all():
            msg = "there is nothing to measure: the surface has no extent, or not all of it is finite"
            raise ValueError(msg)
        tree = BoxTree.of(surface)
        if _overlap(tree) > _TANGLE:
            msg = "the mesh is a tangle: its faces lie across each other in too many places to measure"
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
            even(tree.corners, SAMPLES),
            thinned(Surface(used, surface.triangles), _GRID * diagonal),
            solid,
        )

    def shares(self, union: Union) -> Shares:
        """What the collider has too much and too little: by booleans where they are possible."""
        found = self.solid.shares(union) if self.solid else None
        if found is not None:
            return found
        if not self._cloud:
            self._cloud.append(Cloud.of(self.surface, self.inside))
        return self._cloud[0].shares(union)


def _overlap(tree: BoxTree) -> float:
    """In how many of the boxes around single triangles a place is, on average."""
    lows, highs = tree.boxes[0]
    whole = np.maximum(highs.max(axis=0) - lows.min(axis=0), 1e-9 * tree.diagonal)
    return float(np.prod(np.maximum(highs - lows, 1e-9 * tree.diagonal) / whole, axis=1).sum())


def _solids(surface: Surface) -> Sequence[Surface]:
    """The solids of a closed surface, which may overlap."""
    return clean(surface).solids if len(Shells.of(surface).closed) > 1 else (surface,)
