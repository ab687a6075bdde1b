"""A part as a union of spheres."""

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points
from linkwright.stages.mesh.fit.outline import Floats, Outline
from linkwright.stages.robot.model.poses import from_parts
from linkwright.stages.robot.model.robot import Primitive, frozen

_CENTRES = 700
_WANTED = 2500
_ROUNDS = 30
_SHARE = 0.85  # of the tolerance, since points are not the whole surface
_BARE = 0.75
_WIDER = 1.25
_DECIMALS = 12


def spheres(outline: Outline, closed: bool, tolerance: float, most: int) -> tuple[Primitive, ...]:
    """At most `most` spheres whose union stands out of a part, and leaves it bare, by `tolerance` [m] where
    so many suffice, else by as little more as they can.

    Each is a ball in the part that touches its surface from within at two places or more, grown by the
    tolerance, so that it stands out by no more than that. Chosen is always the one that covers most of what
    is still bare. In a surface that is not `closed` they are centred on it.
    """
    # Late: a part from the cache needs no library that makes colliders or decimates.
    from scipy.spatial.distance import cdist

    spots, owners = _spots(outline)
    centres, radii = spots, np.zeros(len(spots))
    if closed:
        centres, radii = _within(outline, spots, outline.normals[owners])
    surface = np.concatenate([outline.tree.data, outline.faces.reshape(-1, 3)])
    wanted = surface[_spread(surface, outline, _WANTED)]
    apart = cdist(wanted, centres) - radii
    reach = _SHARE * tolerance
    while (chosen := _cover(apart <= (1 + _BARE) * reach, most)) is None:
        reach *= _WIDER
    poses = np.round(centres, _DECIMALS) + 0.0
    sizes = [round(float(radius + reach), _DECIMALS) for radius in radii]
    return tuple(Primitive("sphere", (sizes[k],), frozen(from_parts(np.eye(3), poses[k]))) for k in chosen)


def _spots(outline: Outline) -> tuple[Points, npt.NDArray[np.int64]]:
    """Points all over the surface, about as many in each place, and the triangle of each."""
    points = np.asarray(outline.tree.data)
    kept = _spread(points, outline, _CENTRES)
    return points[kept], outline.sample_faces[kept]


def _spread(points: Points, outline: Outline, count: int) -> npt.NDArray[np.int64]:
    """Indices of points, at most twice `count`, as far apart as so many on the whole surface are: the first
    of each cell of a grid, in the order of their coordinates, so that their own order does not matter."""
    order = np.lexsort(points.T[::-1])
    width = np.sqrt(outline.areas.sum() / count)
    while True:
        cells = np.floor(points[order] / width).astype(np.int64)
        _, first = np.unique(cells, axis=0, return_index=True)
        if len(first) <= 2 * count:
            return order[np.sort(first)]
        width *= _WIDER


def _within(outline: Outline, spots: Points, normals: Points) -> tuple[Points, Floats]:
    """Centres and radii of the largest balls in the part that touch its surface at these spots.

    By shrinking balls (Ma, Bae, Choi: "3D medial axis point approximation using nearest neighbors and the
    normal field", 2012): a ball behind a spot is made smaller until the part's nearest point is the spot.
    """
    radii = np.full(len(spots), outline.size / 2)
    active = np.arange(len(spots))
    for _ in range(_ROUNDS):
        centres = spots[active] - normals[active] * radii[active, None]
        near, which = outline.tree.query(centres)
        inside = near < radii[active] * (1 - 1e-6)
        active, which = active[inside], which[inside]
        if not len(active):
            break
        chords = spots[active] - outline.tree.data[which]
        depths = (chords * normals[active]).sum(axis=1)
        squares = (chords**2).sum(axis=1)
        usable = (depths > 1e-6 * np.sqrt(squares)) & (squares > 0)
        active = active[usable]
        radii[active] = np.minimum(radii[active], squares[usable] / (2 * depths[usable]))
    centres = spots - normals * radii[:, None]
    # Behind a wall that is thinner than the samples are apart a centre may lie outside: then at the spot.
    outside = outline.protrusion(centres) > 0
    centres[outside], radii[outside] = spots[outside], 0.0
    return centres, np.minimum(radii, outline.distance(centres))


def _cover(covers: npt.NDArray[np.bool_], most: int) -> list[int] | None:
    """Of columns as few as a greedy choice needs so that each row is covered, ties to the first; None where
    that is more than `most`."""
    bare = np.ones(len(covers), dtype=bool)
    by_column = np.ascontiguousarray(covers.T)
    gains = by_column.sum(axis=1)
    chosen: list[int] = []
    while bare.any():
        if len(chosen) == most:
            return None
        best = int(gains.argmax())
        if not gains[best]:
            return None
        new = bare & by_column[best]
        gains = gains - by_column[:, new].sum(axis=1)
        bare &= ~new
        chosen.append(best)
    return chosen
