"""The shells of a surface: faces connected by edges; which are closed, and which lies within which."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.surfaces.rays import LineGrid

Indices = npt.NDArray[np.int64]
Flags = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """The sides of all triangles, in groups that lie on one edge. `faces` (3 m,): the triangle of each side;
    `forward`: whether it runs from the lower vertex to the higher; `starts` (k,): where each edge's sides
    begin; `ends` (k, 2): its vertices."""

    faces: Indices
    forward: Flags
    starts: Indices
    ends: Indices

    @staticmethod
    def of(surface: Surface) -> "Edges":
        first = surface.triangles.ravel()
        second = np.roll(surface.triangles, -1, axis=1).ravel()
        low, high = np.minimum(first, second), np.maximum(first, second)
        key = low * np.int64(len(surface.vertices)) + high
        order = np.argsort(key, kind="stable")
        key = key[order]
        new = np.ones(len(key), dtype=bool)
        new[1:] = key[1:] != key[:-1]
        starts = np.flatnonzero(new)
        ends = np.stack([low[order][starts], high[order][starts]], axis=1)
        return Edges(order // 3, (first < second)[order], starts, ends)

    def counts(self) -> Indices:
        """(k,): how many sides each edge has."""
        return np.diff(np.append(self.starts, len(self.faces)))

    def excess(self) -> Indices:
        """(k,): how many more sides run forward than back: 0 on a closed surface."""
        if not len(self.starts):
            return np.zeros(0, dtype=np.int64)
        return np.add.reduceat(np.where(self.forward, 1, -1), self.starts)

    def pairs(self) -> tuple[Indices, Indices, Flags]:
        """The two triangles at each edge that has exactly two, and whether they face the same way."""
        first = self.starts[self.counts() == 2]
        return self.faces[first], self.faces[first + 1], self.forward[first] != self.forward[first + 1]


def components(count: int, first: Indices, second: Indices) -> Indices:
    """(count,): which component each node is in, numbered by their first nodes."""
    # Late: a part from the cache needs no library that makes colliders or decimates.
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    links = coo_array((np.ones(len(first), dtype=np.int8), (first, second)), (count, count))
    _, label = connected_components(links, directed=False)
    _, leaders, member = np.unique(label, return_index=True, return_inverse=True)
    rank = np.empty(len(leaders), dtype=np.int64)
    rank[np.argsort(leaders)] = np.arange(len(leaders))
    return rank[member.ravel()]


def turned_alike(surface: Surface) -> Surface:
    """The surface with the faces of each shell facing the same way, as most of them do. A shell with one side
    only (a Möbius strip) stays as it is.

    Two copies of each face, one turned, hang together as their neighbours agree or not: the copies that hang
    together with a shell's first face are one way to turn it.
    """
    first, second, alike = Edges.of(surface).pairs()
    count = len(surface.triangles)
    if alike.all():
        return surface
    shells = components(count, first, second)
    other = np.where(alike, second, second + count)
    another = np.where(alike, second + count, second)
    copies = components(2 * count, np.concatenate([first, first + count]), np.concatenate([other, another]))
    leaders = np.unique(shells, return_index=True)[1]
    turned = copies[:count] != copies[leaders][shells]
    turned &= copies[:count] != copies[count:]
    most = np.bincount(shells[turned], minlength=len(leaders)) * 2 > np.bincount(shells)
    turned ^= most[shells] & (copies[:count] != copies[count:])
    triangles = np.where(turned[:, None], surface.triangles[:, ::-1], surface.triangles)
    return Surface(surface.vertices, triangles)


@dataclass(frozen=True, slots=True, eq=False)
class Shells:
    """`label` (m,): the shell of each face; of each shell (k,) whether it is `closed`, and its signed
    `volume` [m³], `area` [m²] and `size` [m], the diagonal of its bounds."""

    surface: Surface
    label: Indices
    closed: Flags
    volume: npt.NDArray[np.float64]
    area: npt.NDArray[np.float64]
    size: npt.NDArray[np.float64]

    @staticmethod
    def of(surface: Surface) -> "Shells":
        """Shells hang together at edges of two faces; where more meet, only those not closed without."""
        edges = Edges.of(surface)
        count = len(surface.triangles)
        first, second, _ = edges.pairs()
        label = components(count, first, second)
        closed = _closed(edges, label)
        if not closed.all():
            sides = np.ones(len(edges.faces), dtype=bool)
            sides[edges.starts] = False
            neighbours = np.flatnonzero(sides)
            one, two = edges.faces[neighbours - 1], edges.faces[neighbours]
            open_too = ~closed[label[one]] & ~closed[label[two]]
            label = components(
                count, np.concatenate([first, one[open_too]]), np.concatenate([second, two[open_too]])
            )
            closed = _closed(edges, label)
        number = len(closed)
        volume = _sums(label, surface.cone_volumes(surface.vertices.mean(axis=0)), number)
        area = _sums(label, np.linalg.norm(surface.normals(), axis=1) / 2, number)
        order = np.argsort(label, kind="stable")
        starts = np.searchsorted(label[order], np.arange(number))
        corners = surface.corners[order]
        low = np.minimum.reduceat(corners.min(axis=1), starts)
        high = np.maximum.reduceat(corners.max(axis=1), starts)
        return Shells(surface, label, closed, volume, area, np.linalg.norm(high - low, axis=1))

    def holders(self, chosen: Indices) -> dict[int, list[int]]:
        """For each of some closed shells the others of them that it is inside of.

        By three of its vertices: it is inside of what has them all inside.
        """
        if len(chosen) < 2:
            return {int(shell): [] for shell in chosen}
        rank = np.full(len(self.closed), -1)
        rank[chosen] = np.arange(len(chosen))
        faces = np.flatnonzero(rank[self.label] >= 0)
        part = Surface(self.surface.vertices, self.surface.triangles[faces])
        shell = rank[self.label[faces]]
        points = self.surface.vertices[part.triangles[_thirds(shell, len(chosen)), 0].ravel()]
        keys, sums = [], []
        for some in LineGrid.of(part).crossings(points):
            other = shell[some.triangles] != some.points // 3
            keys.append((some.points * len(chosen) + shell[some.triangles])[other])
            sums.append(np.where(some.above, some.sign, -some.sign)[other])
        every, member = np.unique(np.concatenate([*keys, np.zeros(0, np.int64)]), return_inverse=True)
        twice = np.bincount(member.ravel(), np.concatenate([*sums, np.zeros(0, np.int8)]), len(every))
        within = every[np.abs(twice) >= 2]
        pairs, hits = np.unique(
            within // len(chosen) // 3 * len(chosen) + within % len(chosen), return_counts=True
        )
        found: dict[int, list[int]] = {int(one): [] for one in chosen}
        for pair in pairs[hits == 3].tolist():
            found[int(chosen[pair // len(chosen)])].append(int(chosen[pair % len(chosen)]))
        return found


def _closed(edges: Edges, label: Indices) -> Flags:
    """(k,): whether the sides of each shell cancel at every edge."""
    number = int(label.max(initial=-1)) + 1
    edge = np.repeat(np.arange(len(edges.starts)), edges.counts())
    key = edge * np.int64(max(number, 1)) + label[edges.faces]
    order = np.argsort(key, kind="stable")
    key, sign = key[order], np.where(edges.forward, 1, -1)[order]
    new = np.ones(len(key), dtype=bool)
    new[1:] = key[1:] != key[:-1]
    starts = np.flatnonzero(new)
    closed = np.ones(number, dtype=bool)
    if len(starts):
        excess = np.add.reduceat(sign, starts)
        closed[(key[starts] % max(number, 1))[excess != 0]] = False
    return closed


def _sums(label: Indices, values: npt.NDArray[np.float64], number: int) -> npt.NDArray[np.float64]:
    return np.bincount(label, values, number).astype(np.float64)


def _thirds(shell: Indices, number: int) -> Indices:
    """(number, 3): three faces of each shell, spread over its faces."""
    order = np.argsort(shell, kind="stable")
    begin = np.searchsorted(shell[order], np.arange(number))
    end = np.append(begin[1:], len(shell))
    return np.asarray(order[np.stack([begin, (begin + end) // 2, end - 1], axis=1)], dtype=np.int64)
