"""Chooses the root body and its frame, and whether it is fixed to the world."""

from collections.abc import Sequence
from dataclasses import replace

import networkx as nx

from linkwright.stages.graph.mechanism import WORLD_LINK, Marker, Mechanism, RigidBody
from linkwright.stages.graph.section import RootSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import NoRoot
from linkwright.stages.robot.model.robot import Array, Base
from linkwright.stages.robot.text.globs import matching_indices, with_plain_titles


def choose_root(mechanism: Mechanism, section: RootSection) -> tuple[int, Array]:
    """Returns the number of the root body, and the pose (4, 4) of the root's frame in the world.

    If any body is mated to the assembly's origin, the origin is the root. Otherwise `select` decides. With
    auto it is the first of these that exists: the body that has `frame`, the root of the source, the heaviest
    body that CAD fixes, the heaviest body. With central it is the body with the shortest paths to all others.
    Any other value is a name or glob that matches links or instances.
    """
    marker = _marker(mechanism, section.frame) if section.frame else None
    origin = next((number for number, body in enumerate(mechanism.bodies) if body.name == WORLD_LINK), None)
    root = _selected(mechanism, section.select, marker, origin)
    name = mechanism.bodies[root].name
    if origin is not None and root != origin:
        moving_mates = [
            connection.title for connection in mechanism.connections if origin in connection.bodies
        ]
        move = "moves" if len(moving_mates) == 1 else "move"
        msg = (
            f"{name!r} cannot be the root: {', '.join(moving_mates)} {move} relative to the assembly's origin"
        )
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


def _marker(mechanism: Mechanism, name: str) -> Marker:
    """Returns the mate connector with a name; raises NoRoot if none or several have it."""
    matches = [marker for marker in mechanism.markers if name in (marker.name, marker.source, marker.title)]
    if len(matches) != 1:
        msg = f"{len(matches) or 'no'} mate connectors are called {name!r}"
        candidates = ", ".join(sorted(marker.name for marker in matches or mechanism.markers)) or "none"
        raise NoRoot(msg, "root.frame", f"there are: {candidates}")
    return matches[0]


def _selected(mechanism: Mechanism, select: str, marker: Marker | None, origin: int | None) -> int:
    """Returns the number of the body that `select` chooses; raises NoRoot if it chooses none or several."""
    bodies = mechanism.bodies
    if select == "auto":
        if origin is not None:
            return origin
        if marker is not None:
            return marker.body
        if mechanism.root is not None:
            return mechanism.root
        fixed_bodies = [number for number, body in enumerate(bodies) if body.fixed_reason]
        return heaviest(mechanism, fixed_bodies or range(len(bodies)))
    if select == "central":
        graph = nx.Graph()
        graph.add_nodes_from(range(len(bodies)))
        graph.add_edges_from(connection.bodies for connection in mechanism.connections)
        closeness = nx.closeness_centrality(graph)
        return min(range(len(bodies)), key=lambda number: (-closeness[number], bodies[number].name))
    matches = matching_indices(select, [{body.name} for body in bodies])
    matches = matches or matching_indices(select, [with_plain_titles(body.titles) for body in bodies])
    if len(matches) == 1:
        return matches[0]
    candidates = ", ".join(sorted(bodies[number].name for number in matches or range(len(bodies))))
    msg = f"{len(matches) or 'no'} links match {select!r}"
    raise NoRoot(msg, "root.select", f"name one of: {candidates}")


def heaviest(mechanism: Mechanism, body_indices: Sequence[int]) -> int:
    """Returns the number of the heaviest body; of equally heavy bodies, the first by name."""
    return min(
        body_indices, key=lambda number: (-_mass(mechanism.bodies[number]), mechanism.bodies[number].name)
    )


def _mass(body: RigidBody) -> float:
    """Returns the mass [kg] of a body: its own if it has any, else the sum of its parts'."""
    if body.own_inertial is not None:
        return body.own_inertial.mass
    return sum(part.inertial.mass for part in body.parts)


def base_of(mechanism: Mechanism, root: int, section: RootSection, log: Diagnostics) -> Base:
    """Decides whether the root is fixed to the world, and says why. Reports E-BASE if the assembly's origin
    would have to float, and W-BASE if the root floats though CAD fixes another link."""
    body = mechanism.bodies[root]
    if body.name == WORLD_LINK and section.base == "free":
        text = "the root is the assembly's origin, which other links are mated to: it cannot float"
        log.report(
            "E-BASE", text, "root.base", "leave root.base at auto, or mate to a part instead of the origin"
        )
        # The error ends the build later; until then, go on as with auto.
    elif section.base != "auto":
        return Base(section.base == "fixed", f"root.base is {section.base}", body.floating_joint or "")
    if body.fixed_reason:
        return Base(True, body.fixed_reason)
    other = next((fixed_body for fixed_body in mechanism.bodies if fixed_body.fixed_reason), None)
    if other is not None:
        log.report(
            "W-BASE",
            f"the root floats, though CAD fixes {other.name!r} ({other.fixed_reason})",
            body.name,
            f"choose that root (root.select={other.name}), or set root.base: fixed or free",
        )
    if mechanism.unstated_base is not None:
        log.add([replace(mechanism.unstated_base, where=body.name)])
    return Base(False, "nothing fixes the root link to the world", body.floating_joint or "")
