"""Convex pieces of a part: it is cut by planes until little stands out of it, then pieces are joined again.

Each side of a cut takes the hull of its triangles: a surface with holes needs no repair, and none of it is
bare. Deep in a solid, where three cuts meet, gaps may stay: nothing gets there.
Measured on whole robots with a tolerance of 2 mm (the sample, so101, open_duck): 91, 89 and 278 pieces in
76, 189 and 190 CPU s on a busy machine. CoACD 1.0.14 with a closed surface round open meshes, sectors of
rings and second searches made 91, 72 and 272 in 64, 153 and 133. A mesh of so101 that it left at its hull,
10 tolerances off, is within 1.02 here; a sleeve of the sample is 2.2 tolerances off here, 1.01 there.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from stages.mesh.by_contact import planes
from stages.mesh.by_contact.cutting import cut
from stages.mesh.by_contact.piece import cloud_of, whole_hull
from stages.mesh.convex_hull import convex_hull
from stages.mesh.field import Field
from stages.mesh.measure import even
from stages.mesh.pieces import Piece, beyond, half_spaces, surface_of, vertices
from stages.mesh.seams import containing_hull
from stages.mesh.snapping import on_grid, snapped
from stages.mesh.surface import Points, Surface, joined
from stages.mesh.verdict import Judge, miss

Numbers = npt.NDArray[np.float64]

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

_SECTORS = (4, 8)
"""Planes through the middle of a part with which further attempts begin: 8 and 16 sectors of a hole."""

_SEAM = 3e-4  # of the diagonal: nothing reaches between pieces that are as near
_MANY, _PITCH = 150, 0.1
"""Of a hull with more corners those are compared that a grid of this pitch, in tolerances, tells apart."""

_LOOK = 2000  # points of a quick no
_DIGITS = 9


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
    planes: tuple[Points, Numbers]
    given: Piece | None = None
    _cloud: list[Points] = field(default_factory=list)

    def cloud(self) -> Points:
        """(n, 3): points all over the triangles."""
        if not self._cloud:
            self._cloud.append(cloud_of(self.soup))
        return self._cloud[0]

    def cost(self, alone: npt.NDArray[np.bool_] | None = None) -> float:
        """By how much it stands out, times the area [m²], of the points that are `alone`."""
        return self.area * _excess(self.far if alone is None else self.far[alone])


class PieceCutter:
    """Cuts and joins the pieces of one part."""

    def __init__(self, judge: Judge, max_vertices: int, effort: str = "normal") -> None:
        self._judge, self._max_vertices, self._tried = judge, max_vertices, TRIED[effort]
        self._far = Field.of(judge.target, judge.tolerance)
        self._seam = _SEAM * judge.target.diagonal
        self._unit = judge.surface.area()

    def cut(self) -> tuple[Piece, ...]:
        """The fewest pieces that are near enough; where none are, 16 that are as near as may be."""
        whole = self._judge.surface
        made = [self.join(self._cut(self._parts([whole])))]
        for count in _SECTORS:
            if self._near(made[-1]):
                return made[-1]
            starts = [self._parts(_sectors(whole, axis, count)) for axis in range(3)]
            costs = [round(sum(self._costs(start)) / self._unit, _DIGITS) for start in starts]
            made.append(self.join(self._cut(starts[costs.index(min(costs))])))
        return min(filter(None, made), key=self._miss, default=())

    def parts_of(self, pieces: Sequence[Piece]) -> list[_Part]:
        """Pieces that others made, to join."""
        few = [piece if vertices(piece) <= self._max_vertices else None for piece in pieces]
        surfaces = map(surface_of, pieces)
        return [self._part(surface, surface, piece) for surface, piece in zip(surfaces, few, strict=True)]

    def join(self, parts: Sequence[_Part], most: int | None = None) -> tuple[Piece, ...]:
        """As few pieces, at most so many (16), as are near enough: two after two are joined whose common hull
        stands out least; where none are near enough, the most."""
        states = [[*parts]]
        growths: dict[tuple[_Part, _Part], float] = {}
        while len(states[-1]) > 1 and (made := self._joined(states[-1], growths)):
            states.append(made)
        allowed = [state for state in states if len(state) <= (most or MOST_PIECES)]
        if not allowed:
            return ()
        best, low, high = self._pieces(allowed[0]), 0, len(allowed) - 1
        while low <= high:
            middle = (low + high) // 2
            made_here = self._pieces(allowed[middle])
            if self._near(made_here):
                best, low = made_here, middle + 1
            else:
                high = middle - 1
        return best

    def _near(self, pieces: Sequence[Piece]) -> bool:
        return bool(pieces) and not self._judge.hopeless(pieces, points=_LOOK) and self._judge.near(pieces)

    def _miss(self, pieces: Sequence[Piece]) -> float:
        return miss(self._judge.measure(pieces), self._judge.tolerance)

    def _pieces(self, parts: Sequence[_Part]) -> tuple[Piece, ...]:
        made = [part.given or snapped(containing_hull(part.hull, self._max_vertices)) for part in parts]
        return tuple(sorted(made, key=lambda piece: surface_of(piece).vertices.tobytes()))

    def _part(self, soup: Surface, hull: Surface, given: Piece | None = None) -> _Part:
        plain = hull
        if len(hull.vertices) > _MANY:
            plain = convex_hull(on_grid(hull.vertices, _PITCH * self._judge.tolerance)) or hull
        points = even(plain.corners, _POINTS).points
        area, planes_of = plain.area() / _POINTS, half_spaces(plain)
        return _Part(soup, hull, hull.volume(), points, self._far(points), area, planes_of, given)

    def _parts(self, soups: Sequence[Surface]) -> list[_Part]:
        """Those of the soups that span a volume."""
        hulls = [convex_hull(soup.vertices) for soup in soups]
        return [self._part(soup, hull) for soup, hull in zip(soups, hulls, strict=True) if hull is not None]

    def _alone(self, part: _Part, others: Sequence[_Part], from_on: float = _COUNTS) -> npt.NDArray[np.bool_]:
        """Which points of a piece are on the outer surface of all, and out of the part by at least so many
        tolerances."""
        found = part.far >= from_on
        for other in others:
            if other is part:
                continue
            low, high = other.hull.vertices.min(axis=0), other.hull.vertices.max(axis=0)
            near = (part.points >= low - self._seam) & (part.points <= high + self._seam)
            some = np.flatnonzero(found & near.all(axis=1))
            if len(some):
                found[some] = beyond(*other.planes, part.points[some]) > self._seam
        return found

    def _costs(self, parts: Sequence[_Part]) -> list[float]:
        return [part.cost(self._alone(part, parts)) for part in parts]

    def _enough(self, parts: Sequence[_Part]) -> bool:
        """Whether the pieces are near enough, as their points tell."""
        area = out = most = 0.0
        for part in parts:
            far = part.far[self._alone(part, parts, 0.0)]
            area += part.area * len(far)
            out += part.area * int((far > 1).sum())
            most = max(most, float(far.max(initial=0.0)))
        return out <= _FEW * area and most <= _FAR

    def _cut(self, parts: Sequence[_Part]) -> list[_Part]:
        """Cuts the piece that stands out most, again and again."""
        now = [*parts]
        while len(now) < _MOST_CUT and not self._enough(now):
            costs = [round(cost / self._unit, _DIGITS) for cost in self._costs(now)]
            for number in sorted(range(len(now)), key=lambda number: (-costs[number], number)):
                halves = self._halves(now[number]) if costs[number] > 0 else []
                if halves:
                    now = [*now[:number], *halves, *now[number + 1 :]]
                    break
            else:
                break
        return now

    def _halves(self, part: _Part) -> list[_Part]:
        """The sides of the best plane; what is no longer in the way of a hull's volume counts less, so that
        what is whole is cut off first."""
        cloud, axes = part.cloud(), planes.axes_of(part.soup)
        faces = planes.flat_faces(part.soup, _ASIDE * self._judge.tolerance)
        ranked = []
        every = planes.crossing(iter([*faces, *planes.through(axes, cloud)]), cloud)
        for number, (normal, height) in enumerate(every):
            above = cloud @ normal > height
            hulls = [whole_hull(side) for side in (cloud[~above], cloud[above])]
            cost = sum(self._rough_cost(hull) * hull.volume() for hull in hulls if hull is not None)
            ranked.append((round(cost / (self._unit * part.volume), _DIGITS), number, (normal, height)))
        best: tuple[float, list[_Part]] = np.inf, []
        left = self._tried
        for _, _, (normal, height) in sorted(ranked, key=lambda plane: plane[:2]):
            sides = [side for side in cut(part.soup, normal, height) if len(side.triangles)]
            made = self._parts(sides)
            if not left:
                break
            if len(made) < len(sides):
                continue  # a flat side would be bare
            left -= 1
            cost = round(
                sum(side.cost() * side.volume for side in made) / (self._unit * part.volume), _DIGITS
            )
            if cost < best[0]:
                best = cost, made
        return best[1]

    def _rough_cost(self, hull: Surface) -> float:
        return hull.area() / _ROUGHLY * _excess(self._far(even(hull.corners, _ROUGHLY).points))

    def _joined(
        self, parts: Sequence[_Part], growths: dict[tuple[_Part, _Part], float]
    ) -> list[_Part] | None:
        """The pieces with two of them joined."""
        pairs = list(itertools.combinations(parts, 2))
        for one, other in pairs:
            if (one, other) not in growths:
                hull = whole_hull(np.concatenate([one.hull.vertices, other.hull.vertices]))
                more = np.inf if hull is None else hull.volume() - one.volume - other.volume
                growths[one, other] = round(more / self._judge.target.diagonal**3, _DIGITS)
        best: tuple[float, list[_Part]] | None = None
        for one, other in sorted(pairs, key=lambda pair: growths[pair])[:_PAIRS]:
            both = joined([one.soup, other.soup])
            for made in self._parts([both]):
                rest = [part for part in parts if part not in (one, other)]
                alone = self._alone(made, rest)
                cost = made.cost(alone) - sum(part.cost(self._alone(part, parts)) for part in (one, other))
                beyond_all = max(0.0, float(made.far[alone].max(initial=0.0)) - _FAR)
                cost = round(cost / self._unit, _DIGITS) + round(beyond_all, 3)
                if best is None or cost < best[0]:
                    at = min(parts.index(one), parts.index(other))
                    best = cost, [*rest[:at], made, *rest[at:]]
            if best is not None and best[0] <= 0:
                break
        return best[1] if best else None


def _excess(far: Numbers) -> float:
    return float(np.maximum(far - _COUNTS, 0.0).sum())


def _sectors(surface: Surface, axis: int, count: int) -> list[Surface]:
    """A surface cut by so many planes through the middle of its box along an axis."""
    middle = (surface.vertices.min(axis=0) + surface.vertices.max(axis=0)) / 2
    first, second = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
    found = [surface]
    for turn in np.pi * np.arange(count) / count:
        normal = np.cos(turn) * first + np.sin(turn) * second
        sides = (side for part in found for side in cut(part, normal, float(normal @ middle)))
        found = [side for side in sides if len(side.triangles)]
    return found
