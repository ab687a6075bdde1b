"""Searches for the pieces of links: it cuts pieces of false pairs, and merges pieces if no pair gets
worse."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations, product
from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, join_surfaces
from linkwright.stages.mesh.by_contact.pair import Numbers, Pair
from linkwright.stages.mesh.cut import planes
from linkwright.stages.mesh.cut.chunk import Chunk, engine_hull, hull_chunk, hull_of
from linkwright.stages.mesh.cut.cutting import cut_by_plane

_ROUGH_POSES = 20
"""Number of poses in which planes are compared roughly."""

_EXACT_PLANES = 3
"""Number of planes that are tried in all poses."""

_MAX_LEFT_SHARE = 0.97
"""Largest share of the depths that a useful cut leaves; a cut that leaves more is in vain."""

MAX_PIECES = 14
"""Largest number of pieces of a link while it is cut; some of them are joined again."""

_MAX_VAIN_CUTS = 2
"""Largest number of cuts in a row that may be in vain."""


class PieceSearch:
    """The pieces of all links while they are cut and merged. `chunks`: the pieces of each link; `may`:
    whether each link may be cut; `hulls`: primitive → its hull."""

    def __init__(
        self,
        chunks: Sequence[Sequence[Chunk]],
        may: Sequence[bool],
        pairs: Sequence[Pair],
        max_vertices: int,
        hulls: Mapping[Chunk, Chunk],
    ) -> None:
        self.chunks = [list(link_chunks) for link_chunks in chunks]
        self.may, self.pairs, self.max_vertices = may, list(pairs), max_vertices
        self.hulls = hulls
        self.primitives = {hull: primitive for primitive, hull in hulls.items()}
        self.of: list[list[Pair]] = [[] for _ in chunks]
        for pair in self.pairs:
            self.of[pair.one].append(pair)
            self.of[pair.other].append(pair)
        self._faces: dict[int, list[planes.Plane]] = {}

    def deeper(self, pair: Pair, chunks: dict[int, Sequence[Chunk]] | None = None) -> Numbers:
        """Returns for each pose (n,) by how much two pieces of a pair are deeper in each other than `borne`
        allows, at most. `chunks`: pieces to use instead of the present ones, by link."""
        sides = [(chunks or {}).get(link, self.chunks[link]) for link in (pair.one, pair.other)]
        deepest = np.zeros(len(pair.borne))
        for first, second in product(*sides):
            deepest = np.maximum(deepest, pair.of_chunks(first, second))
        return deepest

    def bad(self) -> list[tuple[int, Pair]]:
        """Returns the pairs that are false too often, the worst first."""
        badness_of = [(pair.badness(self.deeper(pair)), pair) for pair in self.pairs if not pair.stuck]
        pairs = [(badness, pair) for badness, pair in badness_of if badness > pair.allowed]
        return sorted(pairs, key=lambda entry: (-entry[0], entry[1].one, entry[1].other))

    def refine(self, parts: Callable[[int], Sequence[Chunk]]) -> None:
        """Cuts until no pair is false too often, except pairs that cuts do not improve. Links of such pairs
        begin again with a piece for each of their `parts`."""
        self._replace_primitives_by_hulls()
        self._cut_all()
        stuck = sorted({link for pair in self.pairs if pair.stuck for link in (pair.one, pair.other)})
        for link in stuck:
            if self.may[link] and len(part_chunks := parts(link)) > 1:
                self.chunks[link] = list(part_chunks)
                self.merge_link(link)
        for pair in self.pairs:
            pair.stuck, pair.vain = False, 0
        self._cut_all()

    def _replace_primitives_by_hulls(self) -> None:
        """Replaces the primitives of pairs that are false too often by their hulls, which are smaller."""
        for _, pair in self.bad():
            for link in (pair.one, pair.other):
                self.chunks[link] = [self.hulls.get(chunk, chunk) for chunk in self.chunks[link]]

    def _cut_all(self) -> None:
        while bad := self.bad():
            for _, pair in bad:
                if self._cut(pair):
                    break
                pair.stuck = True
            else:
                break

    def _cut(self, pair: Pair) -> bool:
        """Cuts a piece of one of the two links, if that may help; returns whether it did."""
        best: tuple[float, float, int, Chunk, list[Chunk]] | None = None
        for link in (pair.one, pair.other):
            if not self.may[link] or len(self.chunks[link]) >= MAX_PIECES:
                continue
            for chunk in self._worst(pair, link):
                for score, volume, pieces in self._cuts(pair, link, chunk):
                    if best is None or (score, volume) < best[:2]:
                        best = score, volume, link, chunk, pieces
        if best is None:
            return False
        # For a slot no single cut helps, but the next may; the pieces of a vain cut are merged again later.
        pair.vain = 0 if best[0] <= _MAX_LEFT_SHARE else pair.vain + 1
        if pair.vain > _MAX_VAIN_CUTS:
            return False
        _, _, link, chunk, pieces = best
        self._replace(link, [chunk], pieces)
        return True

    def _replace(self, link: int, old: Sequence[Chunk], new: Sequence[Chunk]) -> None:
        position = min(self.chunks[link].index(chunk) for chunk in old)
        rest = [chunk for chunk in self.chunks[link] if chunk not in old]
        self.chunks[link] = [*rest[:position], *new, *rest[position:]]

    def _worst(self, pair: Pair, link: int) -> list[Chunk]:
        """Returns the piece of a link that is deepest in the other link over all poses, among the pieces that
        may be cut; no piece if none is in the other link."""
        other_chunks = self.chunks[pair.other if link == pair.one else pair.one]
        worst, deepest = list[Chunk](), 0.0
        for chunk in self.chunks[link]:
            depth = sum(float(self._of(pair, link, chunk, other).sum()) for other in other_chunks)
            if depth > deepest and not chunk.is_final:
                worst, deepest = [chunk], depth
        return worst

    def _of(
        self, pair: Pair, link: int, chunk: Chunk, other: Chunk, within: Numbers | None = None
    ) -> Numbers:
        ends = (chunk, other) if link == pair.one else (other, chunk)
        return pair.of_chunks(*ends, within)

    def _cuts(self, pair: Pair, link: int, chunk: Chunk) -> Iterator[tuple[float, float, list[Chunk]]]:
        """Yields the best cuts of a piece: the share of its depths that is left, the volume, and the new
        pieces."""
        other_chunks = self.chunks[pair.other if link == pair.one else pair.one]
        depths_of = [(other, self._of(pair, link, chunk, other)) for other in other_chunks]
        total = sum(float(deep.sum()) for _, deep in depths_of)
        rough_rows = [
            (other, rows[:: max(1, len(rows) // _ROUGH_POSES)])
            for other, deep in depths_of
            if len(rows := np.flatnonzero(deep))
        ]

        def roughly(*sides: Points) -> tuple[float, float]:
            hulls = [hull for side in sides if (hull := engine_hull(side)) is not None]
            left = sum(
                float(self._rough_deeper(pair, link, hull, other, rows).sum())
                for hull, _ in hulls
                for other, rows in rough_rows
            )
            return round(left, 9), round(sum(volume for _, volume in hulls), 12)

        candidates = self._planes(pair, link, chunk, rough_rows)
        for _, (normal, height) in planes.ranked(candidates, chunk.cloud(), roughly)[:_EXACT_PLANES]:
            halves = [
                hull_chunk(side, self.max_vertices, chunk.collider_index)
                for side in cut_by_plane(chunk.surface, normal, height)
                if len(side.triangles)
            ]
            pieces = [half for half in halves if half is not None]
            if len(pieces) < len(halves):
                continue  # a flat side would be bare
            left = sum(
                float(self._of(pair, link, half, other, deep).sum())
                for half in pieces
                for other, deep in depths_of
            )
            yield round(left / total, 6), sum(half.volume for half in pieces), pieces

    def _rough_deeper(
        self, pair: Pair, link: int, hull: Any, other: Chunk, rows: npt.NDArray[np.int64]
    ) -> Numbers:
        return (
            pair.deeper(hull, other.convex, rows)
            if link == pair.one
            else pair.deeper(other.convex, hull, rows)
        )

    def _planes(
        self, pair: Pair, link: int, chunk: Chunk, rough_rows: Sequence[tuple[Chunk, Any]]
    ) -> list[planes.Plane]:
        if link not in self._faces:
            self._faces[link] = planes.flat_faces(
                join_surfaces([piece.surface for piece in self.chunks[link]])
            )
        axes = planes.axes_of(chunk.surface)
        cloud = chunk.cloud()

        def candidates() -> Iterator[planes.Plane]:
            yield from self._faces[link]
            yield from planes.through(axes, cloud)
            for other, rows in rough_rows:
                yield from planes.past_obstacles(axes, self._obstacles(pair, link, other, rows))

        return planes.crossing(candidates(), cloud)

    def _obstacles(self, pair: Pair, link: int, other: Chunk, rows: npt.NDArray[np.int64]) -> Points:
        """Returns the corners (k, n, 3) of the other link's piece in this link's frame in some poses."""
        poses = pair.one_from_other[rows]
        turns, shifts = poses[:, :3, :3], poses[:, :3, 3]
        corners = other.corners
        if link == pair.one:
            return np.asarray(np.einsum("kij,nj->kni", turns, corners) + shifts[:, None])
        return np.asarray(np.einsum("kji,knj->kni", turns, corners[None] - shifts[:, None]))

    def merge(self) -> None:
        """Joins pieces of each link, first those that add the least volume, as long as no pair gets worse."""
        for link in range(len(self.chunks)):
            self.merge_link(link)
            self._put_primitives_back(link)

    def _put_primitives_back(self, link: int) -> None:
        """Replaces hulls by their primitives again, if no pair gets worse."""
        for hull in [chunk for chunk in self.chunks[link] if chunk in self.primitives]:
            chunks = [self.primitives[hull] if chunk is hull else chunk for chunk in self.chunks[link]]
            if self.no_worse(link, chunks):
                self.chunks[link] = chunks

    def no_worse(self, link: int, chunks: Sequence[Chunk]) -> bool:
        """Tells whether each pair of a link is good enough, or no worse than now, with these pieces."""
        return all(
            pair.badness(self.deeper(pair, {link: chunks}))
            <= max(pair.allowed, pair.badness(self.deeper(pair)))
            for pair in self.of[link]
        )

    def merge_link(self, link: int) -> None:
        """Joins pieces of one link, as `merge` does."""
        if self.may[link]:
            growths: dict[tuple[Chunk, Chunk], float] = {}
            while self._merge_two(link, growths):
                pass

    def _merge_two(self, link: int, growths: dict[tuple[Chunk, Chunk], float]) -> bool:
        """Joins two pieces of a link, if that makes no pair worse; returns whether it did. `growths`: the
        volume that joining two pieces adds, infinite if it makes a pair worse."""
        chunks = [chunk for chunk in self.chunks[link] if not chunk.is_final]
        pairs = [
            (first, second)
            for first, second in combinations(chunks, 2)
            if first.collider_index == second.collider_index
        ]
        for first, second in pairs:
            if (first, second) not in growths:
                hull = hull_of(np.concatenate([first.corners, second.corners]))
                growth = np.inf if hull is None else round(hull.volume - first.volume - second.volume, 12)
                growths[first, second] = growth
        for first, second in sorted(pairs, key=lambda pair: growths[pair]):
            if growths[first, second] == np.inf:
                break
            joined_chunk = hull_chunk(
                join_surfaces([first.surface, second.surface]), self.max_vertices, first.collider_index
            )
            rest = [chunk for chunk in self.chunks[link] if chunk not in (first, second)]
            if joined_chunk is not None and self.no_worse(link, [*rest, joined_chunk]):
                self._replace(link, [first, second], [joined_chunk])
                return True
            growths[first, second] = np.inf
        return False
