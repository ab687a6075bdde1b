"""Chooses the root body and its frame, and whether it is fixed to the world."""

from dataclasses import replace

import networkx as nx

from linkwright.stages.graph.mechanism import WORLD_LINK, Marker, Mechanism
from linkwright.stages.graph.section import RootSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import NoRoot
from linkwright.stages.robot.model.robot import Array, Base
from linkwright.stages.robot.text.globs import matching, with_plain


def choose_root(mechanism: Mechanism, keys: RootSection) -> tuple[int, Array]:
    """The root body and the pose (4, 4) of its frame in the world.

    Where something moves relative to the assembly's origin, the origin is the root. Else `select` chooses:
    auto takes the body that `frame` is on, what the source itself has for a root, what is fixed in CAD, or
    the heaviest; central the body nearest to all others; anything else is a name or a glob over names of
    links and instances.
    """
    marker = _marker(mechanism, keys.frame) if keys.frame else None
    origin = next((i for i, body in enumerate(mechanism.bodies) if body.name == WORLD_LINK), None)
    root = _selected(mechanism, keys.select, marker, origin)
    name = mechanism.bodies[root].name
    if origin is not None and root != origin:
        movers = [c.title for c in mechanism.connections if origin in c.bodies]
        move = "moves" if len(movers) == 1 else "move"
        msg = f"{name!r} cannot be the root: {', '.join(movers)} {move} relative to the assembly's origin"
        raise NoRoot(
            msg, "root.select", "leave root.select at auto, or mate to a fixed part instead of the origin"
        )
    if marker is not None and marker.body != root:
        other = mechanism.bodies[marker.body].name
        msg = f"the frame {marker.name!r} is on the link {other!r}, but the root is {name!r}"
        raise NoRoot(msg, "root.frame", f"leave root.select at auto, or choose root.select={other}")
    if marker is not None:
        return root, marker.world_from_frame
    return root, mechanism.bodies[root].world_from_body


def _marker(mechanism: Mechanism, wanted: str) -> Marker:
    hits = [m for m in mechanism.markers if wanted in (m.name, m.source, m.title)]
    if len(hits) != 1:
        msg = f"{len(hits) or 'no'} mate connectors are called {wanted!r}"
        there = ", ".join(sorted(m.name for m in hits or mechanism.markers)) or "none"
        raise NoRoot(msg, "root.frame", f"there are: {there}")
    return hits[0]


def _selected(mechanism: Mechanism, select: str, marker: Marker | None, origin: int | None) -> int:
    bodies = mechanism.bodies
    if select == "auto":
        if origin is not None:
            return origin
        if marker is not None:
            return marker.body
        if mechanism.root is not None:
            return mechanism.root
        fixed = [number for number, body in enumerate(bodies) if body.fixed_reason]
        return heaviest(mechanism, fixed or range(len(bodies)))
    if select == "central":
        graph = nx.Graph()
        graph.add_nodes_from(range(len(bodies)))
        graph.add_edges_from(connection.bodies for connection in mechanism.connections)
        closeness = nx.closeness_centrality(graph)
        return min(range(len(bodies)), key=lambda number: (-closeness[number], bodies[number].name))
    hits = matching(select, [{body.name} for body in bodies])
    hits = hits or matching(select, [with_plain(body.titles) for body in bodies])
    if len(hits) == 1:
        return hits[0]
    found = ", ".join(sorted(bodies[number].name for number in hits or range(len(bodies))))
    msg = f"{len(hits) or 'no'} links match {select!r}"
    raise NoRoot(msg, "root.select", f"name one of: {found}")


def heaviest(mechanism: Mechanism, among: "list[int] | range") -> int:
    """The body with the most mass; of equal ones the first by name."""
    mass = {n: sum(part.inertial.mass for part in mechanism.bodies[n].parts) for n in among}
    return min(among, key=lambda number: (-mass[number], mechanism.bodies[number].name))


def base_of(mechanism: Mechanism, root: int, keys: RootSection, log: Diagnostics) -> Base:
    """Whether the root is fixed to the world, and why."""
    body = mechanism.bodies[root]
    if body.name == WORLD_LINK and keys.base == "free":
        what = "the root is the assembly's origin, which other links are mated to: it cannot float"
        log.report(
            "E-BASE", what, "root.base", "leave root.base at auto, or mate to a part instead of the origin"
        )
    elif keys.base != "auto":
        return Base(keys.base == "fixed", f"root.base is {keys.base}", body.afloat or "")
    if body.fixed_reason:
        return Base(True, body.fixed_reason)
    other = next((one for one in mechanism.bodies if one.fixed_reason), None)
    if other is not None:
        log.report(
            "W-BASE",
            f"the root floats, though CAD fixes {other.name!r} ({other.fixed_reason})",
            body.name,
            f"choose that root (root.select={other.name}), or set root.base: fixed or free",
        )
    if mechanism.unstated_base is not None:
        log.add([replace(mechanism.unstated_base, where=body.name)])
    return Base(False, "nothing fixes the root link to the world", body.afloat or "")
