"""Measures how far a collider is from a part, first at samples, then by a search between the samples."""

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.measure.samples import evenly_spread
from linkwright.stages.mesh.measure.target import SAMPLE_COUNT, MeasuredPart
from linkwright.stages.mesh.measure.tree import Indices, Numbers, Value, largest
from linkwright.stages.mesh.measure.union import PieceUnion
from linkwright.stages.mesh.surfaces.pieces import Piece
from linkwright.stages.robot.model.geometry import Measures

MAX_ERROR_SHARE = 1.5e-3
"""Largest error of a maximum, as a share of the diagonal: a tenth of the default tolerance."""

_RELATIVE_ERROR = 0.02
"""Largest error as a share of the maximum, for maxima far above the tolerance."""

_POINTS_ON_PIECES = 12_000
"""Number of points on a collider, many of which may be inside it: the 95 % quantile is then exact to a few
hundredths, and the points cost little."""

_INSIDE_TEST_SHARE = 0.3
"""Share of the points, those farthest from the part's surface, that are tested for being inside at first."""

QUICK_SAMPLE_COUNT = 300
"""Number of samples of the quick test `is_hopeless`."""

_SAMPLE_STEP = SAMPLE_COUNT // QUICK_SAMPLE_COUNT
_MAX_DEVIATIONS = 5.5
"""Largest difference of a share of points that may be chance, in standard deviations."""

_MAX_CRACK = 3e-4  # of the diagonal: nothing reaches into so narrow a crack
_CORNER_INSET = 1e-3  # share of the way from a corner to its face's centroid
_MAX_TRIANGLES = 2000  # of a piece whose corners are tried one by one
_ROUNDING = 1e-6  # of the diagonal


def measure(
    target: MeasuredPart, pieces: Sequence[Piece], protrusion: tuple[float, float] | None = None
) -> Measures:
    """Measures how the union of `pieces` differs from the part; raises ValueError without pieces.

    The winding number decides what is inside the part. A point of a piece is not on the outer surface if it
    is inside another piece, or if another piece is straight ahead within 0.03 % of the part's diagonal, so
    that seams do not count. Maxima are exact to 0.15 % of the diagonal or to a fiftieth of their value,
    shares by booleans to rounding. Distances are rounded to 1e-6 of the diagonal, shares to 1e-6.
    `protrusion`: p95 and maximum [m] of the protrusion, if they are known already.
    """
    union = PieceUnion.of(sorted(pieces, key=_order))
    if protrusion is None:
        p95, least = _protrusion(target, union)
        protrusion = p95, _farthest(target, union, least)
    shares = target.shares(union)
    grain = _ROUNDING * target.diagonal
    distances = (*protrusion, *_bareness(target, union))
    rounded = [round(value / grain) * grain for value in distances]
    extra = None if shares.extra is None else round(shares.extra, 6)
    return Measures(extra, round(shares.missing, 6), shares.by, *rounded)


def is_near(target: MeasuredPart, pieces: Sequence[Piece], tolerance: float, max_protrusion: float) -> bool:
    """Tells whether 95 % of the outer surface of `pieces` stand out by at most the tolerance [m], and all of
    it by at most `max_protrusion`, and no point of the part is further outside than the tolerance.

    The answer is that of `measure`, in a third of the time, since places that are certainly near are not
    searched.
    """
    union = PieceUnion.of(sorted(pieces, key=_order))
    p95, least = _protrusion(target, union)
    if (
        p95 > tolerance
        or least > max_protrusion
        or _farthest(target, union, _search_start(target, max_protrusion)) > max_protrusion
    ):
        return False
    return _barest(target, union, _search_start(target, tolerance)) <= tolerance


def _search_start(target: MeasuredPart, limit: float) -> float:
    """Returns the start value of a search that only has to tell whether anything is above the limit."""
    return max(0.0, min(limit - MAX_ERROR_SHARE * target.diagonal, limit / (1 + _RELATIVE_ERROR)))


def is_hopeless(
    target: MeasuredPart, pieces: Sequence[Piece], tolerance: float, points: int = QUICK_SAMPLE_COUNT
) -> bool:
    """Tells whether a sample of points already shows that the pieces miss the tolerance [m]: a point of the
    part is further outside than the tolerance, a point of the collider stands out three times as far, or more
    of the collider's points stand out than chance can explain if 5 % may (12 % of 300 points, 7.7 % of 2000).

    This is a quick test before `measure`; with 300 points it takes about a tenth of the time. It never
    rejects pieces that are well within the tolerance.
    """
    union = PieceUnion.of(sorted(pieces, key=_order))
    outer_values = _outside_union(union, target.samples.points[::_SAMPLE_STEP], tolerance)
    if (outer_values.value[outer_values.counts] > tolerance).any():
        return True
    samples = evenly_spread(union.tree.corners, points)
    triangles = samples.triangles
    _, outer = _depths_and_outer_mask(
        target.diagonal, union, samples.points, union.piece_indices[triangles], union.normals[triangles]
    )
    distances, exact = outside_part(target, samples.points[outer], tolerance)
    distances = distances[exact]
    beyond, count = int((distances > tolerance).sum()), int(outer.sum())
    max_beyond = 0.05 * count + _MAX_DEVIATIONS * (0.05 * 0.95 * count) ** 0.5
    return bool((distances > 3 * tolerance).any() or beyond > max_beyond)


def _order(piece: Piece) -> tuple[str, bytes, bytes]:
    """Returns a sort key of a piece, so that the figures do not depend on the order of the pieces."""
    if isinstance(piece, Surface):
        return "", piece.vertices.tobytes(), piece.triangles.tobytes()
    return piece.kind, np.array(piece.size).tobytes(), piece.link_from_shape.tobytes()


def _protrusion(target: MeasuredPart, union: PieceUnion) -> tuple[float, float]:
    """Returns how far [m] 95 % of the outer surface stand out at most, and the largest value of a sample."""
    samples = evenly_spread(union.tree.corners, _POINTS_ON_PIECES)
    owners, normals = union.piece_indices[samples.triangles], union.normals[samples.triangles]
    _, outer = _depths_and_outer_mask(target.diagonal, union, samples.points, owners, normals)
    points = samples.points[outer]
    bounds = target.nearest(points, np.inf)[0]
    # Points inside do not stand out. Only the farthest points matter, so points near the part need no test.
    candidates = np.argsort(-bounds, kind="stable")[: int(_INSIDE_TEST_SHARE * len(bounds)) + 1]
    bounds[candidates[target.inside(points[candidates])]] = 0.0
    tested = np.zeros(len(points), dtype=bool)
    tested[candidates] = True

    def distances(indices: Indices) -> Numbers:
        within = bounds[indices] == 0.0
        new = np.flatnonzero(~tested[indices])
        within[new] = target.inside(points[indices[new]])
        exact_distances = np.zeros(len(indices))
        exact_distances[~within], _ = target.nearest(points[indices[~within]], 0.0)
        return exact_distances

    return _tail(bounds, distances)


def _farthest(target: MeasuredPart, union: PieceUnion, least: float) -> float:
    """Returns how far [m] the outer surface stands out at most; the result is `least` or more."""

    def value(points: Points, triangles: Indices, exact_from: Numbers) -> Value:
        buried, outer = _depths_and_outer_mask(
            target.diagonal, union, points, union.piece_indices[triangles], union.normals[triangles]
        )
        distances, exact = outside_part(target, points, exact_from)
        return Value(distances, outer & exact, np.maximum(buried, 0.0))

    corners = _outer_corners(target, union)
    distances, exact = outside_part(target, corners, least)
    least = max(least, float(distances[exact].max(initial=0.0)))
    return largest(union.tree, value, least, _allowed_error(target, least))


def _depths_and_outer_mask(
    diagonal: float, union: PieceUnion, points: Points, owners: Indices, normals: Points
) -> tuple[Numbers, npt.NDArray[np.bool_]]:
    """Returns how deep points of the pieces `owners` are in other pieces, and whether the points are on the
    outer surface. `normals`: outward normals at the points."""
    if len(union.pieces) == 1:
        return np.full(len(points), -np.inf), np.ones(len(points), dtype=bool)
    buried = union.depth(points, owners)
    outer = buried <= 0
    indices = np.flatnonzero(outer)
    points_ahead = points[indices] + normals[indices] * (_MAX_CRACK * diagonal)
    outer[indices] = union.depth(points_ahead, owners[indices]) <= 0
    return buried, outer


def outside_part(
    target: MeasuredPart, points: Points, exact_from: Numbers | float
) -> tuple[Numbers, npt.NDArray[np.bool_]]:
    """Returns how far points are outside the part, and whether that is exact; see `Nearest`."""
    distances, _ = target.nearest(points, np.inf)
    exact = np.zeros(len(points), dtype=bool)
    indices = np.flatnonzero(distances >= exact_from)
    within = target.inside(points[indices])
    distances[indices[within]], exact[indices] = 0.0, True
    indices = indices[~within]
    distances[indices], _ = target.nearest(points[indices], 0.0)
    return distances, exact


def _outer_corners(target: MeasuredPart, union: PieceUnion) -> Points:
    """Returns the corners of pieces on the outer surface, judged by points of the faces near the corners."""
    corners, owners, normals = union.triangles(_MAX_TRIANGLES)
    if not len(corners):
        return corners.reshape(-1, 3)
    points = corners.reshape(-1, 3)
    inset_points = points + (np.repeat(corners.mean(axis=1), 3, axis=0) - points) * _CORNER_INSET
    _, outer = _depths_and_outer_mask(
        target.diagonal, union, inset_points, np.repeat(owners, 3), np.repeat(normals, 3, axis=0)
    )
    return np.unique(points[outer], axis=0)


def _bareness(target: MeasuredPart, union: PieceUnion) -> tuple[float, float]:
    """Returns the p95 and the maximum [m] of how far points of the part are outside the union."""
    points = target.samples.points
    bounds = _outside_union(union, points, np.inf).value
    p95, least = _tail(bounds, lambda indices: _outside_union(union, points[indices], 0.0).value)
    return p95, _barest(target, union, least)


def _barest(target: MeasuredPart, union: PieceUnion, least: float) -> float:
    """Returns how far [m] a point of the part is outside the union at most; the result is `least` or more."""

    def value(points: Points, triangles: Indices, exact_from: Numbers) -> Value:
        return _outside_union(union, points, exact_from)

    outer_values = _outside_union(union, target.corners, least)
    least = max(least, float(outer_values.value[outer_values.counts].max(initial=0.0)))
    return largest(target.tree, value, least, _allowed_error(target, least))


def _outside_union(union: PieceUnion, points: Points, exact_from: Numbers | float) -> Value:
    """Returns how far points are outside the union."""
    depth = union.depth(points)
    distances, exact = np.zeros(len(points)), np.ones(len(points), dtype=bool)
    indices = np.flatnonzero(depth <= 0)
    distances[indices], exact[indices] = union.distance(
        points[indices], np.broadcast_to(exact_from, len(points))[indices]
    )
    return Value(distances, exact, np.maximum(depth, 0.0))


def _allowed_error(target: MeasuredPart, least: float) -> float:
    return max(MAX_ERROR_SHARE * target.diagonal, _RELATIVE_ERROR * least)


def _tail(bounds: Numbers, distances: Callable[[Indices], Numbers]) -> tuple[float, float]:
    """Returns the smallest distance [m] that 95 % of the points do not exceed, and the largest distance. No
    distance is above its bound (n,). Both results are exact, although only the distances of points with large
    bounds are computed."""
    if not len(bounds):
        return 0.0, 0.0
    order = np.argsort(-bounds, kind="stable")
    beyond = len(bounds) // 20
    computed = 3 * beyond + 1
    while True:
        computed_distances = distances(order[:computed])
        p95 = float(np.sort(computed_distances)[::-1][beyond])
        if computed >= len(bounds) or p95 >= bounds[order[computed]]:
            return p95, float(computed_distances.max())
        computed = min(2 * computed, len(bounds))
