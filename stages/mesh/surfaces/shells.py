"""Finds the shells of a surface (faces connected by edges): which of them are closed, and which contain
others."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.components import Indices, components
from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.surfaces.rays import LineGrid

Flags = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """The sides of all triangles, sorted so that the sides of an edge follow each other."""

    faces: Indices
    """Index of the triangle of each side (3 m,)."""
    forward: Flags
    """Whether each side runs from the lower vertex index to the higher (3 m,)."""
    starts: Indices
    """Index of each edge's first side (k,)."""
    ends: Indices
    """Vertices of each edge (k, 2), the lower index first."""

    @staticmethod
    def of(surface: Surface) -> "Edges":
        """Sorts the sides of a surface."""
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
        """Returns the number of sides of each edge (k,)."""
        return np.diff(np.append(self.starts, len(self.faces)))

    def excess(self) -> Indices:
        """Returns how many more sides of each edge (k,) run forward than back: 0 on a closed surface."""
        if not len(self.starts):
            return np.zeros(0, dtype=np.int64)
        return np.add.reduceat(np.where(self.forward, 1, -1), self.starts)

    def pairs(self) -> tuple[Indices, Indices, Flags]:
        """Returns the two triangles at each edge that has exactly two, and whether they face the same way."""
        first = self.starts[self.counts() == 2]
        return self.faces[first], self.faces[first + 1], self.forward[first] != self.forward[first + 1]


def orient_consistently(surface: Surface) -> Surface:
    """Returns the surface with all faces of a shell facing the same way, as most of them did before. A shell
    with a single side (a Möbius strip) stays unchanged.

    Each face has two copies, one of them turned. Copies of neighbouring faces are connected if they face the
    same way; the copies that are connected to a shell's first face are one consistent way to turn the shell.
    """
    first, second, agree = Edges.of(surface).pairs()
    count = len(surface.triangles)
    if agree.all():
        return surface
    shells = components(count, first, second)
    same_side = np.where(agree, second, second + count)
    other_side = np.where(agree, second + count, second)
    copies = components(
        2 * count, np.concatenate([first, first + count]), np.concatenate([same_side, other_side])
    )
    leaders = np.unique(shells, return_index=True)[1]
    is_turned = copies[:count] != copies[leaders][shells]
    is_turned &= copies[:count] != copies[count:]
    mostly_turned = np.bincount(shells[is_turned], minlength=len(leaders)) * 2 > np.bincount(shells)
    is_turned ^= mostly_turned[shells] & (copies[:count] != copies[count:])
    triangles = np.where(is_turned[:, None], surface.triangles[:, ::-1], surface.triangles)
    return Surface(surface.vertices, triangles)


@dataclass(frozen=True, slots=True, eq=False)
class Shells:
    """The shells of a surface."""

    surface: Surface
    label: Indices
    """Index of each face's shell (m,)."""
    closed: Flags
    """Whether each shell is closed (k,)."""
    volume: npt.NDArray[np.float64]
    """Signed volume of each shell (k,) [m³]."""
    area: npt.NDArray[np.float64]
    """Area of each shell (k,) [m²]."""
    size: npt.NDArray[np.float64]
    """Diagonal of each shell's bounding box (k,) [m]."""

    @staticmethod
    def of(surface: Surface) -> "Shells":
        """Returns the shells of a surface. Faces are connected at edges with two faces; at edges with more
        faces they are connected only if their shells would not be closed otherwise."""
        edges = Edges.of(surface)
        count = len(surface.triangles)
        first, second, _ = edges.pairs()
        label = components(count, first, second)
        is_closed = _closed_shells(edges, label)
        if not is_closed.all():
            sides = np.ones(len(edges.faces), dtype=bool)
            sides[edges.starts] = False
            neighbours = np.flatnonzero(sides)
            face, next_face = edges.faces[neighbours - 1], edges.faces[neighbours]
            open_too = ~is_closed[label[face]] & ~is_closed[label[next_face]]
            label = components(
                count, np.concatenate([first, face[open_too]]), np.concatenate([second, next_face[open_too]])
            )
            is_closed = _closed_shells(edges, label)
        number = len(is_closed)
        volume = _sums_by_label(label, surface.cone_volumes(surface.vertices.mean(axis=0)), number)
        area = _sums_by_label(label, np.linalg.norm(surface.normals(), axis=1) / 2, number)
        order = np.argsort(label, kind="stable")
        starts = np.searchsorted(label[order], np.arange(number))
        corners = surface.corners[order]
        low = np.minimum.reduceat(corners.min(axis=1), starts)
        high = np.maximum.reduceat(corners.max(axis=1), starts)
        return Shells(surface, label, is_closed, volume, area, np.linalg.norm(high - low, axis=1))

    def holders(self, candidates: Indices) -> dict[int, list[int]]:
        """Returns for each of the `candidates` closed shells the other chosen shells that contain it, judged
        by three of its vertices."""
        if len(candidates) < 2:
            return {int(shell): [] for shell in candidates}
        rank = np.full(len(self.closed), -1)
        rank[candidates] = np.arange(len(candidates))
        faces = np.flatnonzero(rank[self.label] >= 0)
        part = Surface(self.surface.vertices, self.surface.triangles[faces])
        shell = rank[self.label[faces]]
        points = self.surface.vertices[part.triangles[_three_faces(shell, len(candidates)), 0].ravel()]
        keys, sums = [], []
        for crossings in LineGrid.of(part).crossings(points):
            of_other_shell = shell[crossings.triangles] != crossings.points // 3
            keys.append((crossings.points * len(candidates) + shell[crossings.triangles])[of_other_shell])
            sums.append(np.where(crossings.above, crossings.sign, -crossings.sign)[of_other_shell])
        pair_keys, member = np.unique(np.concatenate([*keys, np.zeros(0, np.int64)]), return_inverse=True)
        winding = np.bincount(member.ravel(), np.concatenate([*sums, np.zeros(0, np.int8)]), len(pair_keys))
        # The vertical line through a vertex leaves a shell around it once above and once below, counted
        # senses.
        holding = pair_keys[np.abs(winding) >= 2]
        pairs, hits = np.unique(
            holding // len(candidates) // 3 * len(candidates) + holding % len(candidates), return_counts=True
        )
        holders: dict[int, list[int]] = {int(shell): [] for shell in candidates}
        for pair in pairs[hits == 3].tolist():
            holders[int(candidates[pair // len(candidates)])].append(int(candidates[pair % len(candidates)]))
        return holders


def _closed_shells(edges: Edges, label: Indices) -> Flags:
    """Tells for each shell (k,) whether its sides cancel at every edge."""
    number = int(label.max(initial=-1)) + 1
    edge = np.repeat(np.arange(len(edges.starts)), edges.counts())
    key = edge * np.int64(max(number, 1)) + label[edges.faces]
    order = np.argsort(key, kind="stable")
    key, sign = key[order], np.where(edges.forward, 1, -1)[order]
    new = np.ones(len(key), dtype=bool)
    new[1:] = key[1:] != key[:-1]
    starts = np.flatnonzero(new)
    is_closed = np.ones(number, dtype=bool)
    if len(starts):
        excess = np.add.reduceat(sign, starts)
        is_closed[(key[starts] % max(number, 1))[excess != 0]] = False
    return is_closed


def _sums_by_label(label: Indices, values: npt.NDArray[np.float64], number: int) -> npt.NDArray[np.float64]:
    return np.bincount(label, values, number).astype(np.float64)


def _three_faces(shell: Indices, number: int) -> Indices:
    """Returns three faces of each shell (number, 3): the first, the middle and the last."""
    order = np.argsort(shell, kind="stable")
    begin = np.searchsorted(shell[order], np.arange(number))
    end = np.append(begin[1:], len(shell))
    return np.asarray(order[np.stack([begin, (begin + end) // 2, end - 1], axis=1)], dtype=np.int64)
