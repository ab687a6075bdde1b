"""Cleaning: from any triangles to closed solids that face outwards, and what is left of them."""

from dataclasses import dataclass

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface, compacted, weld
from linkwright.stages.mesh.surfaces.shells import Edges, Flags, Indices, Shells, components, turned_alike

_CRUMB = 1e-6  # of the volume
_THIN = 1e-6  # m, or of the size
_GAP = 1e-5  # of the size


@dataclass(frozen=True, slots=True, eq=False)
class Cleaned:
    """A mesh in parts.

    `solids`: closed, facing outwards, without their cavities, where nothing gets; the largest first. `loose`:
    what spans a volume but does not close, None if nothing: its inside is a matter of sampling.
    """

    solids: tuple[Surface, ...] = ()
    loose: Surface | None = None

    def bodies(self) -> tuple[Surface, ...]:
        """What colliders are made for: the solids, then what is loose."""
        return self.solids + ((self.loose,) if self.loose else ())


def clean(surface: Surface) -> Cleaned:
    """A mesh's solids, mended where that is sure; takes any triangles, even none.

    Faces with a corner that is not finite or not there go, and faces twice in the same place, which close
    nothing. Cracks narrower than 1e-5 of the size are closed. The faces of a shell are turned alike. A shell
    within another that faces inwards is its cavity, and goes; one that faces outwards is a solid in the
    other's material. A shell that is inside out is turned, and counts as turned with all that is in it. What
    is flat goes, and shells below 1e-6 of the volume.
    """
    surface = _sound(surface)
    if not len(surface.triangles):
        return Cleaned()
    surface = turned_alike(_without_cracks(_without_doubled(surface)))
    if not len(surface.triangles):
        return Cleaned()
    shells = Shells.of(surface)
    spanned = np.abs(shells.volume)
    solid = shells.closed & (spanned > shells.area / 2 * _THIN * np.minimum(1.0, shells.size))
    crumb = solid & (spanned < _CRUMB * spanned[solid].sum())
    solids = _solids(shells, np.flatnonzero(solid & ~crumb))
    return Cleaned(solids, _loose(shells, np.flatnonzero(~solid[shells.label]), bool(solids)))


def _sound(surface: Surface) -> Surface:
    """The triangles whose corners are there and finite, welded if they were not."""
    points, triangles = surface.vertices, surface.triangles
    there = (triangles >= 0) & (triangles < len(points))
    finite = np.append(np.isfinite(points).all(axis=1), False)
    sound = finite[np.where(there, triangles, -1)].all(axis=1)
    if not sound.any():
        return Surface(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))
    if not sound.all() or not _ascending(points):
        surface, _ = weld(points, triangles[sound])
    return surface


def _ascending(points: np.ndarray) -> bool:
    """Whether points are sorted and distinct, as welding leaves them."""
    step = points[1:] - points[:-1]
    x, y, z = step.T
    return bool(((x > 0) | ((x == 0) & ((y > 0) | ((y == 0) & (z > 0))))).all())


def _without_doubled(surface: Surface) -> Surface:
    """The surface with one of equal faces, and none of two back to back."""
    ordered = np.sort(surface.triangles, axis=1)
    order = np.lexsort(ordered.T[::-1])
    ordered = ordered[order]
    new = np.ones(len(ordered), dtype=bool)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    if new.all():
        return surface
    group = np.cumsum(new) - 1
    # The sense of a triangle whose corners are sorted, against its own.
    a, b, c = surface.triangles[order].T
    sense = np.where(((a < b) & (b < c)) | ((b < c) & (c < a)) | ((c < a) & (a < b)), 1, -1)
    net = np.bincount(group, sense).astype(np.int64)
    fitting = sense * np.sign(net[group]) > 0
    first = np.full(len(net), len(order))
    np.minimum.at(first, group[fitting], np.flatnonzero(fitting))
    return Surface(surface.vertices, surface.triangles[np.sort(order[first[first < len(order)]])])


def _without_cracks(surface: Surface) -> Surface:
    """The surface with the sides of narrow cracks joined, where that leaves fewer edges open."""
    # Late: a part from the cache needs no library that makes colliders or decimates.
    from scipy.spatial import cKDTree

    edges = Edges.of(surface)
    open_edges = edges.excess() != 0
    before = int(open_edges.sum())
    if not before:
        return surface
    rim = np.unique(edges.ends[open_edges])
    gap = _GAP * surface.diagonal
    pairs = cKDTree(surface.vertices[rim]).query_pairs(gap, output_type="ndarray")
    if not len(pairs):
        return surface
    group = components(len(rim), pairs[:, 0].astype(np.int64), pairs[:, 1].astype(np.int64))
    leaders = np.unique(group, return_index=True)[1]
    target = np.arange(len(surface.vertices))
    target[rim] = rim[leaders[group]]
    triangles = target[surface.triangles]
    a, b, c = triangles.T
    joined = Surface(surface.vertices, triangles[(a != b) & (b != c) & (c != a)])
    after = int((Edges.of(joined).excess() != 0).sum()) if len(joined.triangles) else before
    return surface if after >= before else compacted(joined)


def _solids(shells: Shells, chosen: Indices) -> tuple[Surface, ...]:
    """The solids of closed shells that have a volume."""
    holders = shells.holders(chosen)
    inwards = shells.volume < 0
    cavity: dict[int, bool] = {}
    for shell in sorted(holders, key=lambda shell: (len(holders[shell]), shell)):
        cavity[shell] = False
        if around := holders[shell]:
            outermost = min(around, key=lambda one: (len(holders[one]), one))
            parent = max(around, key=lambda one: (len(holders[one]), -abs(shells.volume[one]), -one))
            cavity[shell] = bool(inwards[shell] != inwards[outermost]) and not cavity[parent]
    order = np.argsort(shells.label, kind="stable")
    bounds = np.searchsorted(shells.label[order], np.arange(len(shells.closed) + 1))
    found = []
    for shell in sorted(cavity, key=lambda shell: (-abs(shells.volume[shell]), shell)):
        if not cavity[shell]:
            triangles = shells.surface.triangles[np.sort(order[bounds[shell] : bounds[shell + 1]])]
            own = triangles[:, ::-1] if inwards[shell] else triangles
            found.append(compacted(Surface(shells.surface.vertices, own)))
    return tuple(found)


def _loose(shells: Shells, faces: Indices, small_too: bool) -> Surface | None:
    """Of faces of no solid: what spans a volume where they hang together by vertices."""
    triangles = shells.surface.triangles[faces]
    points, corners = np.unique(triangles, return_inverse=True)
    first, second, third = corners.reshape(-1, 3).T
    if not len(faces):
        return None
    label = components(len(points), np.concatenate([first, second]), np.concatenate([second, third]))
    flat = _flat(shells.surface.vertices[points], label, small_too, shells.size.max())[label[first]]
    return None if flat.all() else compacted(Surface(shells.surface.vertices, triangles[~flat]))


def _flat(points: np.ndarray, label: Indices, small_too: bool, size: float) -> Flags:
    """(k,): whether the points of each piece lie in a plane, or are nothing beside the size of all."""
    count = np.bincount(label)
    middle = np.stack([np.bincount(label, axis) / count for axis in points.T], axis=1)
    off = points - middle[label]
    moments = np.empty((len(count), 3, 3))
    for i in range(3):
        for j in range(3):
            moments[:, i, j] = np.bincount(label, off[:, i] * off[:, j]) / count
    values = np.maximum(np.linalg.eigvalsh(moments), 0.0)
    width = np.sqrt(values[:, 2])
    flat = np.sqrt(values[:, 0]) <= np.maximum(_THIN * np.minimum(1.0, width), 1e-7 * width)
    return np.asarray(flat | (small_too & (width < _CRUMB ** (1 / 3) * size / 4)))
