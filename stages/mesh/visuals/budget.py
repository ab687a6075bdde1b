"""A number of triangles for the visual meshes of a link, shared among its parts by their need."""

import math
import threading
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.tessellation import PartMesh
from linkwright.stages.mesh.visuals.error import apart
from linkwright.stages.robot.model.robot import MeshRef
from linkwright.stages.show.decimate import Simplifiable, lowest

LEAST_BOUND = 2e-4
"""The error that every part may have [m]."""

BOUND_OF_SIZE = 3e-3
"""The error that a part may have, as a share of its diagonal, where that is more."""

_FINEST = 1e-6
"""The tolerance of the first level [m]; each level has twice the one before."""

_MANY = 200_000
_COARSE = 3
"""Of a part with more triangles the higher levels are made of this one, which takes a quarter of the time."""

_ENOUGH = 1 / 4
"""Below this share of the bound an error is not measured more closely."""


@dataclass(frozen=True, slots=True)
class Decimation:
    """What became of a link's visual meshes: triangles before and after, the largest `error` [m] of a part
    (at least as large as the distance of the surfaces), and whether fewer triangles would have been too far
    away."""

    before: int
    after: int
    error: float
    limited: bool


class Decimator:
    """Decimates parts, each once for each level, however many links have it, for any thread."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._made: dict[tuple[MeshRef, int], PartMesh | None] = {}
        self._errors: dict[tuple[MeshRef, int], float] = {}
        self._top: dict[MeshRef, int] = {}
        self._solids: dict[tuple[MeshRef, bool], Simplifiable] = {}

    def fitted(
        self, uses: Iterable[MeshRef], meshes: Mapping[MeshRef, PartMesh], most: int
    ) -> tuple[dict[MeshRef, PartMesh], Decimation | None]:
        """The parts of a link with at most `most` triangles together, counting each use, or with the fewest
        that the bound of each part allows; None where they have no more to begin with.

        All parts have one tolerance, as far as it is within their bounds: triangles go where the surface
        needs them.
        """
        counts = Counter(ref for ref in uses if ref in meshes)
        before = sum(len(meshes[ref].surface.triangles) * count for ref, count in counts.items())
        if before <= most:
            return dict(meshes), None
        for ref in counts:
            # Of a textured part the image would shift on the surface: it keeps its triangles.
            self._top.setdefault(ref, -1 if meshes[ref].textures else _levels(meshes[ref].surface) - 1)

        def faces(level: int) -> int:
            found = (len(self._at(ref, meshes[ref], level).surface.triangles) for ref in counts)
            return sum(one * count for one, count in zip(found, counts.values(), strict=True))

        while True:
            level = lowest(1 + max(self._top[ref] for ref in counts), faces, most)
            chosen = {ref: self._at(ref, meshes[ref], level) for ref in counts}
            # Of all of them, so that the parts that are too far away all get a lower level at once.
            holding = [self._holds(ref, meshes[ref], level) for ref in counts]
            if all(holding):
                break
        # They are large, and seldom of use for another link.
        with self._lock:
            self._solids.clear()
        after = sum(len(chosen[ref].surface.triangles) * count for ref, count in counts.items())
        error = max(self._errors.get((ref, min(level, self._top[ref])), 0.0) for ref in counts)
        return {**meshes, **chosen}, Decimation(before, after, error, after > most)

    def lighter(self, ref: MeshRef, mesh: PartMesh, moved: float) -> PartMesh:
        """The part with fewer triangles, its surface moved by at most about `moved` [m]; itself where it
        cannot have fewer."""
        # A surface moves up to twice as far as it is told.
        return self._made_at(ref, mesh, int(math.log2(moved / 2 / _FINEST))) or mesh

    def _at(self, ref: MeshRef, mesh: PartMesh, level: int) -> PartMesh:
        """The part at a level, or at its last one; the part itself where it has none."""
        level = min(level, self._top[ref])
        if level < 0:
            return mesh
        made = self._made_at(ref, mesh, level)
        if made is None:
            self._top[ref] = -1
        return made or mesh

    def _made_at(self, ref: MeshRef, mesh: PartMesh, level: int) -> PartMesh | None:
        """The part at a level, itself where it would have no fewer triangles; None where it has no levels."""
        with self._lock:
            if (ref, level) not in self._made:
                large = level > _COARSE and len(mesh.surface.triangles) > _MANY
                made = simplified(mesh, self._solid(ref, mesh, large), _FINEST * 2.0**level)
                fewer = made is None or len(made.surface.triangles) < len(mesh.surface.triangles)
                self._made[ref, level] = made if fewer else mesh
            return self._made[ref, level]

    def _solid(self, ref: MeshRef, mesh: PartMesh, coarse: bool) -> Simplifiable:
        if (ref, coarse) not in self._solids:
            start = (self._made_at(ref, mesh, _COARSE) if coarse else None) or mesh
            self._solids[ref, coarse] = Simplifiable.of(start.surface, start.colours, len(start.palette))
        return self._solids[ref, coarse]

    def _holds(self, ref: MeshRef, mesh: PartMesh, level: int) -> bool:
        """Whether the part is within its bound at a level; if not, its last level is a lower one."""
        level = min(level, self._top[ref])
        if level < 0:
            return True
        if self._error(ref, mesh, level) <= bound(mesh.surface):
            return True
        # Where even the first level is too far away the mesh is no sound surface, and no level helps.
        self._top[ref] = level - 1 if self._error(ref, mesh, 0) <= bound(mesh.surface) else -1
        return False

    def _error(self, ref: MeshRef, mesh: PartMesh, level: int) -> float:
        made = self._at(ref, mesh, level)
        if (ref, level) not in self._errors:
            most = bound(mesh.surface)
            self._errors[ref, level] = 0.0 if made is mesh else apart(mesh, made, _ENOUGH * most, most)
        return self._errors[ref, level]


def simplified(mesh: PartMesh, solid: Simplifiable, tolerance: float) -> PartMesh | None:
    """The part, its surface moved by about `tolerance` [m] at most; None where it cannot be simplified."""
    made = solid.simplified(tolerance)
    return made and replace(mesh, surface=made[0], colours=made[1])


def bound(surface: Surface) -> float:
    """How far [m] the surface of a part may move."""
    return max(LEAST_BOUND, BOUND_OF_SIZE * surface.diagonal)


def _levels(surface: Surface) -> int:
    """How many levels have a tolerance within the bound."""
    return 1 + int(math.log2(bound(surface) / _FINEST))
