"""Cuts a part by planes into convex pieces until little stands out of it, then joins pieces again.

Each side of a cut takes the hull of its triangles, so that a surface with holes needs no repair, and no part
of it is left bare. A closed surface is cut into closed surfaces, so that pieces leave no gap inside either.
With a tolerance of 2 mm, all 14 parts of the sample that need pieces are within the tolerance, even a sleeve
for which CoACD 1.0.14 gives 16 pieces at 1.01 tolerances. Of the 43 such parts of so101 and open_duck, all
but two are within it; these miss by 1.14 and 1.15 tolerances.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.collide.acceptance import Judge, miss
from linkwright.stages.mesh.cut import planes
from linkwright.stages.mesh.cut.chunk import cloud_of, hull_surface
from linkwright.stages.mesh.cut.cutting import cuts, in_sectors, slicer
from linkwright.stages.mesh.decompose.seams import containing_hull
from linkwright.stages.mesh.measure import evenly_spread
from linkwright.stages.mesh.measure.field import Field
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.pieces import Distances, Piece, beyond_piece, surface_of, vertices
from linkwright.stages.mesh.surfaces.snapping import on_grid, snapped

Numbers = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

MAX_PIECES = 16
"""Largest number of pieces of a part."""

PLANES_BY_EFFORT: dict[str, int] = {"low": 2, "normal": 4, "high": 12}
"""`mesh.effort` → number of planes, the best by a rough test, that are tried for each cut."""

_MAX_PIECES_WHILE_CUT = 40
"""Largest number of pieces before any are joined: a slot or a hole needs more at first."""

_POINT_COUNT, _ROUGH_POINTS = 400, 150
"""Numbers of points on a piece, and on a piece that is only tested roughly."""

_MIN_EXCESS = 0.3
"""Protrusion, in tolerances, above which a point adds to the cost, by the excess."""

_MAX_FAR_SHARE, _MAX_FAR = 0.04, 2.7
"""Cutting ends when at most this share of the outer surface stands out by more than the tolerance, and no
point by more than this many tolerances. 5 % and 3 tolerances are allowed, but points do not show
everything."""

_FACE_OFFSET = 0.1
"""Distance of a plane from a flat face, in tolerances."""

_MAX_PAIRS = 8
"""Largest number of pairs that are compared to join two pieces: those whose common hull adds least volume."""

_SEAM_WIDTH = 3e-4  # of the diagonal: nothing reaches between pieces that are so near
_MAX_CORNERS, _CORNER_PITCH = 150, 0.1
"""A hull with more corners is reduced to the corners that a grid of this pitch, in tolerances, keeps."""

_QUICK_TEST_POINTS = 2000  # points of the quick test
_CELLS_ALONG_DIAGONAL = 16
"""Number of cells along the diagonal of a piece: a point in each shows where a plane would cut it."""

_DECIMALS = 9  # of costs, so that they do not depend on how a processor rounds


@dataclass(frozen=True, slots=True)
class Cut:
    """Pieces of a part, and whether they are near enough."""

    pieces: tuple[Piece, ...]
    near: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """A piece while pieces are cut and joined."""

    soup: Surface
    """Triangles of the part."""
    hull: Surface
    """Hull of the triangles, with all corners."""
    volume: float
    """Volume of the hull [m³]."""
    points: Points
    """Points on the hull (n, 3)."""
    far: Numbers
    """Distance of each point from the part, outside of it (n,), in tolerances."""
    area: float
    """Area that each point represents [m²]."""
    beyond: Distances
    """Function that returns how far points are beyond the hull."""
    low: Points
    high: Points
    """Bounds of the hull (3,) [m]."""
    original: Piece | None = None
    """The piece itself, if it was made elsewhere."""

    def cost(self, outer: Flags | None = None) -> float:
        """Returns the sum over all points, or the `outer` points, of their excess times the area [m²]."""
        return self.area * _excess(self.far if outer is None else self.far[outer])


class PieceCutter:
    """Cutter of a part, which also joins its pieces."""

    def __init__(self, judge: Judge, max_vertices: int, effort: str = "normal") -> None:
        self._judge, self._max_vertices, self._tried = judge, max_vertices, PLANES_BY_EFFORT[effort]
        self._far = Field.of(judge.target, judge.tolerance)
        self._seam = _SEAM_WIDTH * judge.target.diagonal
        self._unit = judge.surface.area()
        self._within: dict[tuple[_Part, _Part], Flags | None] = {}
        self._made: dict[_Part, Piece] = {}

    def cut(self) -> Cut:
        """Returns the fewest pieces that are near enough; if there are none, the nearest pieces, at most
        16."""
        whole = self._judge.surface
        cuts_of_starts = [self.join(self._cut(self._parts([whole])))]
        for sectors in in_sectors(whole):
            if cuts_of_starts[-1].near:
                break
            cuts_of_starts.append(self.join(self._cut(self._parts(sectors))))
        candidates = [result for result in cuts_of_starts if result.near] or [
            result for result in cuts_of_starts if result.pieces
        ]
        return (
            min(candidates, key=self._miss, default=Cut((), near=False))
            if len(candidates) != 1
            else candidates[0]
        )

    def parts_of(self, pieces: Sequence[Piece]) -> list[_Part]:
        """Prepares pieces that were made elsewhere to be joined."""
        pieces_within_limit = [piece if vertices(piece) <= self._max_vertices else None for piece in pieces]
        surfaces = map(surface_of, pieces)
        return [
            self._part(surface, surface, piece)
            for surface, piece in zip(surfaces, pieces_within_limit, strict=True)
        ]

    def join(self, parts: Sequence[_Part], max_pieces: int | None = None) -> Cut:
        """Returns the fewest pieces, at most `max_pieces` (16), that are near enough: again and again, the
        two pieces are joined whose common hull stands out least. If no state is near enough, returns the
        first with so few pieces."""
        states = [[*parts]]
        hulls: dict[tuple[_Part, _Part], tuple[float, Surface | None]] = {}
        while len(states[-1]) > 1 and (parts_after := self._joined(states[-1], hulls)):
            states.append(parts_after)
        allowed = [state for state in states if len(state) <= (max_pieces or MAX_PIECES)]
        if not allowed:
            return Cut((), near=False)
        best, low, high = Cut(self._pieces(allowed[0]), near=False), 0, len(allowed) - 1
        while low <= high:
            middle = (low + high) // 2
            pieces = self._pieces(allowed[middle])
            if self._near(pieces):
                best, low = Cut(pieces, near=True), middle + 1
            else:
                high = middle - 1
        return best

    def _near(self, pieces: Sequence[Piece]) -> bool:
        return (
            bool(pieces)
            and not self._judge.hopeless(pieces, points=_QUICK_TEST_POINTS)
            and self._judge.near(pieces)
        )

    def _miss(self, result: Cut) -> float:
        return miss(self._judge.measure(result.pieces), self._judge.tolerance)

    def _pieces(self, parts: Sequence[_Part]) -> tuple[Piece, ...]:
        for part in parts:
            if part not in self._made:
                piece = part.original or snapped(containing_hull(part.hull, self._max_vertices))
                self._made[part] = piece
        return tuple(sorted((self._made[part] for part in parts), key=_order))

    def _part(self, soup: Surface, hull: Surface, original: Piece | None = None) -> _Part:
        coarse_hull = hull
        if len(hull.vertices) > _MAX_CORNERS:
            coarse_hull = convex_hull(on_grid(hull.vertices, _CORNER_PITCH * self._judge.tolerance)) or hull
        points = evenly_spread(coarse_hull.corners, _POINT_COUNT).points
        area, beyond = coarse_hull.area() / _POINT_COUNT, beyond_piece(coarse_hull)
        low, high = hull.vertices.min(axis=0), hull.vertices.max(axis=0)
        return _Part(soup, hull, hull.volume(), points, self._far(points), area, beyond, low, high, original)

    def _parts(self, soups: Sequence[Surface]) -> list[_Part]:
        """Returns the pieces of the soups that span a volume."""
        hulls = [hull_surface(soup.vertices) for soup in soups]
        return [self._part(soup, hull) for soup, hull in zip(soups, hulls, strict=True) if hull is not None]

    def _outer(self, part: _Part, parts: Sequence[_Part]) -> Flags:
        """Tells which points of a piece are on the outer surface of all pieces."""
        outer = np.ones(len(part.points), dtype=bool)
        for other in parts:
            if other is not part and (within := self._points_within(part, other)) is not None:
                outer &= ~within
        return outer

    def _points_within(self, part: _Part, other: _Part) -> Flags | None:
        """Tells which points of a piece are inside another piece or touch it; None if there are no such
        points."""
        if (part, other) not in self._within:
            touching: Flags | None = None
            if self._touch(part, other):
                low, high = other.low - self._seam, other.high + self._seam
                within: Flags = np.all((part.points >= low) & (part.points <= high), axis=1)
                indices = np.flatnonzero(within)
                within[indices] = other.beyond(part.points[indices]) <= self._seam
                touching = within if within.any() else None
            self._within[part, other] = touching
        return self._within[part, other]

    def _touch(self, first: _Part, second: _Part) -> bool:
        """Tells whether the boxes around two pieces touch."""
        return bool(
            (first.low <= second.high + self._seam).all() and (second.low <= first.high + self._seam).all()
        )

    def _enough(self, parts: Sequence[_Part]) -> bool:
        """Tells whether the pieces are near enough, by their points."""
        area = far_area = farthest = 0.0
        for part in parts:
            far = part.far[self._outer(part, parts)]
            area += part.area * len(far)
            far_area += part.area * int((far > 1).sum())
            farthest = max(farthest, float(far.max(initial=0.0)))
        return far_area <= _MAX_FAR_SHARE * area and farthest <= _MAX_FAR

    def _cut(self, parts: Sequence[_Part]) -> list[_Part]:
        """Cuts again and again the piece that stands out most."""
        current = [*parts]

        def costs(parts: list[_Part]) -> list[float]:
            return [round(part.cost(self._outer(part, parts)) / self._unit, _DECIMALS) for part in parts]

        for current in cuts(parts, costs, self._halves):
            if len(current) >= _MAX_PIECES_WHILE_CUT or self._enough(current):
                break
        return current

    def _halves(self, part: _Part) -> list[_Part]:
        """Cuts a piece by the best plane. Costs are weighted by volume, so that solid portions are cut off
        first."""
        cloud, axes = cloud_of(part.soup, _CELLS_ALONG_DIAGONAL), planes.axes_of(part.soup)
        faces = planes.flat_faces(part.soup, _FACE_OFFSET * self._judge.tolerance)
        candidates = planes.crossing(iter([*faces, *planes.through(axes, cloud)]), cloud)
        unit = self._unit * part.volume

        def roughly(*sides: Points) -> float:
            hulls = [hull for side in sides if (hull := hull_surface(side)) is not None]
            return round(sum(self._rough_cost(hull) * hull.volume() for hull in hulls) / unit, _DECIMALS)

        best: tuple[float, list[_Part]] = np.inf, []
        left, sliced = self._tried, slicer(part.soup)
        for _, (normal, height) in planes.ranked(candidates, cloud, roughly):
            if not left:
                break
            sides = sliced(normal, height)
            parts = self._parts(sides)
            if len(parts) < len(sides):
                continue  # a flat side would be bare
            left -= 1
            cost = round(sum(side.cost() * side.volume for side in parts) / unit, _DECIMALS)
            if cost < best[0]:
                best = cost, parts
        return best[1]

    def _rough_cost(self, hull: Surface) -> float:
        points = evenly_spread(hull.corners, _ROUGH_POINTS).points
        return hull.area() / _ROUGH_POINTS * _excess(self._far(points))

    def _joined(
        self, parts: Sequence[_Part], hulls: dict[tuple[_Part, _Part], tuple[float, Surface | None]]
    ) -> list[_Part] | None:
        """Returns the pieces with two of them joined; None if none can be joined. `hulls`: pair of pieces →
        the volume that their common hull adds, and the hull."""
        pairs = list(itertools.combinations(parts, 2))
        pairs = [pair for pair in pairs if self._touch(*pair)] or pairs
        for first, second in pairs:
            if (first, second) not in hulls:
                hull = hull_surface(np.concatenate([first.hull.vertices, second.hull.vertices]))
                growth = np.inf if hull is None else hull.volume() - first.volume - second.volume
                hulls[first, second] = round(growth / self._judge.target.diagonal**3, _DECIMALS), hull
        best: tuple[float, list[_Part]] | None = None
        for first, second in sorted(pairs, key=lambda pair: hulls[pair][0])[:_MAX_PAIRS]:
            hull = hulls[first, second][1]
            if hull is None:
                continue
            joined = self._part(hull, hull)
            rest = [part for part in parts if part not in (first, second)]
            outer = self._outer(joined, rest)
            cost = joined.cost(outer) - sum(part.cost(self._outer(part, parts)) for part in (first, second))
            beyond_all = max(0.0, float(joined.far[outer].max(initial=0.0)) - _MAX_FAR)
            cost = round(cost / self._unit, _DECIMALS) + round(beyond_all, 3)
            if best is None or cost < best[0]:
                position = min(parts.index(first), parts.index(second))
                best = cost, [*rest[:position], joined, *rest[position:]]
            if best[0] <= 0:
                break
        return best[1] if best else None


def _order(piece: Piece) -> bytes:
    return surface_of(piece).vertices.tobytes()


def _excess(far: Numbers) -> float:
    return float(np.maximum(far - _MIN_EXCESS, 0.0).sum())
