"""Approximates a part by a union of spheres."""

import numpy as np
import numpy.typing as npt
import scipy

from linkwright.stages.formats.meshes.surface import Points
from linkwright.stages.mesh.fit.outline import Floats, Outline
from linkwright.stages.robot.model.poses import from_parts
from linkwright.stages.robot.model.robot import Primitive, frozen

_TARGET_CENTRES = 700
_TARGET_POINTS = 2500
"""Numbers of candidates for centres, and of points that the spheres must cover; at most twice as many."""

_MAX_ROUNDS = 30
_PROTRUSION_SHARE = 0.85
_BARENESS_SHARE = 0.75
"""Protrusion and bareness that are allowed at points, as shares of the tolerance, since the points are not
the whole surface."""

_GROWTH = 1.25
"""Factor by which the tolerance grows while too many spheres are needed, and a grid's cells while they keep
too many points."""

_DECIMALS = 12
"""Decimals [m] of radii and centres, so that they do not depend on how a processor rounds."""


def spheres(outline: Outline, closed: bool, tolerance: float, max_spheres: int) -> tuple[Primitive, ...]:
    """Returns at most `max_spheres` spheres. Their union stands out of a part, and leaves it bare, by at most
    `tolerance` [m], or by as little more as so few spheres allow.

    Each sphere is a ball inside the part that touches its surface in two places or more, grown by the
    tolerance, so that it stands out by no more than that. Spheres are chosen greedily: next is the one that
    covers most of the surface that is still bare. If the surface is not `closed`, spheres are centred on it.
    """
    surface_spots, owners = _surface_spots(outline)
    centres, radii = surface_spots, np.zeros(len(surface_spots))
    if closed:
        centres, radii = _inner_balls(outline, surface_spots, outline.normals[owners])
    surface = np.concatenate([outline.tree.data, outline.triangles.reshape(-1, 3)])
    points = surface[_spread_indices(surface, outline, _TARGET_POINTS)]
    distances = scipy.spatial.distance.cdist(points, centres) - radii
    reach = _PROTRUSION_SHARE * tolerance
    while (indices := _cover(distances <= (1 + _BARENESS_SHARE) * reach, max_spheres)) is None:
        reach *= _GROWTH
    poses = np.round(centres, _DECIMALS) + 0.0
    sizes = [round(float(radius + reach), _DECIMALS) for radius in radii]
    return tuple(Primitive("sphere", (sizes[k],), frozen(from_parts(np.eye(3), poses[k]))) for k in indices)


def _surface_spots(outline: Outline) -> tuple[Points, npt.NDArray[np.int64]]:
    """Returns points spread about evenly over the surface, and the triangle of each."""
    points = np.asarray(outline.tree.data)
    indices = _spread_indices(points, outline, _TARGET_CENTRES)
    return points[indices], outline.sample_triangles[indices]


def _spread_indices(points: Points, outline: Outline, count: int) -> npt.NDArray[np.int64]:
    """Returns the indices of at most twice `count` points, about as far apart as `count` points on the whole
    surface would be: the first point of each cell of a grid, in the order of coordinates, so that the order
    of the points does not matter."""
    order = np.lexsort(points.T[::-1])
    width = np.sqrt(outline.areas.sum() / count)
    while True:
        cells = np.floor(points[order] / width).astype(np.int64)
        _, first = np.unique(cells, axis=0, return_index=True)
        if len(first) <= 2 * count:
            return order[np.sort(first)]
        width *= _GROWTH


def _inner_balls(outline: Outline, spots: Points, normals: Points) -> tuple[Points, Floats]:
    """Returns the centres and radii of the largest balls inside the part that touch its surface at the spots.

    By shrinking balls (Ma, Bae, Choi: "3D medial axis point approximation using nearest neighbors and the
    normal field", 2012): a ball behind a spot shrinks until the spot is the point of the surface nearest to
    its centre.
    """
    radii = np.full(len(spots), outline.size / 2)
    active = np.arange(len(spots))
    for _ in range(_MAX_ROUNDS):
        centres = spots[active] - normals[active] * radii[active, None]
        distances, nearest_indices = outline.tree.query(centres)
        is_nearer = distances < radii[active] * (1 - 1e-6)
        active, nearest_indices = active[is_nearer], nearest_indices[is_nearer]
        if not len(active):
            break
        chords = spots[active] - outline.tree.data[nearest_indices]
        depths = (chords * normals[active]).sum(axis=1)
        squares = (chords**2).sum(axis=1)
        usable = (depths > 1e-6 * np.sqrt(squares)) & (squares > 0)
        active = active[usable]
        radii[active] = np.minimum(radii[active], squares[usable] / (2 * depths[usable]))
    centres = spots - normals * radii[:, None]
    # Where a wall is thinner than the spacing of the samples, a centre may be outside; the spot replaces it.
    is_outside = outline.protrusion(centres) > 0
    centres[is_outside], radii[is_outside] = spots[is_outside], 0.0
    return centres, np.minimum(radii, outline.distance(centres))


def _cover(covers_row: npt.NDArray[np.bool_], max_spheres: int) -> list[int] | None:
    """Returns the columns that a greedy choice needs to cover each row, the first of equal columns; None if
    it needs more than `max_spheres`."""
    is_bare = np.ones(len(covers_row), dtype=bool)
    by_column = np.ascontiguousarray(covers_row.T)
    gains = by_column.sum(axis=1)
    columns: list[int] = []
    while is_bare.any():
        if len(columns) == max_spheres:
            return None
        best = int(gains.argmax())
        if not gains[best]:
            return None
        newly_covered = is_bare & by_column[best]
        gains = gains - by_column[:, newly_covered].sum(axis=1)
        is_bare &= ~newly_covered
        columns.append(best)
    return columns
