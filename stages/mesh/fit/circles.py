"""Finds the smallest ball around points, in two or three dimensions."""

import numpy as np
import numpy.typing as npt

from linkwright.stages.mesh.fit.outline import Floats

_TOLERANCE = 1e-12  # of squared distances, with points scaled into a unit ball
_MAX_ROUNDS = 1000


def smallest_ball(points: npt.NDArray[np.float64]) -> tuple[Floats, float]:
    """Returns the centre (d,) and radius of the smallest ball around points (n, d), d = 2 or 3.

    In each round, the farthest point joins the support, the points that determine the ball. The new ball is
    the smallest one through points of the support that contains all of the support, as in Gärtner's pivoting
    ("Fast and robust smallest enclosing balls", 1999).
    """
    mean = points.mean(axis=0)
    local = points - mean
    size = float(np.sqrt((local**2).sum(axis=1).max()))
    if size == 0.0:
        return mean, 0.0
    local = local / size
    support = [int((local**2).sum(axis=1).argmax())]
    centre, radius = local[support[0]], 0.0
    for _ in range(_MAX_ROUNDS):
        squares = ((local - centre) ** 2).sum(axis=1)
        farthest = int(squares.argmax())
        if squares[farthest] <= radius**2 + _TOLERANCE or farthest in support:
            break
        support, centre, radius = _smallest_ball_through(local, [*support, farthest])
    radius = float(np.sqrt(((local - centre) ** 2).sum(axis=1).max()))
    return centre * size + mean, radius * size


def _smallest_ball_through(
    points: npt.NDArray[np.float64], indices: list[int]
) -> tuple[list[int], Floats, float]:
    """Returns the smallest ball that contains the points with these `indices` and has the last of them on its
    surface: the indices of the points that determine it, its centre (d,) and its radius."""
    best: tuple[list[int], Floats, float] | None = None
    count = len(indices)
    # Each mask selects a subset of the other points.
    for mask in range(1 << count - 1):
        support = [indices[k] for k in range(count - 1) if mask >> k & 1] + indices[-1:]
        if len(support) > points.shape[1] + 1:
            continue
        centre = _circumcentre(points[support])
        squares = ((points[indices] - centre) ** 2).sum(axis=1)
        radius = float(np.sqrt(((points[support] - centre) ** 2).sum(axis=1).max()))
        if squares.max() <= radius**2 + _TOLERANCE and (best is None or radius < best[2] - _TOLERANCE):
            best = support, centre, radius
    assert best is not None
    return best


def _circumcentre(points: npt.NDArray[np.float64]) -> Floats:
    """Returns the point in the span of the points that is equally far from each."""
    edges = points[1:] - points[0]
    if not len(edges):
        return np.asarray(points[0], dtype=np.float64)
    try:
        steps = np.linalg.solve(2 * edges @ edges.T, (edges**2).sum(axis=1))
    except np.linalg.LinAlgError:  # points on a line, or twice the same
        steps = np.zeros(len(edges))
    return np.asarray(points[0] + steps @ edges, dtype=np.float64)
