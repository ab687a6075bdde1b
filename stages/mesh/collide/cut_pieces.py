"""Convex pieces of a part: it is cut by planes until little stands out of it, then pieces are joined again.

Each side of a cut takes the hull of its triangles: a surface with holes needs no repair, and none of it is
bare. Cuts of what is closed are closed, so that pieces leave no gap inside either.
With a tolerance of 2 mm all 14 parts of the sample that need pieces are within it, a sleeve too that has 16
of CoACD 1.0.14's at 1.01 tolerances; of 43 of so101 and open_duck two are not, at 1.14 and 1.15 tolerances.
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
from linkwright.stages.mesh.cut.cutting import cuts, in_sectors, slicer
from linkwright.stages.mesh.cut.piece import cloud_of, whole_hull
from linkwright.stages.mesh.decompose.seams import containing_hull
from linkwright.stages.mesh.measure import even
from linkwright.stages.mesh.measure.field import Field
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.pieces import Distances, Piece, beyond_piece, surface_of, vertices
from linkwright.stages.mesh.surfaces.snapping import on_grid, snapped

Numbers = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

MOST_PIECES = 16
"""How many pieces a part has at most."""

TRIED: dict[str, int] = {"low": 2, "normal": 4, "high": 12}
"""By `mesh.effort`: how many planes, the best by a rough look, are tried for each cut."""

_MOST_CUT = 40
"""Pieces before any are joined: of a slot or a hole there have to be more at first."""

_POINTS, _ROUGHLY = 400, 150
"""On a piece, and on one that is only looked at."""

_COUNTS = 0.3
"""What stands out by so many tolerances counts, by what is more."""

_FEW, _FAR = 0.04, 2.7
"""Cutting ends where no more of the outer surface stands out by more than the tolerance, nor any of it by so
many: 5 % and 3 are allowed, and points do not tell all."""

_ASIDE = 0.1
"""How far from a flat face a plane lies, in tolerances."""

_PAIRS = 8
"""How many pairs of pieces, those whose common hull adds the least volume, are compared to join two."""

_SEAM = 3e-4  # of the diagonal: nothing reaches between pieces that are as near
_MANY, _PITCH = 150, 0.1
"""Of a hull with more corners those are compared that a grid of this pitch, in tolerances, tells apart."""

_LOOK = 2000  # points of a quick no
_CLOUD = 16
"""Cells along the diagonal of a piece, of each of which a point shows where a plane would cut it."""

_DIGITS = 9


@dataclass(frozen=True, slots=True)
class Cut:
    """Pieces, and whether they are near enough."""

    pieces: tuple[Piece, ...]
    near: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """`soup`: triangles of a part; `hull`: around them, with all corners; `points` (n, 3) on it, how `far`
    each is out of the part, in tolerances, and the `area` that each stands for [m²]. `given`: the piece that
    it is, where it was not made here."""

    soup: Surface
    hull: Surface
    volume: float
    points: Points
    far: Numbers
    area: float
    beyond: Distances
    low: Points
    high: Points
    given: Piece | None = None

    def cost(self, alone: Flags | None = None) -> float:
        """By how much it stands out, times the area [m²], of the points that are `alone`."""
        return self.area * _excess(self.far if alone is None else self.far[alone])


class PieceCutter:
    """Cuts and joins the pieces of one part."""

    def __init__(self, judge: Judge, max_vertices: int, effort: str = "normal") -> None:
        self._judge, self._max_vertices, self._tried = judge, max_vertices, TRIED[effort]
        self._far = Field.of(judge.target, judge.tolerance)
        self._seam = _SEAM * judge.target.diagonal
        self._unit = judge.surface.area()
        self._within: dict[tuple[_Part, _Part], Flags | None] = {}
        self._made: dict[_Part, Piece] = {}

    def cut(self) -> Cut:
        """The fewest pieces that are near enough; where none are, 16 that are as near as may be."""
        whole = self._judge.surface
        made = [self.join(self._cut(self._parts([whole])))]
        for sectors in in_sectors(whole):
            if made[-1].near:
                break
            made.append(self.join(self._cut(self._parts(sectors))))
        found = [one for one in made if one.near] or [one for one in made if one.pieces]
        return min(found, key=self._miss, default=Cut((), near=False)) if len(found) != 1 else found[0]

    def parts_of(self, pieces: Sequence[Piece]) -> list[_Part]:
        """Pieces that others made, to join."""
        few = [piece if vertices(piece) <= self._max_vertices else None for piece in pieces]
        surfaces = map(surface_of, pieces)
        return [self._part(surface, surface, piece) for surface, piece in zip(surfaces, few, strict=True)]

    def join(self, parts: Sequence[_Part], most: int | None = None) -> Cut:
        """As few pieces, at most so many (16), as are near enough: two after two are joined whose common hull
        stands out least; where none are near enough, the most."""
        states = [[*parts]]
        hulls: dict[tuple[_Part, _Part], tuple[float, Surface | None]] = {}
        while len(states[-1]) > 1 and (made := self._joined(states[-1], hulls)):
            states.append(made)
        allowed = [state for state in states if len(state) <= (most or MOST_PIECES)]
        if not allowed:
            return Cut((), near=False)
        best, low, high = Cut(self._pieces(allowed[0]), near=False), 0, len(allowed) - 1
        while low <= high:
            middle = (low + high) // 2
            here = self._pieces(allowed[middle])
            if self._near(here):
                best, low = Cut(here, near=True), middle + 1
            else:
                high = middle - 1
        return best

    def _near(self, pieces: Sequence[Piece]) -> bool:
        return bool(pieces) and not self._judge.hopeless(pieces, points=_LOOK) and self._judge.near(pieces)

    def _miss(self, made: Cut) -> float:
        return miss(self._judge.measure(made.pieces), self._judge.tolerance)

    def _pieces(self, parts: Sequence[_Part]) -> tuple[Piece, ...]:
        for part in parts:
            if part not in self._made:
                piece = part.given or snapped(containing_hull(part.hull, self._max_vertices))
                self._made[part] = piece
        return tuple(sorted((self._made[part] for part in parts), key=_order))

    def _part(self, soup: Surface, hull: Surface, given: Piece | None = None) -> _Part:
        plain = hull
        if len(hull.vertices) > _MANY:
            plain = convex_hull(on_grid(hull.vertices, _PITCH * self._judge.tolerance)) or hull
        points = even(plain.corners, _POINTS).points
        area, beyond = plain.area() / _POINTS, beyond_piece(plain)
        low, high = hull.vertices.min(axis=0), hull.vertices.max(axis=0)
        return _Part(soup, hull, hull.volume(), points, self._far(points), area, beyond, low, high, given)

    def _parts(self, soups: Sequence[Surface]) -> list[_Part]:
        """Those of the soups that span a volume."""
        hulls = [whole_hull(soup.vertices) for soup in soups]
        return [self._part(soup, hull) for soup, hull in zip(soups, hulls, strict=True) if hull is not None]

    def _alone(self, part: _Part, parts: Sequence[_Part]) -> Flags:
        """Which points of a piece are on the outer surface of all."""
        found = np.ones(len(part.points), dtype=bool)
        for other in parts:
            if other is not part and (within := self._points_within(part, other)) is not None:
                found &= ~within
        return found

    def _points_within(self, part: _Part, other: _Part) -> Flags | None:
        """Which points of a piece are in another, or at it; None where none are."""
        if (part, other) not in self._within:
            found: Flags | None = None
            if self._touch(part, other):
                low, high = other.low - self._seam, other.high + self._seam
                near: Flags = np.all((part.points >= low) & (part.points <= high), axis=1)
                some = np.flatnonzero(near)
                near[some] = other.beyond(part.points[some]) <= self._seam
                found = near if near.any() else None
            self._within[part, other] = found
        return self._within[part, other]

    def _touch(self, one: _Part, other: _Part) -> bool:
        """Whether the boxes around two pieces do."""
        return bool((one.low <= other.high + self._seam).all() and (other.low <= one.high + self._seam).all())

    def _enough(self, parts: Sequence[_Part]) -> bool:
        """Whether the pieces are near enough, as their points tell."""
        area = out = most = 0.0
        for part in parts:
            far = part.far[self._alone(part, parts)]
            area += part.area * len(far)
            out += part.area * int((far > 1).sum())
            most = max(most, float(far.max(initial=0.0)))
        return out <= _FEW * area and most <= _FAR

    def _cut(self, parts: Sequence[_Part]) -> list[_Part]:
        """Cuts the piece that stands out most, again and again."""
        now = [*parts]

        def costs(parts: list[_Part]) -> list[float]:
            return [round(part.cost(self._alone(part, parts)) / self._unit, _DIGITS) for part in parts]

        for now in cuts(parts, costs, self._halves):
            if len(now) >= _MOST_CUT or self._enough(now):
                break
        return now

    def _halves(self, part: _Part) -> list[_Part]:
        """The sides of the best plane; what is no longer in the way of a hull's volume counts less, so that
        what is whole is cut off first."""
        cloud, axes = cloud_of(part.soup, _CLOUD), planes.axes_of(part.soup)
        faces = planes.flat_faces(part.soup, _ASIDE * self._judge.tolerance)
        every = planes.crossing(iter([*faces, *planes.through(axes, cloud)]), cloud)
        unit = self._unit * part.volume

        def roughly(*sides: Points) -> float:
            hulls = [hull for side in sides if (hull := whole_hull(side)) is not None]
            return round(sum(self._rough_cost(hull) * hull.volume() for hull in hulls) / unit, _DIGITS)

        best: tuple[float, list[_Part]] = np.inf, []
        left, sliced = self._tried, slicer(part.soup)
        for _, (normal, height) in planes.ranked(every, cloud, roughly):
            if not left:
                break
            sides = sliced(normal, height)
            made = self._parts(sides)
            if len(made) < len(sides):
                continue  # a flat side would be bare
            left -= 1
            cost = round(sum(side.cost() * side.volume for side in made) / unit, _DIGITS)
            if cost < best[0]:
                best = cost, made
        return best[1]

    def _rough_cost(self, hull: Surface) -> float:
        return hull.area() / _ROUGHLY * _excess(self._far(even(hull.corners, _ROUGHLY).points))

    def _joined(
        self, parts: Sequence[_Part], hulls: dict[tuple[_Part, _Part], tuple[float, Surface | None]]
    ) -> list[_Part] | None:
        """The pieces with two of them joined. `hulls`: by how much those of two add to their volume."""
        pairs = list(itertools.combinations(parts, 2))
        pairs = [pair for pair in pairs if self._touch(*pair)] or pairs
        for one, other in pairs:
            if (one, other) not in hulls:
                hull = whole_hull(np.concatenate([one.hull.vertices, other.hull.vertices]))
                more = np.inf if hull is None else hull.volume() - one.volume - other.volume
                hulls[one, other] = round(more / self._judge.target.diagonal**3, _DIGITS), hull
        best: tuple[float, list[_Part]] | None = None
        for one, other in sorted(pairs, key=lambda pair: hulls[pair][0])[:_PAIRS]:
            hull = hulls[one, other][1]
            if hull is None:
                continue
            made = self._part(hull, hull)
            rest = [part for part in parts if part not in (one, other)]
            alone = self._alone(made, rest)
            cost = made.cost(alone) - sum(part.cost(self._alone(part, parts)) for part in (one, other))
            beyond_all = max(0.0, float(made.far[alone].max(initial=0.0)) - _FAR)
            cost = round(cost / self._unit, _DIGITS) + round(beyond_all, 3)
            if best is None or cost < best[0]:
                at = min(parts.index(one), parts.index(other))
                best = cost, [*rest[:at], made, *rest[at:]]
            if best[0] <= 0:
                break
        return best[1] if best else None


def _order(piece: Piece) -> bytes:
    return surface_of(piece).vertices.tobytes()


def _excess(far: Numbers) -> float:
    return float(np.maximum(far - _COUNTS, 0.0).sum())
