"""How far two surfaces are from each other, measured at many points of either."""

import numpy as np
import numpy.typing as npt

from stages.mesh.surface import Points, Surface, compacted
from stages.mesh.tessellation import PartMesh

_SAMPLES = 10_000
"""Points of each surface beside its vertices, spread evenly by area."""

_VERTICES = 10_000
"""Vertices of a surface that are looked at; of more, evenly many by their order."""

_PIECE = 1 / 40
"""Of the size of a surface: the longest side of the pieces that its triangles are cut into for the search."""

_MOST_PIECES = 400_000
_NEAREST = 8
_BATCH = 16

# The additive recurrence of the plastic number, whose points are spread evenly (Roberts 2018).
_PLASTIC = 1.32471795724474602596


def apart(one: PartMesh, other: PartMesh, enough: float, limit: float) -> float:
    """A bound of the two-sided Hausdorff distance [m] of two meshes with one palette, colour by colour: the
    largest distance of a point of either from the surface of its colour in the other.

    Measured at vertices and at points spread evenly; infinite where a colour is on one of them only. It
    is exact between `enough` and `limit` [m]: below, it may be too large, but is at most `enough`; above
    the limit, any larger distance may be left unseen.
    """
    worst = 0.0
    for colour in range(len(one.palette)):
        first, second = _of_colour(one, colour), _of_colour(other, colour)
        if first is None and second is None:
            continue
        if first is None or second is None:
            return float("inf")
        for surface, target in ((first, second), (second, first)):
            worst = max(worst, farthest(_looked_at(surface), target, enough, limit))
            if worst > limit:
                return worst
    return worst


def _of_colour(mesh: PartMesh, colour: int) -> Surface | None:
    chosen = mesh.colours == colour
    return compacted(Surface(mesh.surface.vertices, mesh.surface.triangles[chosen])) if chosen.any() else None


def _looked_at(surface: Surface) -> Points:
    vertices = surface.vertices
    if len(vertices) > _VERTICES:
        vertices = vertices[np.linspace(0, len(vertices) - 1, _VERTICES).astype(np.int64)]
    return np.concatenate([vertices, spread(surface, _SAMPLES)])


def spread(surface: Surface, count: int) -> Points:
    """(count, 3): points on the surface, evenly by area, the same for the same surface; none where it has no
    area."""
    areas = np.linalg.norm(surface.normals(), axis=1)
    total = areas.cumsum()
    if total[-1] == 0.0:
        return np.empty((0, 3))
    steps = np.arange(count)
    chosen = np.searchsorted(total, (steps + 0.5) / count * total[-1])
    a, b, c = np.moveaxis(surface.corners[np.minimum(chosen, len(areas) - 1)], 1, 0)
    u, v = (0.5 + steps / _PLASTIC) % 1.0, (0.5 + steps / _PLASTIC**2) % 1.0
    over = u + v > 1.0
    u, v = np.where(over, 1.0 - u, u)[:, None], np.where(over, 1.0 - v, v)[:, None]
    return np.asarray(a + u * (b - a) + v * (c - a), dtype=np.float64)


def farthest(points: Points, surface: Surface, enough: float, limit: float) -> float:
    """The largest distance [m] of points (n, 3) from a surface, with `enough` and `limit` as for `apart`."""
    from scipy.spatial import cKDTree

    middles, owners, reach = _pieces(surface)
    tree = cKDTree(middles)
    # The distance from any triangles is a bound; the nearest lies within that bound and the pieces' reach.
    _, nearest = tree.query(points)
    bound = _from_triangles(points, surface, owners[nearest])
    some = np.flatnonzero(bound > enough)
    near = min(_NEAREST, len(owners))
    _, index = tree.query(points[some], list(range(1, near + 1)))
    closer = _from_triangles(np.repeat(points[some], near, axis=0), surface, owners[index.ravel()])
    bound[some] = closer.reshape(-1, near).min(axis=1)
    order = np.argsort(-bound, kind="stable")
    worst, place, batch = 0.0, 0, _BATCH
    while place < len(order):
        highest = float(bound[order[place]])
        if highest <= max(worst, enough):
            return max(worst, highest)
        some = order[place : place + batch]
        found = tree.query_ball_point(points[some], bound[some] + reach)
        rows = np.repeat(np.arange(len(some)), [len(one) for one in found])
        pairs = np.unique(np.stack([rows, owners[np.concatenate(found).astype(np.int64)]], axis=1), axis=0)
        exact = np.full(len(some), np.inf)
        np.minimum.at(exact, pairs[:, 0], _from_triangles(points[some[pairs[:, 0]]], surface, pairs[:, 1]))
        worst = max(worst, float(exact.max()))
        if worst > limit:
            return worst
        place, batch = place + batch, min(2 * batch, 256)
    return worst


def _pieces(surface: Surface) -> tuple[Points, npt.NDArray[np.int64], float]:
    """Middles (k, 3) and triangles (k,) of pieces that cover the surface, and how far [m] a piece reaches
    from its middle at most: triangles, halved across their longest side until that is short."""
    corners, owners = surface.corners, np.arange(len(surface.triangles))
    most = _PIECE * float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
    done: list[tuple[Points, npt.NDArray[np.int64]]] = []
    count, reach = len(corners), 0.0
    while len(corners):
        along = corners - np.roll(corners, -1, axis=1)
        squares = np.einsum("ijk,ijk->ij", along, along)
        widest = squares.argmax(axis=1)
        longest = np.sqrt(squares[np.arange(len(corners)), widest])
        long = (longest > most) & (count <= _MOST_PIECES)
        # No point of a triangle is farther from its middle than 2/3 of its longest side.
        reach = max(reach, 2 / 3 * float(longest[~long].max(initial=0.0)))
        done.append((corners[~long].mean(axis=1), owners[~long]))
        turned = corners[long][np.arange(long.sum())[:, None], (widest[long, None] + np.arange(3)) % 3]
        a, b, c = np.moveaxis(turned, 1, 0)
        half = (a + b) / 2
        corners = np.concatenate([np.stack([a, half, c], 1), np.stack([half, b, c], 1)])
        owners = np.concatenate([owners[long], owners[long]])
        count += int(long.sum())
    middles, triangles = (np.concatenate(list(column)) for column in zip(*done, strict=True))
    return middles, triangles, reach


def _from_triangles(
    points: Points, surface: Surface, triangles: npt.NDArray[np.int64]
) -> npt.NDArray[np.float64]:
    """(n,): the distance of each point (n, 3) from its triangle (n,).

    That of its sides, and of its plane where the point lies above the triangle: exact for slivers too.
    """
    corners = surface.corners[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.einsum("ij,ij->i", normal, normal)
    squared, above = np.full(len(points), np.inf), area > 0.0
    for start in range(3):
        side = corners[:, (start + 1) % 3] - corners[:, start]
        from_start = points - corners[:, start]
        length = np.einsum("ij,ij->i", side, side)
        along = np.einsum("ij,ij->i", from_start, side) / np.where(length > 0.0, length, 1.0)
        rest = from_start - np.clip(along, 0.0, 1.0)[:, None] * side
        squared = np.minimum(squared, np.einsum("ij,ij->i", rest, rest))
        above &= np.einsum("ij,ij->i", np.cross(side, from_start), normal) >= 0.0
    height = np.einsum("ij,ij->i", points - corners[:, 0], normal)
    with_plane = np.where(above, height**2 / np.where(above, area, 1.0), np.inf)
    return np.asarray(np.sqrt(np.minimum(squared, with_plane)), dtype=np.float64)
