"""The kinematic tree: which mates carry the tree, which close loops, which body is the root."""

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

import networkx as nx

from stages.graph.assembly import Assembly, Mate, Path
from stages.graph.bodies import Bodies
from stages.graph.naming import Names
from stages.robot.errors import Diagnostic, Disconnected, NoRoot
from stages.robot.names import legal

CUT_LATER = {"SLIDER": 0, "REVOLUTE": 1}
"""Mates that go into the tree first; the last are the first to be cut."""


@dataclass(frozen=True, slots=True)
class Edge:
    """A tree mate from a parent body to a child body."""

    mate: Mate
    parent: int
    child: int


@dataclass(frozen=True, slots=True)
class Tree:
    """`order`: bodies, root first, a parent before its children; `cut`: mates that close loops."""

    root: int
    order: tuple[int, ...]
    edges: tuple[Edge, ...]
    cut: tuple[Mate, ...]


def spanning_tree(
    bodies: Bodies, names: Names, root: int, related: Collection[tuple[Path, str]], assembly: Assembly
) -> Tree:
    """The tree that keeps what a user drives: relations, then limited mates, sliders before turns.

    Kruskal over a total order of the mates, so neither the root nor the order of features decides
    what is cut; mates that nobody limits or drives close the loops.
    """

    def rank(mate: Mate) -> tuple[object, ...]:
        key = (mate.ref.owner, mate.ref.feature)
        name = names.joints[key]
        return (CUT_LATER[mate.ref.type], key not in related, not mate.limits, natural(name), name)

    forest = nx.utils.UnionFind(range(len(bodies.members)))
    kept: nx.MultiGraph = nx.MultiGraph()
    kept.add_nodes_from(range(len(bodies.members)))
    cut = []
    for mate in sorted(bodies.moving, key=rank):
        first, second = (bodies.of[entity.path] for entity in mate.entities)
        if forest[first] == forest[second]:
            cut.append(mate)
        else:
            forest.union(first, second)
            kept.add_edge(first, second, mate=mate)
    order, edges = _walk(kept, root, names)
    if len(order) < len(bodies.members):
        raise _disconnected(assembly, bodies, names, root, set(order))
    return Tree(root, tuple(order), tuple(edges), tuple(cut))


def _walk(kept: nx.MultiGraph, root: int, names: Names) -> tuple[list[int], list[Edge]]:
    """Depth first, children by the names of their joints: the order of every exported file."""
    order, edges, seen = [root], [], {root}
    stack = [_branches(kept, root, names)]
    while stack:
        step = next(stack[-1], None)
        if step is None:
            stack.pop()
        elif step[1] not in seen:
            mate, child, parent = step
            seen.add(child)
            order.append(child)
            edges.append(Edge(mate, parent, child))
            stack.append(_branches(kept, child, names))
    return order, edges


def _branches(kept: nx.MultiGraph, body: int, names: Names) -> Iterator[tuple[Mate, int, int]]:
    steps = [(data["mate"], other, body) for _, other, data in kept.edges(body, data=True)]
    steps.sort(key=lambda step: natural(names.joints[step[0].ref.owner, step[0].ref.feature]))
    return iter(steps)


def natural(name: str) -> tuple[tuple[int, int | str], ...]:
    """A sort key in which "joint_10" comes after "joint_2"."""
    return tuple((0, int(text)) if text.isdigit() else (1, text) for text in re.split(r"(\d+)", name))


def _disconnected(
    assembly: Assembly, bodies: Bodies, names: Names, root: int, reached: set[int]
) -> Disconnected:
    loose = [body for body in range(len(bodies.members)) if body not in reached]
    problems = [
        Diagnostic(
            "E-LOOSE",
            f"{len(bodies.members[body])} part(s) hang on nothing that reaches the root",
            assembly.occurrences[min(bodies.members[body])].title,
        )
        for body in sorted(loose, key=lambda body: names.links[body])
    ]
    msg = f"{len(loose)} of {len(bodies.members)} bodies are not connected to the root {names.links[root]!r}"
    hint = "mate them in Onshape (a FASTENED mate makes two parts one link), or suppress them"
    return Disconnected(msg, hint=hint, problems=problems)


def choose_root(
    select: str, assembly: Assembly, bodies: Bodies, names: Names, weights: Sequence[float]
) -> int:
    """The root body: `auto` is the fixed one, else the heaviest; else the one that `select` names.

    `select` is a glob over link names and instance names ("Base plate*", "base_plate").
    """
    if select == "auto":
        if bodies.world is not None:
            return bodies.world
        return min(range(len(weights)), key=lambda body: (-weights[body], names.links[body]))
    hits = _matches(select, assembly, bodies, names)
    if len(hits) == 1:
        return next(iter(hits))
    found = ", ".join(sorted(names.links[body] for body in hits or range(len(names.links))))
    msg = f"{len(hits) or 'no'} links match {select!r}"
    hint = f"name one of: {found}"
    raise NoRoot(msg, where="root.select", hint=hint)


def _matches(select: str, assembly: Assembly, bodies: Bodies, names: Names) -> set[int]:
    by_link = {body for body, name in enumerate(names.links) if fnmatchcase(name, select)}
    if by_link:
        return by_link
    hits = set()
    for body, members in enumerate(bodies.members):
        for path in members:
            for depth in range(1, len(path) + 1):
                title = assembly.occurrences[path[:depth]].names[-1]
                if fnmatchcase(title, select) or fnmatchcase(legal(title), select):
                    hits.add(body)
    return hits


def weights(masses: Mapping[Path, float], bodies: Bodies) -> list[float]:
    """Mass [kg] of each body."""
    return [sum(masses[path] for path in members) for members in bodies.members]
