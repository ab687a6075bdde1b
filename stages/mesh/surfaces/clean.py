"""Cleaning: from any triangles to closed solids that face outwards, and what is left of them."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface, compacted, weld
from linkwright.stages.mesh.surfaces.shells import Edges, Flags, Indices, Shells, components, turned_alike

_CRUMB = 1e-6  # of the volume
_THIN = 1e-6  # m, or of the size
_GAP = 1e-5  # of the size
_LARGEST, _SMALLEST = 5.0, 1e-3  # m

FlawName = Literal[
    "not finite", "doubled", "turned faces", "cracks", "open", "not manifold", "inverted", "cavities",
    "nested", "crumbs", "flat", "large", "small", "empty",
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class Flaw:
    """What was mended, dropped or found. `count`: of faces, edges or shells, as `text` says; `figure` [m]
    where there is a length."""

    name: FlawName
    count: int
    text: str
    figure: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Cleaned:
    """A mesh in parts.

    `solids`: closed, facing outwards, each with its cavities, the largest first. `loose`: what spans a volume
    but does not close, None if nothing: its inside is a matter of sampling. `rest`: what is flat, and crumbs,
    to be seen only. `manifold`: whether two faces meet at every edge of the solids and nothing is loose.
    """

    solids: tuple[Surface, ...]
    loose: Surface | None
    rest: Surface | None
    flaws: tuple[Flaw, ...]
    manifold: bool

    def bodies(self) -> tuple[Surface, ...]:
        """What colliders are made for: the solids, then what is loose."""
        return self.solids + ((self.loose,) if self.loose else ())

    def outer_bodies(self) -> tuple[Surface, ...]:
        """The same without the cavities of the solids: nothing gets there."""
        return tuple(map(_without_cavities, self.solids)) + ((self.loose,) if self.loose else ())


def clean(surface: Surface) -> Cleaned:
    """A mesh's solids and the rest, mended where that is sure; takes any triangles, even none.

    Faces with a corner that is not finite or not there go, and faces twice in the same place, which close
    nothing. Cracks narrower than 1e-5 of the size are closed. The faces of a shell are turned alike, and
    a shell that is inside out is turned with all that is in it. A shell within another that faces inwards is
    its cavity; one that faces outwards a solid in the other's material. Shells below 1e-6 of the volume go.
    """
    flaws: list[Flaw] = []
    surface = _sound(surface, flaws)
    if not len(surface.triangles):
        return Cleaned((), None, None, (*flaws, Flaw("empty", 0, "the mesh has no triangles")), False)
    _check_extent(surface, flaws)
    surface, doubled = _without_doubled(surface, flaws)
    surface = _without_cracks(surface, flaws)
    surface, count = turned_alike(surface)
    if count:
        flaws.append(Flaw("turned faces", count, f"{count} faces were turned the way of their neighbours"))
    if not len(surface.triangles):
        return Cleaned((), None, _of(doubled), tuple(flaws), False)
    shells = Shells.of(surface)
    spanned = np.abs(shells.volume)
    solid = shells.closed & (spanned > shells.area / 2 * _THIN * np.minimum(1.0, shells.size))
    crumb = solid & (spanned < _CRUMB * spanned[solid].sum())
    if crumb.any():
        count = int(crumb.sum())
        flaws.append(Flaw("crumbs", count, f"{count} shells are smaller than a millionth of the volume"))
    solids = _solids(shells, np.flatnonzero(solid & ~crumb), flaws)
    loose, flat = _loose(shells, np.flatnonzero(~solid[shells.label]), bool(solids), flaws)
    faces = np.concatenate([np.flatnonzero(crumb[shells.label]), flat])
    rest = _joined(_faces(surface, faces), doubled)
    many = _meeting(surface, np.flatnonzero(solid[shells.label]), flaws)
    return Cleaned(solids, _of(loose), _of(rest), tuple(flaws), bool(solids) and not many and loose is None)


def _sound(surface: Surface, flaws: list[Flaw]) -> Surface:
    """The triangles whose corners are there and finite, welded if they were not."""
    points, triangles = surface.vertices, surface.triangles
    there = ((triangles >= 0) & (triangles < len(points))).all(axis=1)
    finite = np.append(np.isfinite(points).all(axis=1), False)
    sound = there & finite[np.where((triangles >= 0) & (triangles < len(points)), triangles, -1)].all(axis=1)
    lost = int((~sound).sum())
    if lost:
        flaws.append(Flaw("not finite", lost, f"{lost} faces had a corner that is no finite point"))
    if not sound.any():
        return Surface(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))
    if lost or not _ascending(points):
        welded, _ = weld(points, triangles[sound])
        return welded
    return surface


def _ascending(points: np.ndarray) -> bool:
    """Whether points are sorted and distinct, as welding leaves them."""
    step = points[1:] - points[:-1]
    x, y, z = step.T
    return bool(((x > 0) | ((x == 0) & ((y > 0) | ((y == 0) & (z > 0))))).all())


def _check_extent(surface: Surface, flaws: list[Flaw]) -> None:
    extent = float(np.ptp(surface.vertices[np.unique(surface.triangles)], axis=0).max())
    if extent > _LARGEST:
        likely = "millimetres" if extent / 1000 >= _SMALLEST * 5 else "inches"
        text = f"the mesh is {extent:.4g} m across: its file is likely in {likely}, read as metres"
        flaws.append(Flaw("large", 1, text, extent))
    elif 0 < extent < _SMALLEST:
        text = f"the mesh is {extent * 1000:.3g} mm across: its file is likely in metres, read as millimetres"
        flaws.append(Flaw("small", 1, text, extent))


def _without_doubled(surface: Surface, flaws: list[Flaw]) -> tuple[Surface, Surface | None]:
    """The surface with one of equal faces, and none of two back to back; those apart."""
    ordered = np.sort(surface.triangles, axis=1)
    order = np.lexsort(ordered.T[::-1])
    ordered = ordered[order]
    new = np.ones(len(ordered), dtype=bool)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    if new.all():
        return surface, None
    group = np.cumsum(new) - 1
    # The sense of a triangle whose corners are sorted, against its own.
    a, b, c = surface.triangles[order].T
    sense = np.where(((a < b) & (b < c)) | ((b < c) & (c < a)) | ((c < a) & (a < b)), 1, -1)
    net = np.bincount(group, sense).astype(np.int64)
    fitting = sense * np.sign(net[group]) > 0
    first = np.full(len(net), len(order))
    np.minimum.at(first, group[fitting], np.flatnonzero(fitting))
    kept = np.sort(order[first[first < len(order)]])
    back = np.sort(order[np.flatnonzero(new)[net == 0]])
    lost = len(order) - len(kept)
    flaws.append(Flaw("doubled", lost, f"{lost} faces lie on others or back to back with them"))
    return Surface(surface.vertices, surface.triangles[kept]), _faces(surface, back)


def _without_cracks(surface: Surface, flaws: list[Flaw]) -> Surface:
    """The surface with the sides of narrow cracks joined, where that leaves fewer edges open."""
    from scipy.spatial import cKDTree

    edges = Edges.of(surface)
    open_edges = edges.excess() != 0
    before = int(open_edges.sum())
    if not before:
        return surface
    rim = np.unique(edges.ends[open_edges])
    gap = _GAP * float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
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
    if after >= before:
        return surface
    flaws.append(Flaw("cracks", before - after, f"{before - after} open edges were closed", gap))
    return compacted(joined)


def _solids(shells: Shells, chosen: Indices, flaws: list[Flaw]) -> tuple[Surface, ...]:
    """The solids of closed shells that have a volume, each with its cavities."""
    holders = shells.holders(chosen)
    depth = {shell: len(held) for shell, held in holders.items()}
    cavity: dict[int, bool] = {}
    owner: dict[int, int] = {}
    turn: dict[int, bool] = {}
    nested = 0
    for shell in sorted(depth, key=lambda one: (depth[one], one)):
        parent = max(
            holders[shell], key=lambda one: (depth[one], -abs(shells.volume[one]), -one), default=None
        )
        inwards = bool(shells.volume[shell] < 0)
        if parent is None:
            turn[shell], cavity[shell], owner[shell] = inwards, False, shell
            continue
        inwards ^= turn[_root(shell, holders, depth)]
        cavity[shell] = inwards and not cavity[parent]
        owner[shell] = owner[parent] if cavity[shell] else shell
        turn[shell] = bool(shells.volume[shell] < 0) != cavity[shell]
        nested += not cavity[shell] and not cavity[parent]
    _report(turn, cavity, nested, flaws)
    order = np.argsort(shells.label, kind="stable")
    bounds = np.searchsorted(shells.label[order], np.arange(len(shells.closed) + 1))
    members: dict[int, list[Indices]] = {}
    for shell in sorted(owner):
        triangles = shells.surface.triangles[np.sort(order[bounds[shell] : bounds[shell + 1]])]
        members.setdefault(owner[shell], []).append(triangles[:, ::-1] if turn[shell] else triangles)
    names = sorted(members, key=lambda one: (-abs(shells.volume[one]), one))
    return tuple(compacted(Surface(shells.surface.vertices, np.concatenate(members[one]))) for one in names)


def _without_cavities(solid: Surface) -> Surface:
    shells = Shells.of(solid)
    outer = shells.volume > 0
    return solid if outer.all() else compacted(Surface(solid.vertices, solid.triangles[outer[shells.label]]))


def _root(shell: int, holders: dict[int, list[int]], depth: dict[int, int]) -> int:
    return min(holders[shell], key=lambda one: (depth[one], one))


def _report(turn: dict[int, bool], cavity: dict[int, bool], nested: int, flaws: list[Flaw]) -> None:
    inverted = sum(turned and not cavity[shell] for shell, turned in turn.items())
    if inverted:
        flaws.append(Flaw("inverted", inverted, f"{inverted} shells were inside out and were turned"))
    if any(cavity.values()):
        count = sum(cavity.values())
        flaws.append(Flaw("cavities", count, f"{count} shells are cavities in others"))
    if nested:
        flaws.append(Flaw("nested", nested, f"{nested} solids lie within the material of others"))


def _loose(
    shells: Shells, faces: Indices, small_too: bool, flaws: list[Flaw]
) -> tuple[Surface | None, Indices]:
    """Of faces of no solid: what spans a volume where they hang together by vertices, and the other faces."""
    if not len(faces):
        return None, faces
    triangles = shells.surface.triangles[faces]
    points, corners = np.unique(triangles, return_inverse=True)
    corners = corners.reshape(-1, 3)
    label = components(
        len(points),
        np.concatenate([corners[:, 0], corners[:, 1]]),
        np.concatenate([corners[:, 1], corners[:, 2]]),
    )
    flat = _flat(shells.surface.vertices[points], label, small_too, shells.size.max())[label[corners[:, 0]]]
    if flat.any():
        count = len(np.unique(label[corners[flat, 0]]))
        flaws.append(Flaw("flat", count, f"{count} pieces are flat or crumbs, and only to be seen"))
    if flat.all():
        return None, faces
    loose = _faces(shells.surface, faces[~flat])
    if loose is None:
        return None, faces
    count = int((Edges.of(loose).excess() != 0).sum())
    flaws.append(Flaw("open", count, f"{count} edges are open: what is inside is a matter of sampling"))
    return loose, faces[flat]


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


def _meeting(surface: Surface, faces: Indices, flaws: list[Flaw]) -> int:
    """How many edges of these faces have more than two of them."""
    many = int((Edges.of(Surface(surface.vertices, surface.triangles[faces])).counts() > 2).sum())
    if many:
        flaws.append(Flaw("not manifold", many, f"more than two faces meet at {many} edges"))
    return many


def _faces(surface: Surface, faces: Indices) -> Surface | None:
    return compacted(Surface(surface.vertices, surface.triangles[faces])) if len(faces) else None


def _joined(one: Surface | None, other: Surface | None) -> Surface | None:
    if one is None or other is None:
        return one or other
    triangles = np.concatenate([one.triangles, other.triangles + len(one.vertices)])
    return Surface(np.concatenate([one.vertices, other.vertices]), triangles)


def _of(surface: Surface | None) -> Surface | None:
    return surface if surface is not None and len(surface.triangles) else None
