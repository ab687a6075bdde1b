"""The search: pieces are cut where links are false, and merged where no pair gets worse."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations, product
from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Points, joined
from linkwright.stages.mesh.by_contact.pair import Numbers, Pair
from linkwright.stages.mesh.cut import planes
from linkwright.stages.mesh.cut.cutting import cut
from linkwright.stages.mesh.cut.piece import Chunk, hull_of, hulled, rough

_LOOK = 20
"""Poses by which planes are told apart."""

_EXACT = 3
"""Planes that are tried in all poses."""

_GAIN = 0.97
"""A cut that leaves a larger share of the depths that it is to take away is in vain."""

MOST = 14
"""Pieces of a link while it is cut: some are joined again."""

_VAIN = 2
"""Cuts one after the other that may leave more."""


class PieceSearch:
    """`chunks`: the pieces of each link; `may`: whether they may be cut; `hulls`: those of the primitives."""

    def __init__(
        self,
        chunks: Sequence[Sequence[Chunk]],
        may: Sequence[bool],
        pairs: Sequence[Pair],
        max_vertices: int,
        hulls: Mapping[Chunk, Chunk],
    ) -> None:
        self.chunks = [list(every) for every in chunks]
        self.may, self.pairs, self.max_vertices = may, list(pairs), max_vertices
        self.hulls = hulls
        self.primitives = {hull: primitive for primitive, hull in hulls.items()}
        self.of: list[list[Pair]] = [[] for _ in chunks]
        for pair in self.pairs:
            self.of[pair.one].append(pair)
            self.of[pair.other].append(pair)
        self._faces: dict[int, list[planes.Plane]] = {}

    def deeper(self, pair: Pair, chunks: dict[int, Sequence[Chunk]] | None = None) -> Numbers:
        """(n,): the most that two pieces of a pair are deeper in each other than is borne, with other pieces
        for some links where they are given."""
        sides = [(chunks or {}).get(link, self.chunks[link]) for link in (pair.one, pair.other)]
        found = np.zeros(len(pair.borne))
        for one, other in product(*sides):
            found = np.maximum(found, pair.of_chunks(one, other))
        return found

    def bad(self) -> list[tuple[int, Pair]]:
        """The pairs that are false too often, the worst first."""
        rated = [(pair.badness(self.deeper(pair)), pair) for pair in self.pairs if not pair.stuck]
        found = [(badness, pair) for badness, pair in rated if badness > pair.allowed]
        return sorted(found, key=lambda one: (-one[0], one[1].one, one[1].other))

    def refine(self, parts: Callable[[int], Sequence[Chunk]]) -> None:
        """Cuts until no pair is false too often, but those that cuts do not improve. A link that is stuck
        begins anew with a piece for each of its `parts`."""
        self._without_primitives()
        self._cut_all()
        anew = sorted({link for pair in self.pairs if pair.stuck for link in (pair.one, pair.other)})
        for link in anew:
            if self.may[link] and len(apart := parts(link)) > 1:
                self.chunks[link] = list(apart)
                self.merge_link(link)
        for pair in self.pairs:
            pair.stuck, pair.vain = False, 0
        self._cut_all()

    def _without_primitives(self) -> None:
        """A primitive of a pair that is false too often, which is larger than the hull, becomes the hull."""
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
        """Whether a piece of one of the two was cut."""
        best: tuple[float, float, int, Chunk, list[Chunk]] | None = None
        for link in (pair.one, pair.other):
            if not self.may[link] or len(self.chunks[link]) >= MOST:
                continue
            for chunk in self._worst(pair, link):
                for score, volume, made in self._cuts(pair, link, chunk):
                    if best is None or (score, volume) < best[:2]:
                        best = score, volume, link, chunk, made
        if best is None:
            return False
        # Of a slot no single cut is better, but the next one may be: what was in vain is merged again.
        pair.vain = 0 if best[0] <= _GAIN else pair.vain + 1
        if pair.vain > _VAIN:
            return False
        _, _, link, chunk, made = best
        self._replace(link, [chunk], made)
        return True

    def _replace(self, link: int, old: Sequence[Chunk], new: Sequence[Chunk]) -> None:
        at = min(self.chunks[link].index(one) for one in old)
        rest = [one for one in self.chunks[link] if one not in old]
        self.chunks[link] = [*rest[:at], *new, *rest[at:]]

    def _worst(self, pair: Pair, link: int) -> list[Chunk]:
        """The piece of a link that is deepest in the other in all, if it may be cut."""
        theirs = self.chunks[pair.other if link == pair.one else pair.one]
        found, most = list[Chunk](), 0.0
        for chunk in self.chunks[link]:
            depth = sum(float(self._of(pair, link, chunk, other).sum()) for other in theirs)
            if depth > most and not chunk.stays:
                found, most = [chunk], depth
        return found

    def _of(
        self, pair: Pair, link: int, chunk: Chunk, other: Chunk, within: Numbers | None = None
    ) -> Numbers:
        ends = (chunk, other) if link == pair.one else (other, chunk)
        return pair.of_chunks(*ends, within)

    def _cuts(self, pair: Pair, link: int, chunk: Chunk) -> Iterator[tuple[float, float, list[Chunk]]]:
        """What is left of the depths of a piece, as a share, by the best cuts; their volumes; and the two new
        pieces."""
        theirs = self.chunks[pair.other if link == pair.one else pair.one]
        own = [(other, self._of(pair, link, chunk, other)) for other in theirs]
        total = sum(float(deep.sum()) for _, deep in own)
        looked = [
            (other, rows[:: max(1, len(rows) // _LOOK)])
            for other, deep in own
            if len(rows := np.flatnonzero(deep))
        ]

        def roughly(*sides: Points) -> tuple[float, float]:
            hulls = [hull for side in sides if (hull := rough(side)) is not None]
            left = sum(
                float(self._rough_deeper(pair, link, hull, other, rows).sum())
                for hull, _ in hulls
                for other, rows in looked
            )
            return round(left, 9), round(sum(volume for _, volume in hulls), 12)

        every = self._planes(pair, link, chunk, looked)
        for _, (normal, height) in planes.ranked(every, chunk.cloud(), roughly)[:_EXACT]:
            halves = [
                hulled(side, self.max_vertices, chunk.group)
                for side in cut(chunk.surface, normal, height)
                if len(side.triangles)
            ]
            made = [half for half in halves if half is not None]
            if len(made) < len(halves):
                continue  # a flat side would be bare
            left = sum(
                float(self._of(pair, link, half, other, deep).sum()) for half in made for other, deep in own
            )
            yield round(left / total, 6), sum(half.volume for half in made), made

    def _rough_deeper(
        self, pair: Pair, link: int, mine: Any, other: Chunk, rows: npt.NDArray[np.int64]
    ) -> Numbers:
        return (
            pair.deeper(mine, other.convex, rows)
            if link == pair.one
            else pair.deeper(other.convex, mine, rows)
        )

    def _planes(
        self, pair: Pair, link: int, chunk: Chunk, looked: Sequence[tuple[Chunk, Any]]
    ) -> list[planes.Plane]:
        if link not in self._faces:
            self._faces[link] = planes.flat_faces(joined([one.surface for one in self.chunks[link]]))
        axes = planes.axes_of(chunk.surface)
        cloud = chunk.cloud()

        def every() -> Iterator[planes.Plane]:
            yield from self._faces[link]
            yield from planes.through(axes, cloud)
            for other, rows in looked:
                yield from planes.past(axes, self._obstacles(pair, link, other, rows))

        return planes.crossing(every(), cloud)

    def _obstacles(self, pair: Pair, link: int, other: Chunk, rows: npt.NDArray[np.int64]) -> Points:
        """(k, n, 3): the corners of another link's piece in this link's frame in some poses."""
        poses = pair.one_from_other[rows]
        turns, shifts = poses[:, :3, :3], poses[:, :3, 3]
        corners = other.corners
        if link == pair.one:
            return np.asarray(np.einsum("kij,nj->kni", turns, corners) + shifts[:, None])
        return np.asarray(np.einsum("kji,knj->kni", turns, corners[None] - shifts[:, None]))

    def merge(self) -> None:
        """Joins pieces of a link, those first that add the least volume, as long as no pair gets worse."""
        for link in range(len(self.chunks)):
            self.merge_link(link)
            self._put_primitives_back(link)

    def _put_primitives_back(self, link: int) -> None:
        """Primitives in the place of their hulls, where no pair gets worse."""
        for hull in [chunk for chunk in self.chunks[link] if chunk in self.primitives]:
            made = [self.primitives[hull] if chunk is hull else chunk for chunk in self.chunks[link]]
            if self.no_worse(link, made):
                self.chunks[link] = made

    def no_worse(self, link: int, chunks: Sequence[Chunk]) -> bool:
        """Whether these pieces leave each pair of a link good enough, or as bad as it is."""
        return all(
            pair.badness(self.deeper(pair, {link: chunks}))
            <= max(pair.allowed, pair.badness(self.deeper(pair)))
            for pair in self.of[link]
        )

    def merge_link(self, link: int) -> None:
        """The same of one link."""
        if self.may[link]:
            growths: dict[tuple[Chunk, Chunk], float] = {}
            while self._merged(link, growths):
                pass

    def _merged(self, link: int, growths: dict[tuple[Chunk, Chunk], float]) -> bool:
        """Whether two pieces were joined. `growths`: what joining two adds to their volume, infinite where it
        makes a pair worse."""
        chunks = [one for one in self.chunks[link] if not one.stays]
        pairs = [(one, other) for one, other in combinations(chunks, 2) if one.group == other.group]
        for one, other in pairs:
            if (one, other) not in growths:
                made = hull_of(np.concatenate([one.corners, other.corners]))
                growth = np.inf if made is None else round(made.volume - one.volume - other.volume, 12)
                growths[one, other] = growth
        for one, other in sorted(pairs, key=lambda pair: growths[pair]):
            if growths[one, other] == np.inf:
                break
            both = hulled(joined([one.surface, other.surface]), self.max_vertices, one.group)
            rest = [chunk for chunk in self.chunks[link] if chunk not in (one, other)]
            if both is not None and self.no_worse(link, [*rest, both]):
                self._replace(link, [one, other], [both])
                return True
            growths[one, other] = np.inf
        return False
