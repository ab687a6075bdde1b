"""The measures of a collider: samples, then a search for what lies between them."""

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.measure.samples import even
from linkwright.stages.mesh.measure.target import SAMPLES, Target
from linkwright.stages.mesh.measure.tree import Indices, Numbers, Value, largest
from linkwright.stages.mesh.measure.union import Union
from linkwright.stages.mesh.surfaces.pieces import Piece
from linkwright.stages.robot.model.geometry import Measures

WITHIN = 1.5e-3
"""Of the diagonal: how far a maximum may be from the true one; a tenth of the default tolerance."""

_COARSE = 0.02
"""The same as a share of the maximum, where that is more: of one far above the tolerance."""

_ON_PIECES = 12_000
"""Points on a collider, much of which may lie within it: what 95 % of them stay within is right to a few
hundredths, and they cost little."""

_FAR_OUT = 0.3
"""The share of them, by their distance from the part's surface, that may be among the farthest outside."""

FEW = 300
_SKIPPED = SAMPLES // FEW
_SURE = 5.5
"""Standard deviations of a share of points: what is further off is no chance."""

_CRACK = 3e-4  # of the diagonal: nothing reaches into one as narrow
_INSET = 1e-3
_MOST_CORNERS = 2000  # triangles of one piece
_DIGITS = 1e-6  # of the diagonal


def measure(
    target: Target, pieces: Sequence[Piece], protrusion: tuple[float, float] | None = None
) -> Measures:
    """How the union of `pieces` (at least one) differs from the part; ValueError without pieces.

    The part's inside is what its winding number says. A point of one piece within another, or within 0.03 %
    of the part's diagonal of it straight ahead, is no point of the outer surface, so that seams do not count.
    Maxima are right to 0.15 % of the diagonal or to a fiftieth, shares by booleans to rounding; figures are
    rounded to 1e-6 of the diagonal and to 1e-6. `protrusion`: its p95 and maximum [m], where they are known.
    """
    union = Union.of(sorted(pieces, key=_order))
    if protrusion is None:
        p95, known = _protrusion(target, union)
        protrusion = p95, _farthest(target, union, known)
    shares = target.shares(union)
    grain = _DIGITS * target.diagonal
    distances = (*protrusion, *_bareness(target, union))
    rounded = [round(value / grain) * grain for value in distances]
    extra = None if shares.extra is None else round(shares.extra, 6)
    return Measures(extra, round(shares.missing, 6), shares.by, *rounded)


def near(target: Target, pieces: Sequence[Piece], tolerance: float, most: float) -> bool:
    """Whether 95 % of the outer surface of `pieces` stand out by at most the tolerance [m] and all of it by
    at most `most`, and no point of the part is further outside than the tolerance.

    As `measure` would say, in a third of its time: it looks only where something may be further off.
    """
    union = Union.of(sorted(pieces, key=_order))
    p95, known = _protrusion(target, union)
    if p95 > tolerance or known > most or _farthest(target, union, _below(target, most)) > most:
        return False
    return _barest(target, union, _below(target, tolerance)) <= tolerance


def _below(target: Target, limit: float) -> float:
    """Where a search starts that is to find whether anything is above the limit."""
    return max(0.0, min(limit - WITHIN * target.diagonal, limit / (1 + _COARSE)))


def hopeless(target: Target, pieces: Sequence[Piece], tolerance: float, points: int = FEW) -> bool:
    """Whether a look at so many points says already that the pieces miss the tolerance [m]: a point of the
    part is further outside than that, one of the collider three times as far, or more of those as far than
    chance makes of 5 % (12 % of 300 points, 7.7 % of 2000).

    A quick no before `measure`, with 300 points for about a tenth of its time; never of what is well within
    the tolerance.
    """
    union = Union.of(sorted(pieces, key=_order))
    found = _outside_union(union, target.samples.points[::_SKIPPED], tolerance)
    if (found.value[found.counts] > tolerance).any():
        return True
    samples = even(union.tree.corners, points)
    some = samples.triangles
    _, outer = _outer(target.diagonal, union, samples.points, union.owners[some], union.normals[some])
    far, exact = outside_part(target, samples.points[outer], tolerance)
    far = far[exact]
    beyond, count = int((far > tolerance).sum()), int(outer.sum())
    most = 0.05 * count + _SURE * (0.05 * 0.95 * count) ** 0.5
    return bool((far > 3 * tolerance).any() or beyond > most)


def _order(piece: Piece) -> tuple[str, bytes, bytes]:
    """Pieces in an order of their own: the same figures in whatever order they come."""
    if isinstance(piece, Surface):
        return "", piece.vertices.tobytes(), piece.triangles.tobytes()
    return piece.kind, np.array(piece.size).tobytes(), piece.link_from_shape.tobytes()


def _protrusion(target: Target, union: Union) -> tuple[float, float]:
    """What 95 % of the outer surface stand out by at most [m], and the most that a sample does."""
    samples = even(union.tree.corners, _ON_PIECES)
    owners, normals = union.owners[samples.triangles], union.normals[samples.triangles]
    _, outer = _outer(target.diagonal, union, samples.points, owners, normals)
    points = samples.points[outer]
    bounds = target.nearest(points, np.inf)[0]
    # What is inside is not far out; of what is near anyway there is no need to ask.
    some = np.argsort(-bounds, kind="stable")[: int(_FAR_OUT * len(bounds)) + 1]
    bounds[some[target.inside(points[some])]] = 0.0
    asked = np.zeros(len(points), dtype=bool)
    asked[some] = True

    def distances(chosen: Indices) -> Numbers:
        within = bounds[chosen] == 0.0
        new = np.flatnonzero(~asked[chosen])
        within[new] = target.inside(points[chosen[new]])
        far = np.zeros(len(chosen))
        far[~within], _ = target.nearest(points[chosen[~within]], 0.0)
        return far

    return _tail(bounds, distances)


def _farthest(target: Target, union: Union, known: float) -> float:
    """What any of the outer surface stands out by at most [m], where some does by `known`."""

    def value(points: Points, triangles: Indices, from_on: Numbers) -> Value:
        buried, outer = _outer(
            target.diagonal, union, points, union.owners[triangles], union.normals[triangles]
        )
        far, exact = outside_part(target, points, from_on)
        return Value(far, outer & exact, np.maximum(buried, 0.0))

    corners = _outer_corners(target, union)
    far, exact = outside_part(target, corners, known)
    known = max(known, float(far[exact].max(initial=0.0)))
    return largest(union.tree, value, known, _within(target, known))


def _outer(
    diagonal: float, union: Union, points: Points, owners: Indices, normals: Points
) -> tuple[Numbers, npt.NDArray[np.bool_]]:
    """How deep points of the pieces `owners` are in other pieces, and whether they are on the outer surface,
    which faces along the normals."""
    if len(union.pieces) == 1:
        return np.full(len(points), -np.inf), np.ones(len(points), dtype=bool)
    buried = union.depth(points, owners)
    outer = buried <= 0
    some = np.flatnonzero(outer)
    ahead = points[some] + normals[some] * (_CRACK * diagonal)
    outer[some] = union.depth(ahead, owners[some]) <= 0
    return buried, outer


def outside_part(
    target: Target, points: Points, from_on: Numbers | float
) -> tuple[Numbers, npt.NDArray[np.bool_]]:
    """How far points are outside the part, and whether that is exact; see `Nearest`."""
    far, _ = target.nearest(points, np.inf)
    exact = np.zeros(len(points), dtype=bool)
    some = np.flatnonzero(far >= from_on)
    within = target.inside(points[some])
    far[some[within]], exact[some] = 0.0, True
    some = some[~within]
    far[some], _ = target.nearest(points[some], 0.0)
    return far, exact


def _outer_corners(target: Target, union: Union) -> Points:
    """The corners of the pieces on the outer surface: those where a point of some face near by is."""
    corners, whose, normals = union.corners(_MOST_CORNERS)
    if not len(corners):
        return corners.reshape(-1, 3)
    points = corners.reshape(-1, 3)
    inset = points + (np.repeat(corners.mean(axis=1), 3, axis=0) - points) * _INSET
    _, outer = _outer(target.diagonal, union, inset, np.repeat(whose, 3), np.repeat(normals, 3, axis=0))
    return np.unique(points[outer], axis=0)


def _bareness(target: Target, union: Union) -> tuple[float, float]:
    """The p95 and the maximum [m]."""
    points = target.samples.points
    bounds = _outside_union(union, points, np.inf).value
    p95, known = _tail(bounds, lambda some: _outside_union(union, points[some], 0.0).value)
    return p95, _barest(target, union, known)


def _barest(target: Target, union: Union, known: float) -> float:
    """How far [m] a point of the part is outside the union at most, where some is by `known`."""

    def value(points: Points, triangles: Indices, from_on: Numbers) -> Value:
        return _outside_union(union, points, from_on)

    found = _outside_union(union, target.corners, known)
    known = max(known, float(found.value[found.counts].max(initial=0.0)))
    return largest(target.tree, value, known, _within(target, known))


def _outside_union(union: Union, points: Points, from_on: Numbers | float) -> Value:
    """How far points are outside the union."""
    depth = union.depth(points)
    far, exact = np.zeros(len(points)), np.ones(len(points), dtype=bool)
    some = np.flatnonzero(depth <= 0)
    far[some], exact[some] = union.distance(points[some], np.broadcast_to(from_on, len(points))[some])
    return Value(far, exact, np.maximum(depth, 0.0))


def _within(target: Target, known: float) -> float:
    return max(WITHIN * target.diagonal, _COARSE * known)


def _tail(bounds: Numbers, distances: Callable[[Indices], Numbers]) -> tuple[float, float]:
    """The least distance [m] that 95 % of points do not exceed, and the largest. No distance is above its
    bound (n,); so both are exact, though only points that may be far are asked for theirs."""
    if not len(bounds):
        return 0.0, 0.0
    order = np.argsort(-bounds, kind="stable")
    beyond = len(bounds) // 20
    asked = 3 * beyond + 1
    while True:
        far = distances(order[:asked])
        p95 = float(np.sort(far)[::-1][beyond])
        if asked >= len(bounds) or p95 >= bounds[order[asked]]:
            return p95, float(far.max())
        asked = min(2 * asked, len(bounds))
