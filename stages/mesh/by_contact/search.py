"""Searches for the pieces of links: it cuts pieces of false pairs, and merges pieces if no pair gets
worse."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations, product
from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, join_surfaces
from linkwright.stages.mesh.by_contact.pair import LinkPair, Numbers
from linkwright.stages.mesh.cut import planes
from linkwright.stages.mesh.cut.chunk import Chunk, engine_hull, hull_chunk, qhull
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
    """The pieces of all links while they are cut and merged. `chunks`: the pieces of each link; `may_cut`:
    whether each link may be cut; `hulls`: primitive → its hull."""

    def __init__(
        self,
        chunks: Sequence[Sequence[Chunk]],
        may_cut: Sequence[bool],
        pairs: Sequence[LinkPair],
        max_vertices: int,
        hulls: Mapping[Chunk, Chunk],
    ) -> None:
        self.chunks = [list(link_chunks) for link_chunks in chunks]
        self.may_cut, self.pairs, self.max_vertices = may_cut, list(pairs), max_vertices
        self.hulls = hulls
        self.primitives = {hull: primitive for primitive, hull in hulls.items()}
        self.pairs_of_link: list[list[LinkPair]] = [[] for _ in chunks]
        for pair in self.pairs:
            self.pairs_of_link[pair.first_link].append(pair)
            self.pairs_of_link[pair.second_link].append(pair)
        self._faces: dict[int, list[planes.Plane]] = {}

    def excess_depths(self, pair: LinkPair, chunks: dict[int, Sequence[Chunk]] | None = None) -> Numbers:
        """Returns, for each pose, the largest excess depth (n,) [m] of two pieces of a pair. `chunks`: link →
        pieces to use instead of its present pieces."""
        sides = [(chunks or {}).get(link, self.chunks[link]) for link in (pair.first_link, pair.second_link)]
        deepest = np.zeros(len(pair.allowed_depths))
        for first, second in product(*sides):
            deepest = np.maximum(deepest, pair.chunk_excess_depths(first, second))
        return deepest

    def false_pairs(self) -> list[tuple[int, LinkPair]]:
        """Returns the pairs that touch falsely in too many poses, the worst first."""
        badness_by_pair = [
            (pair.badness(self.excess_depths(pair)), pair) for pair in self.pairs if not pair.is_stuck
        ]
        pairs = [(badness, pair) for badness, pair in badness_by_pair if badness > pair.max_false_poses]
        return sorted(pairs, key=lambda entry: (-entry[0], entry[1].first_link, entry[1].second_link))

    def refine(self, parts: Callable[[int], Sequence[Chunk]]) -> None:
        """Cuts until no pair is false too often, except pairs that cuts do not improve. Links of such pairs
        begin again with a piece for each of their `parts`."""
        self._replace_primitives_by_hulls()
        self._cut_all()
        stuck = sorted(
            {link for pair in self.pairs if pair.is_stuck for link in (pair.first_link, pair.second_link)}
        )
        for link in stuck:
            if self.may_cut[link] and len(part_chunks := parts(link)) > 1:
                self.chunks[link] = list(part_chunks)
                self.merge_link(link)
        for pair in self.pairs:
            pair.is_stuck, pair.vain_cuts = False, 0
        self._cut_all()

    def _replace_primitives_by_hulls(self) -> None:
        """Replaces the primitives of pairs that are false too often by their hulls, which are smaller."""
        for _, pair in self.false_pairs():
            for link in (pair.first_link, pair.second_link):
                self.chunks[link] = [self.hulls.get(chunk, chunk) for chunk in self.chunks[link]]

    def _cut_all(self) -> None:
        while false_pairs := self.false_pairs():
            for _, pair in false_pairs:
                if self._cut(pair):
                    break
                pair.is_stuck = True
            else:
                break

    def _cut(self, pair: LinkPair) -> bool:
        """Cuts a piece of one of the two links, if that may help; returns whether it did."""
        best: tuple[float, float, int, Chunk, list[Chunk]] | None = None
        for link in (pair.first_link, pair.second_link):
            if not self.may_cut[link] or len(self.chunks[link]) >= MAX_PIECES:
                continue
            for chunk in self._worst(pair, link):
                for score, volume, pieces in self._cuts(pair, link, chunk):
                    if best is None or (score, volume) < best[:2]:
                        best = score, volume, link, chunk, pieces
        if best is None:
            return False
        # For a slot no single cut helps, but the next may; the pieces of a vain cut are merged again later.
        pair.vain_cuts = 0 if best[0] <= _MAX_LEFT_SHARE else pair.vain_cuts + 1
        if pair.vain_cuts > _MAX_VAIN_CUTS:
            return False
        _, _, link, chunk, pieces = best
        self._replace(link, [chunk], pieces)
        return True

    def _replace(self, link: int, old: Sequence[Chunk], new: Sequence[Chunk]) -> None:
        position = min(self.chunks[link].index(chunk) for chunk in old)
        other_chunks = [chunk for chunk in self.chunks[link] if chunk not in old]
        self.chunks[link] = [*other_chunks[:position], *new, *other_chunks[position:]]

    def _worst(self, pair: LinkPair, link: int) -> list[Chunk]:
        """Returns the piece of a link that is deepest in the other link over all poses, among the pieces that
        may be cut; no piece if none is in the other link."""
        other_chunks = self.chunks[pair.second_link if link == pair.first_link else pair.first_link]
        worst, deepest = list[Chunk](), 0.0
        for chunk in self.chunks[link]:
            depth = sum(
                float(self._chunk_excess_depths(pair, link, chunk, other).sum()) for other in other_chunks
            )
            if depth > deepest and not chunk.is_final:
                worst, deepest = [chunk], depth
        return worst

    def _chunk_excess_depths(
        self, pair: LinkPair, link: int, chunk: Chunk, other: Chunk, within: Numbers | None = None
    ) -> Numbers:
        """Returns the excess depths (n,) [m] of a piece of `link` and a piece of the pair's other link."""
        ends = (chunk, other) if link == pair.first_link else (other, chunk)
        return pair.chunk_excess_depths(*ends, within)

    def _cuts(self, pair: LinkPair, link: int, chunk: Chunk) -> Iterator[tuple[float, float, list[Chunk]]]:
        """Yields the best cuts of a piece: the share of its depths that is left, the volume, and the new
        pieces."""
        other_chunks = self.chunks[pair.second_link if link == pair.first_link else pair.first_link]
        depths_by_chunk = [
            (other, self._chunk_excess_depths(pair, link, chunk, other)) for other in other_chunks
        ]
        total = sum(float(depths.sum()) for _, depths in depths_by_chunk)
        rough_rows = [
            (other, rows[:: max(1, len(rows) // _ROUGH_POSES)])
            for other, depths in depths_by_chunk
            if len(rows := np.flatnonzero(depths))
        ]

        def rough_score(*sides: Points) -> tuple[float, float]:
            hulls = [hull for side in sides if (hull := engine_hull(side)) is not None]
            left = sum(
                float(self._rough_excess_depths(pair, link, hull.solid, other, rows).sum())
                for hull in hulls
                for other, rows in rough_rows
            )
            return round(left, 9), round(sum(hull.volume for hull in hulls), 12)

        candidates = self._planes(pair, link, chunk, rough_rows)
        for _, (normal, height) in planes.ranked(candidates, chunk.cloud(), rough_score)[:_EXACT_PLANES]:
            halves = [
                hull_chunk(side, self.max_vertices, chunk.collider_index)
                for side in cut_by_plane(chunk.surface, normal, height)
                if len(side.triangles)
            ]
            pieces = [half for half in halves if half is not None]
            if len(pieces) < len(halves):
                continue  # A flat side would be left without a piece.
            left = sum(
                float(self._chunk_excess_depths(pair, link, half, other, depths).sum())
                for half in pieces
                for other, depths in depths_by_chunk
            )
            yield round(left / total, 6), sum(half.volume for half in pieces), pieces

    def _rough_excess_depths(
        self, pair: LinkPair, link: int, hull: Any, other: Chunk, rows: npt.NDArray[np.int64]
    ) -> Numbers:
        return (
            pair.excess_depths(hull, other.engine_solid, rows)
            if link == pair.first_link
            else pair.excess_depths(other.engine_solid, hull, rows)
        )

    def _planes(
        self, pair: LinkPair, link: int, chunk: Chunk, rough_rows: Sequence[tuple[Chunk, Any]]
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

    def _obstacles(self, pair: LinkPair, link: int, other: Chunk, rows: npt.NDArray[np.int64]) -> Points:
        """Returns the corners (k, n, 3) of the other link's piece in this link's frame in some poses."""
        poses = pair.first_from_second[rows]
        turns, shifts = poses[:, :3, :3], poses[:, :3, 3]
        corners = other.vertices
        if link == pair.first_link:
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
            pair.badness(self.excess_depths(pair, {link: chunks}))
            <= max(pair.max_false_poses, pair.badness(self.excess_depths(pair)))
            for pair in self.pairs_of_link[link]
        )

    def merge_link(self, link: int) -> None:
        """Joins pieces of one link, as `merge` does."""
        if self.may_cut[link]:
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
                hull = qhull(np.concatenate([first.vertices, second.vertices]))
                growth = np.inf if hull is None else round(hull.volume - first.volume - second.volume, 12)
                growths[first, second] = growth
        for first, second in sorted(pairs, key=lambda pair: growths[pair]):
            if growths[first, second] == np.inf:
                break
            joined_chunk = hull_chunk(
                join_surfaces([first.surface, second.surface]), self.max_vertices, first.collider_index
            )
            other_chunks = [chunk for chunk in self.chunks[link] if chunk not in (first, second)]
            if joined_chunk is not None and self.no_worse(link, [*other_chunks, joined_chunk]):
                self._replace(link, [first, second], [joined_chunk])
                return True
            growths[first, second] = np.inf
        return False
