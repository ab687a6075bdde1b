"""The kinematic tree: which connections are in the tree, which close loops, and the order of the bodies."""

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
from linkwright.stages.robot.text.globs import fits, there_are
from linkwright.stages.robot.text.plural import count

CUT_LAST: dict[JointType, int] = {"prismatic": 0, "revolute": 2, "ball": 3, "fixed": 4}
"""Connections go into the tree by this rank (others: 1); the last are the first to be cut."""

_JOIN = "connect it by a joint in the file, or remove it"

LEFT_OUT = ("W-MATE-BROKEN", "W-FEATURE", "W-PATTERN", "W-PEER-MATE")
"""Codes of what holds nothing: reported beside unconnected parts, as they may be the reason."""


@dataclass(frozen=True, slots=True)
class Edge:
    """From a parent body to a child body: a connection, or the fixed or free joint in its place."""

    parent: int
    child: int
    connection: Connection | None
    stand_in: Literal["fixed", "free"] = "fixed"


@dataclass(frozen=True, slots=True, eq=False)
class Tree:
    """`order`: bodies, root first, a parent before its children; `cut`: connections that close loops."""

    root: int
    world_from_root: Array
    order: tuple[int, ...]
    edges: tuple[Edge, ...]
    cut: tuple[Connection, ...]


def spanning_tree(mechanism: Mechanism, keys: GraphSections, log: Diagnostics) -> Tree:
    """The tree that keeps what a user drives: relations, then limited mates, sliders before turns.

    Kruskal over a total order of the connections, so neither the root nor the order of features decides
    the cuts; mates without limits and relations close the loops, unless `loops.cut` names others.
    """
    root, world_from_root = choose_root(mechanism, keys.root)
    kept, cut = _forest(mechanism, keys.loops.cut, log)
    _report_uncut(mechanism, keys.loops.cut, cut, log)
    in_order = mechanism.mjcf is not None
    order, edges = _walk(kept, root, in_order)
    islands = _islands(mechanism, kept, set(order))
    if islands and keys.root.disconnected == "error":
        raise _disconnected(mechanism, root, islands, log)
    for island in islands:
        _report_island(mechanism, island, keys.root, log)
        more, grown = _attached(mechanism, kept, root, island, keys.root)
        order, edges = [*order, *more], [*edges, *grown]
    cut = [connection for connection in cut if set(order).issuperset(connection.bodies)]
    return Tree(root, world_from_root, tuple(order), tuple(edges), tuple(cut))


def _forest(
    mechanism: Mechanism, cut: Collection[str], log: Diagnostics
) -> tuple[nx.MultiGraph, list[Connection]]:
    """The connections that join bodies, as a graph without circles, and those that close loops in it."""
    forest = nx.utils.UnionFind(range(len(mechanism.bodies)))
    kept: nx.MultiGraph = nx.MultiGraph()
    kept.add_nodes_from(range(len(mechanism.bodies)))
    closing = []
    for connection in _ranked(mechanism, cut, log):
        first, second = connection.bodies
        if forest[first] == forest[second]:
            closing.append(connection)
        else:
            forest.union(first, second)
            kept.add_edge(first, second, connection=connection)
    return kept, closing


def _ranked(mechanism: Mechanism, cut: Collection[str], log: Diagnostics) -> list[Connection]:
    """The connections, those that shall be in the tree first."""
    related = {name for spec in mechanism.relations for name in spec.connections}
    for glob in cut:
        if not any(_named(connection, glob) for connection in mechanism.connections):
            hint = there_are(glob, {"mates that move": [one.name for one in mechanism.connections]})
            log.unmatched("E-GLOB", f"no mate matches {glob!r}", "loops.cut", hint, glob)

    def rank(connection: Connection) -> tuple[object, ...]:
        return (
            any(_named(connection, glob) for glob in cut),
            connection.closes,
            CUT_LAST.get(connection.type, 1),
            connection.name not in related,
            not connection.limited,
            natural(connection.name),
            connection.name,
        )

    return sorted(mechanism.connections, key=rank)


def _named(connection: Connection, glob: str) -> bool:
    return any(fits(name, glob) for name in (connection.name, connection.ref.name, connection.title))


def _report_uncut(
    mechanism: Mechanism, wanted: Collection[str], cut: Collection[Connection], log: Diagnostics
) -> None:
    """W-LOOP-CUT for a mate that is not cut as wanted: it closes no loop, or another mate does."""
    for glob in wanted:
        names = [connection.title for connection in mechanism.connections if _named(connection, glob)]
        if glob != "*" and names and not any(_named(connection, glob) for connection in cut):
            what = f"{', '.join(sorted(names))} closes no loop, so it remains in the tree"
            log.report("W-LOOP-CUT", what, "loops.cut", "remove it from loops.cut")


def _walk(kept: nx.MultiGraph, root: int, in_order: bool = False) -> tuple[list[int], list[Edge]]:
    """Depth first, children by the names of their joints, or `in_order` by their numbers: the order of every
    exported file."""
    order: list[int] = [root]
    edges: list[Edge] = []
    seen = {root}
    stack = [_branches(kept, root, in_order)]
    while stack:
        edge = next(stack[-1], None)
        if edge is None:
            stack.pop()
        elif edge.child not in seen:
            seen.add(edge.child)
            order.append(edge.child)
            edges.append(edge)
            stack.append(_branches(kept, edge.child, in_order))
    return order, edges


def _branches(kept: nx.MultiGraph, body: int, in_order: bool) -> Iterator[Edge]:
    edges = [Edge(body, other, data["connection"]) for _, other, data in kept.edges(body, data=True)]
    if in_order:
        return iter(sorted(edges, key=lambda edge: edge.child))
    return iter(sorted(edges, key=lambda edge: natural(edge.connection.name if edge.connection else "")))


def natural(name: str) -> tuple[tuple[int, int, str], ...]:
    """A sort key in which "joint_10" comes after "joint_2"."""
    return tuple(
        (0, len(text.lstrip("0")), text.lstrip("0")) if text.isdecimal() else (1, 0, text)
        for text in re.split(r"(\d+)", name)
    )


def _islands(mechanism: Mechanism, kept: nx.MultiGraph, reached: set[int]) -> list[list[int]]:
    """Bodies that are not connected to the root, in groups that are connected with each other."""
    islands = [sorted(found) for found in nx.connected_components(kept) if reached.isdisjoint(found)]
    return sorted(islands, key=lambda island: min(mechanism.bodies[body].name for body in island))


def _disconnected(
    mechanism: Mechanism, root: int, islands: list[list[int]], log: Diagnostics
) -> Disconnected:
    bodies = mechanism.bodies
    problems = [one for one in log.found if one.code in LEFT_OUT]
    for island in islands:
        parts = sorted(part.name for body in island for part in bodies[body].parts)
        names = ", ".join(sorted(bodies[body].name for body in island))
        what = f"{_are(len(parts), 'part')} not connected to the root: {names}"
        where = parts[0] if parts else names
        hint = "mate it in Onshape (a FASTENED mate makes two parts one link), or suppress it"
        if not mechanism.has_saved_pose:
            what = f"{_are(len(island), 'link')} not connected to the root"
            where, hint = names, _JOIN
        problems.append(Diagnostic("E-LOOSE", what, where, hint))
    total = sum(len(island) for island in islands)
    verb = "is" if total == 1 else "are"
    msg = f"{total} of {len(bodies)} bodies {verb} not connected to the root {bodies[root].name!r}"
    hint = (
        "or choose for all of them, root.disconnected: weld (fixed to the root), drop (left out), separate "
        "(floating on their own)"
    )
    return Disconnected(msg, hint=hint, problems=problems)


def _are(number: int, thing: str) -> str:
    return f"{count(number, thing)} {'is' if number == 1 else 'are'}"


def _report_island(mechanism: Mechanism, island: list[int], keys: RootSection, log: Diagnostics) -> None:
    names = ", ".join(sorted(mechanism.bodies[body].name for body in island))
    done = {"drop": "left out", "weld": "fixed to the root", "separate": "floating on its own"}
    what = f"{names}: {done[keys.disconnected]}, as it is not connected to the root"
    hint = "mate it to the robot in Onshape, or suppress it" if mechanism.has_saved_pose else _JOIN
    log.report("I-LOOSE", what, f"root.disconnected: {keys.disconnected}", hint)


def _attached(
    mechanism: Mechanism, kept: nx.MultiGraph, root: int, island: list[int], keys: RootSection
) -> tuple[list[int], list[Edge]]:
    """The bodies of an island in order, and their edges, the first from the root; none to drop them."""
    if keys.disconnected == "drop":
        return [], []
    fixed = [body for body in island if mechanism.bodies[body].fixed_reason]
    afloat = [body for body in island if mechanism.bodies[body].afloat is not None]
    head = heaviest(mechanism, fixed or afloat or island)
    order, edges = _walk(kept, head)
    stand_in: Literal["fixed", "free"] = "fixed" if keys.disconnected == "weld" else "free"
    return order, [Edge(root, head, None, stand_in), *edges]
