"""Chooses the kinematic tree: the connections in it, those that close loops, and the order of the bodies."""

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Literal

import networkx as nx

from linkwright.stages.graph.mechanism import Connection, Mechanism
from linkwright.stages.graph.root import choose_root, heaviest
from linkwright.stages.graph.section import GraphSections, RootSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import Diagnostic, Disconnected
from linkwright.stages.robot.model.robot import Array, JointType
from linkwright.stages.robot.text.globs import matches_glob, no_match_hint
from linkwright.stages.robot.text.plural import count

CUT_LAST: dict[JointType, int] = {"prismatic": 0, "revolute": 2, "ball": 3, "fixed": 4}
"""Rank of connections (other types: 1): those of the smallest rank go into the tree first, so that those of
the largest are cut."""

_JOIN_HINT = "connect it by a joint in the file, or remove it"

IDLE_FEATURE_CODES = ("W-MATE-BROKEN", "W-FEATURE", "W-PATTERN", "W-PEER-MATE")
"""Codes of features that connect nothing: they are reported again with unconnected parts, as a possible
reason."""


@dataclass(frozen=True, slots=True)
class Edge:
    """An edge from a parent body to a child body: a connection, or the fixed or free joint in its place."""

    parent: int
    child: int
    connection: Connection | None
    replacement: Literal["fixed", "free"] = "fixed"


@dataclass(frozen=True, slots=True, eq=False)
class Tree:
    """The kinematic tree of a mechanism."""

    root: int
    world_from_root: Array
    order: tuple[int, ...]
    """Bodies, the root first, a parent before its children."""
    edges: tuple[Edge, ...]
    cut: tuple[Connection, ...]
    """Connections that close loops."""


def spanning_tree(mechanism: Mechanism, keys: GraphSections, log: Diagnostics) -> Tree:
    """Returns the spanning tree, by Kruskal's algorithm over a total order of the connections, so that
    neither the root nor the order of features decides which are cut. Connections with relations and those
    with limits stay in the tree if possible, and mates without them close the loops, unless `loops.cut` names
    others (see `rank`).
    """
    root, world_from_root = choose_root(mechanism, keys.root)
    graph, cut = _forest(mechanism, keys.loops.cut, log)
    _report_uncut(mechanism, keys.loops.cut, cut, log)
    by_number = mechanism.mjcf is not None
    order, edges = _walk(graph, root, by_number)
    islands = _islands(mechanism, graph, set(order))
    if islands and keys.root.disconnected == "error":
        raise _disconnected_error(mechanism, root, islands, log)
    for island in islands:
        _report_island(mechanism, island, keys.root, log)
        island_order, island_edges = _island_tree(mechanism, graph, root, island, keys.root)
        order, edges = [*order, *island_order], [*edges, *island_edges]
    cut = [connection for connection in cut if set(order).issuperset(connection.bodies)]
    return Tree(root, world_from_root, tuple(order), tuple(edges), tuple(cut))


def _forest(
    mechanism: Mechanism, cut: Collection[str], log: Diagnostics
) -> tuple[nx.MultiGraph, list[Connection]]:
    """Returns the connections that join bodies, as a graph without circles, and those that close loops in
    it."""
    forest = nx.utils.UnionFind(range(len(mechanism.bodies)))
    graph: nx.MultiGraph = nx.MultiGraph()
    graph.add_nodes_from(range(len(mechanism.bodies)))
    loop_closures = []
    for connection in _by_rank(mechanism, cut, log):
        first, second = connection.bodies
        if forest[first] == forest[second]:
            loop_closures.append(connection)
        else:
            forest.union(first, second)
            graph.add_edge(first, second, connection=connection)
    return graph, loop_closures


def _by_rank(mechanism: Mechanism, cut: Collection[str], log: Diagnostics) -> list[Connection]:
    """Returns the connections in the order in which they go into the tree."""
    related_names = {name for spec in mechanism.relations for name in spec.connections}
    for glob in cut:
        if not any(_has_name(connection, glob) for connection in mechanism.connections):
            hint = no_match_hint(
                glob, {"mates that move": [connection.name for connection in mechanism.connections]}
            )
            log.report_unmatched("E-GLOB", f"no mate matches {glob!r}", "loops.cut", hint, glob)

    def sort_key(connection: Connection) -> tuple[object, ...]:
        return (
            any(_has_name(connection, glob) for glob in cut),
            connection.closes,
            CUT_LAST.get(connection.type, 1),
            connection.name not in related_names,
            not connection.has_limits,
            natural(connection.name),
            connection.name,
        )

    return sorted(mechanism.connections, key=sort_key)


def _has_name(connection: Connection, glob: str) -> bool:
    return any(matches_glob(name, glob) for name in (connection.name, connection.ref.name, connection.title))


def _report_uncut(
    mechanism: Mechanism, globs: Collection[str], cut: Collection[Connection], log: Diagnostics
) -> None:
    """Reports W-LOOP-CUT for a mate of `globs` that is not cut: it closes no loop, or another mate closes
    it."""
    for glob in globs:
        names = [connection.title for connection in mechanism.connections if _has_name(connection, glob)]
        if glob != "*" and names and not any(_has_name(connection, glob) for connection in cut):
            text = f"{', '.join(sorted(names))} closes no loop, so it remains in the tree"
            log.report("W-LOOP-CUT", text, "loops.cut", "remove it from loops.cut")


def _walk(graph: nx.MultiGraph, root: int, by_number: bool = False) -> tuple[list[int], list[Edge]]:
    """Returns the bodies and edges depth first, in the order of every exported file: children by the names of
    their joints, or with `by_number` by their own numbers."""
    order: list[int] = [root]
    edges: list[Edge] = []
    visited = {root}
    stack = [_branches(graph, root, by_number)]
    while stack:
        edge = next(stack[-1], None)
        if edge is None:
            stack.pop()
        elif edge.child not in visited:
            visited.add(edge.child)
            order.append(edge.child)
            edges.append(edge)
            stack.append(_branches(graph, edge.child, by_number))
    return order, edges


def _branches(graph: nx.MultiGraph, body: int, by_number: bool) -> Iterator[Edge]:
    edges = [Edge(body, other, data["connection"]) for _, other, data in graph.edges(body, data=True)]
    if by_number:
        return iter(sorted(edges, key=lambda edge: edge.child))
    return iter(sorted(edges, key=lambda edge: natural(edge.connection.name if edge.connection else "")))


def natural(name: str) -> tuple[tuple[int, int, str], ...]:
    """Returns a sort key in which "joint_10" comes after "joint_2"."""
    return tuple(
        (0, len(text.lstrip("0")), text.lstrip("0")) if text.isdecimal() else (1, 0, text)
        for text in re.split(r"(\d+)", name)
    )


def _islands(mechanism: Mechanism, graph: nx.MultiGraph, reached: set[int]) -> list[list[int]]:
    """Returns bodies that are not connected to the root, in groups that are connected with each other."""
    islands = [sorted(group) for group in nx.connected_components(graph) if reached.isdisjoint(group)]
    return sorted(islands, key=lambda island: min(mechanism.bodies[body].name for body in island))


def _disconnected_error(
    mechanism: Mechanism, root: int, islands: list[list[int]], log: Diagnostics
) -> Disconnected:
    bodies = mechanism.bodies
    problems = [diagnostic for diagnostic in log.notes if diagnostic.code in IDLE_FEATURE_CODES]
    for island in islands:
        parts = sorted(part.name for body in island for part in bodies[body].parts)
        names = ", ".join(sorted(bodies[body].name for body in island))
        text = f"{_count_and_verb(len(parts), 'part')} not connected to the root: {names}"
        where = parts[0] if parts else names
        hint = "mate it in Onshape (a FASTENED mate makes two parts one link), or suppress it"
        if not mechanism.has_saved_pose:
            text = f"{_count_and_verb(len(island), 'link')} not connected to the root"
            where, hint = names, _JOIN_HINT
        problems.append(Diagnostic("E-LOOSE", text, where, hint))
    total = sum(len(island) for island in islands)
    verb = "is" if total == 1 else "are"
    msg = f"{total} of {len(bodies)} bodies {verb} not connected to the root {bodies[root].name!r}"
    hint = (
        "or choose for all of them, root.disconnected: weld (fixed to the root), drop (left out), separate "
        "(floating on their own)"
    )
    return Disconnected(msg, hint=hint, problems=problems)


def _count_and_verb(number: int, noun: str) -> str:
    return f"{count(number, noun)} {'is' if number == 1 else 'are'}"


def _report_island(mechanism: Mechanism, island: list[int], keys: RootSection, log: Diagnostics) -> None:
    names = ", ".join(sorted(mechanism.bodies[body].name for body in island))
    treatments = {"drop": "left out", "weld": "fixed to the root", "separate": "floating on its own"}
    text = f"{names}: {treatments[keys.disconnected]}, as it is not connected to the root"
    hint = "mate it to the robot in Onshape, or suppress it" if mechanism.has_saved_pose else _JOIN_HINT
    log.report("I-LOOSE", text, f"root.disconnected: {keys.disconnected}", hint)


def _island_tree(
    mechanism: Mechanism, graph: nx.MultiGraph, root: int, island: list[int], keys: RootSection
) -> tuple[list[int], list[Edge]]:
    """Returns the bodies of an island in order, and their edges, the first of which comes from the root; both
    are empty if islands are dropped."""
    if keys.disconnected == "drop":
        return [], []
    fixed_bodies = [body for body in island if mechanism.bodies[body].fixed_reason]
    floating_bodies = [body for body in island if mechanism.bodies[body].floating_joint is not None]
    # A file says which of its links is a parent: the links of a loose tree keep their frames.
    children = {edge["connection"].bodies[0] for *_, edge in graph.edges(island, data=True)}
    tops = [] if mechanism.has_saved_pose else [body for body in island if body not in children]
    head = heaviest(mechanism, fixed_bodies or floating_bodies or tops or island)
    order, edges = _walk(graph, head)
    replacement: Literal["fixed", "free"] = "fixed" if keys.disconnected == "weld" else "free"
    return order, [Edge(root, head, None, replacement), *edges]
