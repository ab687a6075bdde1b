"""Shares a number of triangles among the visual meshes of a link's parts, by their need."""

import math
import threading
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.part_mesh import PartMesh
from linkwright.stages.mesh.visuals.error import hausdorff_bound
from linkwright.stages.robot.model.robot import MeshRef
from linkwright.stages.show.decimate import Simplifiable, lowest_level

MIN_BOUND = 2e-4
"""Error [m] that every part may have, however small the part is."""

BOUND_SHARE = 3e-3
"""Error that a part may have, as a share of its diagonal, if that is more."""

_FIRST_TOLERANCE = 1e-6
"""Tolerance [m] of the first level; each further level has twice the tolerance of the one before."""

_MAX_FINE_TRIANGLES = 200_000
_COARSE_LEVEL = 3
"""For a part with more triangles than that, the levels above this one are made from this one, which takes a
quarter of the time."""

_NEGLIGIBLE_SHARE = 1 / 4
"""Share of the bound below which an error is not measured exactly."""


@dataclass(frozen=True, slots=True)
class Decimation:
    """The decimation of a link's visual meshes."""

    before: int
    """Number of triangles before decimation."""
    after: int
    """Number of triangles after decimation."""
    error: float
    """Largest error [m] of a part: an upper bound of the distance of its surfaces before and after."""
    limited: bool
    """Whether the bound of the error kept more triangles than were allowed."""


class Decimator:
    """Decimator of parts that threads may share: it makes each level of a part once, for all links."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._levels_of_parts: dict[tuple[MeshRef, int], PartMesh | None] = {}
        self._errors: dict[tuple[MeshRef, int], float] = {}
        self._last_level: dict[MeshRef, int] = {}
        self._simplifiables: dict[tuple[MeshRef, bool], Simplifiable] = {}

    def fitted(
        self, uses: Iterable[MeshRef], meshes: Mapping[MeshRef, PartMesh], max_triangles: int
    ) -> tuple[dict[MeshRef, PartMesh], Decimation | None]:
        """Returns the parts of a link with at most `max_triangles` triangles together, counting each use, or
        with the fewest that the bound of each part allows. The decimation is None if they have no more than
        `max_triangles` to begin with.

        All parts have the same tolerance, as far as it is within their bounds, so that triangles go where
        the surface needs them.
        """
        counts = Counter(ref for ref in uses if ref in meshes)
        before = sum(len(meshes[ref].surface.triangles) * count for ref, count in counts.items())
        if before <= max_triangles:
            return dict(meshes), None
        for ref in counts:
            # The image of a textured part would shift on the surface: such a part keeps its triangles.
            self._last_level.setdefault(ref, -1 if meshes[ref].textures else _levels(meshes[ref].surface) - 1)

        def faces_at(level: int) -> int:
            triangles = (len(self._at_level(ref, meshes[ref], level).surface.triangles) for ref in counts)
            return sum(number * count for number, count in zip(triangles, counts.values(), strict=True))

        while True:
            level = lowest_level(1 + max(self._last_level[ref] for ref in counts), faces_at, max_triangles)
            decimated_parts = {ref: self._at_level(ref, meshes[ref], level) for ref in counts}
            # Not `all` over a generator: all parts that are too far away get a lower level at once.
            within_bounds = [self._check_bound(ref, meshes[ref], level) for ref in counts]
            if all(within_bounds):
                break
        # Simplifiable parts are large, and seldom of use for another link.
        with self._lock:
            self._simplifiables.clear()
        after = sum(len(decimated_parts[ref].surface.triangles) * count for ref, count in counts.items())
        error = max(self._errors.get((ref, min(level, self._last_level[ref])), 0.0) for ref in counts)
        return {**meshes, **decimated_parts}, Decimation(before, after, error, after > max_triangles)

    def decimated(self, ref: MeshRef, mesh: PartMesh, max_move: float) -> PartMesh:
        """Returns the part with fewer triangles, its surface moved by at most about `max_move` [m]; the part
        itself if it cannot have fewer."""
        # A surface moves up to twice as far as the tolerance.
        return self._part_at(ref, mesh, int(math.log2(max_move / 2 / _FIRST_TOLERANCE))) or mesh

    def _at_level(self, ref: MeshRef, mesh: PartMesh, level: int) -> PartMesh:
        """Returns the part at a level, or at its last level; the part itself if it has no levels."""
        level = min(level, self._last_level[ref])
        if level < 0:
            return mesh
        decimated = self._part_at(ref, mesh, level)
        if decimated is None:
            self._last_level[ref] = -1
        return decimated or mesh

    def _part_at(self, ref: MeshRef, mesh: PartMesh, level: int) -> PartMesh | None:
        """Returns the part at a level, or the part itself if it would have no fewer triangles; None if it has
        no levels."""
        with self._lock:
            if (ref, level) not in self._levels_of_parts:
                is_large = level > _COARSE_LEVEL and len(mesh.surface.triangles) > _MAX_FINE_TRIANGLES
                decimated = simplified(
                    mesh, self._simplifiable(ref, mesh, is_large), _FIRST_TOLERANCE * 2.0**level
                )
                fewer = decimated is None or len(decimated.surface.triangles) < len(mesh.surface.triangles)
                self._levels_of_parts[ref, level] = decimated if fewer else mesh
            return self._levels_of_parts[ref, level]

    def _simplifiable(self, ref: MeshRef, mesh: PartMesh, coarse: bool) -> Simplifiable:
        if (ref, coarse) not in self._simplifiables:
            start = (self._part_at(ref, mesh, _COARSE_LEVEL) if coarse else None) or mesh
            self._simplifiables[ref, coarse] = Simplifiable.of(
                start.surface, start.colours, len(start.palette)
            )
        return self._simplifiables[ref, coarse]

    def _check_bound(self, ref: MeshRef, mesh: PartMesh, level: int) -> bool:
        """Tells whether the part is within its bound of error at a level; if not, lowers the part's last
        level."""
        level = min(level, self._last_level[ref])
        if level < 0:
            return True
        if self._error(ref, mesh, level) <= bound(mesh.surface):
            return True
        # If even the first level is too far away, the mesh is no sound surface, and no level helps.
        self._last_level[ref] = level - 1 if self._error(ref, mesh, 0) <= bound(mesh.surface) else -1
        return False

    def _error(self, ref: MeshRef, mesh: PartMesh, level: int) -> float:
        decimated = self._at_level(ref, mesh, level)
        if (ref, level) not in self._errors:
            largest = bound(mesh.surface)
            self._errors[ref, level] = (
                0.0
                if decimated is mesh
                else hausdorff_bound(mesh, decimated, _NEGLIGIBLE_SHARE * largest, largest)
            )
        return self._errors[ref, level]


def simplified(mesh: PartMesh, simplifiable: Simplifiable, tolerance: float) -> PartMesh | None:
    """Returns the part with its surface moved by at most about `tolerance` [m]; None if that is
    impossible."""
    result = simplifiable.simplified(tolerance)
    return result and replace(mesh, surface=result[0], colours=result[1])


def bound(surface: Surface) -> float:
    """Returns how far [m] the surface of a part may move."""
    return max(MIN_BOUND, BOUND_SHARE * surface.diagonal)


def _levels(surface: Surface) -> int:
    """Returns the number of levels with a tolerance within the bound."""
    return 1 + int(math.log2(bound(surface) / _FIRST_TOLERANCE))
