"""Cleans a mesh: splits any triangles into closed solids that face outwards, and an open remainder."""

from dataclasses import dataclass

import numpy as np
import scipy

from linkwright.stages.formats.meshes.components import Indices, components
from linkwright.stages.formats.meshes.surface import Surface, drop_unused_points, weld
from linkwright.stages.mesh.surfaces.shells import Edges, Flags, Shells, orient_consistently

_MIN_VOLUME_SHARE = 1e-6  # of the volume of all solids
_FLAT_THICKNESS = 1e-6  # m, or of the size
_MAX_CRACK_WIDTH = 1e-5  # of the size


@dataclass(frozen=True, slots=True, eq=False)
class Cleaned:
    """The solids and the open remainder of a mesh."""

    solids: tuple[Surface, ...] = ()
    """Closed surfaces that face outwards, the largest first, without cavities, which nothing can touch."""
    loose: Surface | None = None
    """Faces that span a volume but do not enclose it, or None; its users find its inside by sampling."""

    def bodies(self) -> tuple[Surface, ...]:
        """Returns the surfaces for which colliders are made: the solids, then the loose surface, if any."""
        return self.solids + ((self.loose,) if self.loose else ())


def clean(surface: Surface) -> Cleaned:
    """Returns the solids of a mesh, with all repairs that are certain. It takes any triangles, even none.

    Faces with an invalid or non-finite corner are removed, and so are duplicates. Cracks narrower than 1e-5
    of the size are closed. The faces of a shell are oriented consistently. A shell that faces inwards inside
    another is a cavity, and is removed; a shell that faces outwards there is a separate solid. If an
    outermost shell is inside out, it is flipped, with all shells inside it. Flat shells, and shells with less
    than 1e-6 of the volume, are removed."""
    surface = _without_invalid(surface)
    if not len(surface.triangles):
        return Cleaned()
    surface = orient_consistently(_without_cracks(_without_duplicates(surface)))
    if not len(surface.triangles):
        return Cleaned()
    shells = Shells.of(surface)
    spanned = np.abs(shells.volume)
    solid = shells.closed & (spanned > shells.area / 2 * _FLAT_THICKNESS * np.minimum(1.0, shells.size))
    negligible = solid & (spanned < _MIN_VOLUME_SHARE * spanned[solid].sum())
    solids = _solids(shells, np.flatnonzero(solid & ~negligible))
    return Cleaned(solids, _open_remainder(shells, np.flatnonzero(~solid[shells.label]), bool(solids)))


def _without_invalid(surface: Surface) -> Surface:
    """Returns the surface without invalid triangles, welded unless its vertices already are."""
    points, triangles = surface.vertices, surface.triangles
    in_range = (triangles >= 0) & (triangles < len(points))
    finite = np.append(np.isfinite(points).all(axis=1), False)
    valid = finite[np.where(in_range, triangles, -1)].all(axis=1)
    if not valid.any():
        return Surface(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))
    if not valid.all() or not _ascending(points):
        surface, _ = weld(points, triangles[valid])
    return surface


def _ascending(points: np.ndarray) -> bool:
    """Tells whether points are sorted and distinct, as welding leaves them."""
    step = points[1:] - points[:-1]
    x, y, z = step.T
    return bool(((x > 0) | ((x == 0) & ((y > 0) | ((y == 0) & (z > 0))))).all())


def _without_duplicates(surface: Surface) -> Surface:
    """Returns the surface without duplicate faces, and without pairs of faces back to back."""
    ordered = np.sort(surface.triangles, axis=1)
    order = np.lexsort(ordered.T[::-1])
    ordered = ordered[order]
    new = np.ones(len(ordered), dtype=bool)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    if new.all():
        return surface
    group = np.cumsum(new) - 1
    # +1 if a triangle's corners are in a cyclic order of the sorted corners, else -1.
    a, b, c = surface.triangles[order].T
    sense = np.where(((a < b) & (b < c)) | ((b < c) & (c < a)) | ((c < a) & (a < b)), 1, -1)
    net_sense = np.bincount(group, sense).astype(np.int64)
    majority = sense * np.sign(net_sense[group]) > 0
    first_of_group = np.full(len(net_sense), len(order))
    np.minimum.at(first_of_group, group[majority], np.flatnonzero(majority))
    return Surface(
        surface.vertices, surface.triangles[np.sort(order[first_of_group[first_of_group < len(order)]])]
    )


def _without_cracks(surface: Surface) -> Surface:
    """Returns the surface with narrow cracks closed, if that leaves fewer open edges."""
    edges = Edges.of(surface)
    open_edges = edges.excess() != 0
    open_before = int(open_edges.sum())
    if not open_before:
        return surface
    rim = np.unique(edges.ends[open_edges])
    gap = _MAX_CRACK_WIDTH * surface.diagonal
    pairs = scipy.spatial.cKDTree(surface.vertices[rim]).query_pairs(gap, output_type="ndarray")
    if not len(pairs):
        return surface
    group = components(len(rim), pairs[:, 0].astype(np.int64), pairs[:, 1].astype(np.int64))
    leaders = np.unique(group, return_index=True)[1]
    target = np.arange(len(surface.vertices))
    target[rim] = rim[leaders[group]]
    triangles = target[surface.triangles]
    a, b, c = triangles.T
    joined_surface = Surface(surface.vertices, triangles[(a != b) & (b != c) & (c != a)])
    open_after = (
        int((Edges.of(joined_surface).excess() != 0).sum()) if len(joined_surface.triangles) else open_before
    )
    return surface if open_after >= open_before else drop_unused_points(joined_surface)


def _solids(shells: Shells, candidates: Indices) -> tuple[Surface, ...]:
    """Returns the solids among closed shells that have a volume."""
    holders = shells.holders(candidates)
    inwards = shells.volume < 0
    is_cavity: dict[int, bool] = {}
    for shell in sorted(holders, key=lambda shell: (len(holders[shell]), shell)):
        is_cavity[shell] = False
        if enclosing := holders[shell]:
            outermost = min(enclosing, key=lambda holder: (len(holders[holder]), holder))
            parent = max(
                enclosing, key=lambda holder: (len(holders[holder]), -abs(shells.volume[holder]), -holder)
            )
            # Relative to the outermost shell, which may be inside out; a cavity's content is solid again.
            is_cavity[shell] = bool(inwards[shell] != inwards[outermost]) and not is_cavity[parent]
    order = np.argsort(shells.label, kind="stable")
    bounds = np.searchsorted(shells.label[order], np.arange(len(shells.closed) + 1))
    solids = []
    for shell in sorted(is_cavity, key=lambda shell: (-abs(shells.volume[shell]), shell)):
        if not is_cavity[shell]:
            triangles = shells.surface.triangles[np.sort(order[bounds[shell] : bounds[shell + 1]])]
            outward = triangles[:, ::-1] if inwards[shell] else triangles
            solids.append(drop_unused_points(Surface(shells.surface.vertices, outward)))
    return tuple(solids)


def _open_remainder(shells: Shells, faces: Indices, drop_small: bool) -> Surface | None:
    """Returns those faces outside of solids whose vertex-connected piece spans a volume."""
    triangles = shells.surface.triangles[faces]
    points, corners = np.unique(triangles, return_inverse=True)
    first, second, third = corners.reshape(-1, 3).T
    if not len(faces):
        return None
    label = components(len(points), np.concatenate([first, second]), np.concatenate([second, third]))
    is_flat = _are_flat(shells.surface.vertices[points], label, drop_small, shells.size.max())[label[first]]
    return (
        None if is_flat.all() else drop_unused_points(Surface(shells.surface.vertices, triangles[~is_flat]))
    )


def _are_flat(points: np.ndarray, label: Indices, drop_small: bool, size: float) -> Flags:
    """Returns for each piece (k,) whether its points lie in a plane. With `drop_small`, pieces that are tiny
    beside the whole `size` count as flat."""
    count = np.bincount(label)
    centroids = np.stack([np.bincount(label, axis) / count for axis in points.T], axis=1)
    offsets = points - centroids[label]
    moments = np.empty((len(count), 3, 3))
    for i in range(3):
        for j in range(3):
            moments[:, i, j] = np.bincount(label, offsets[:, i] * offsets[:, j]) / count
    values = np.maximum(np.linalg.eigvalsh(moments), 0.0)
    width = np.sqrt(values[:, 2])
    is_flat = np.sqrt(values[:, 0]) <= np.maximum(_FLAT_THICKNESS * np.minimum(1.0, width), 1e-7 * width)
    # A piece of the negligible share of the volume has about the cube root of that share of the size.
    return np.asarray(is_flat | (drop_small & (width < _MIN_VOLUME_SHARE ** (1 / 3) * size / 4)))
