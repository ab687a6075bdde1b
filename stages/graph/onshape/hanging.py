"""What hangs on the seeds of a pattern, rather than holds them.

A copy of a wheel stands on the axle that its seed stands on, but the cap on the seed is not held by the
copy as well. Once the seeds are taken away, one of the pieces that are left holds them: the piece with
the assembly's origin, or with something that is fixed, else the one with the most parts. That a seed
is fixed itself says nothing of its copies: they are not.
"""

from collections import Counter
from collections.abc import Collection

import networkx as nx

from stages.graph.onshape.assembly import Assembly, Path


class Hanging:
    """Looks at the instances of each assembly, and at what of its own holds them together."""

    def __init__(self, assembly: Assembly) -> None:
        self.links: dict[Path, list[frozenset[Path]]] = {}
        self.drawn: dict[tuple[Path, Path], list[frozenset[Path]]] = {}
        for mate in assembly.mates:
            self._link(mate.ref.owner, [entity.path for entity in mate.entities])
        for group in assembly.groups:
            self._link(group.owner, group.members)
        for path in (path for path, occurrence in assembly.occurrences.items() if occurrence.fixed):
            for depth in range(len(path)):
                self.links.setdefault(path[:depth], []).append(frozenset([path[:depth], path[: depth + 1]]))
        self.parts = Counter(
            part.path[:depth] for part in assembly.parts for depth in range(1, len(part.path) + 1)
        )

    def _link(self, owner: Path, places: Collection[Path]) -> None:
        """A feature that holds places together: instances of `owner`, what lies in them, or `owner`."""
        link = frozenset(place[: len(owner) + 1] for place in places)
        self.links.setdefault(owner, []).append(link)
        for place in link:
            self.drawn.setdefault((owner, place), []).append(link)

    def on(self, seeds: Collection[Path], owner: Path) -> frozenset[Path]:
        """The instances of `owner` that hang on its instances `seeds`; none where two pieces of the same
        size might hold them."""
        taken = frozenset(seeds)
        beside = {
            place for seed in taken for link in self.drawn.get((owner, seed), ()) for place in link
        } - taken
        if len(beside) < 2:
            return frozenset()
        pieces = nx.utils.UnionFind([owner, *beside])
        for link in self.links[owner]:
            pieces.union(*(link - taken))
        holder = pieces[owner]
        if all(pieces[place] != holder for place in beside):
            sizes = Counter({pieces[place]: 0 for place in beside})
            for place in {place for link in self.links[owner] for place in link} - taken:
                if pieces[place] in sizes:
                    sizes[pieces[place]] += self.parts[place]
            (holder, most), *others = sizes.most_common(2)
            if others and others[0][1] == most:
                return frozenset()
        return frozenset(place for place in beside if pieces[place] != holder)
