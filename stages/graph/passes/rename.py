"""Renames links and joints as the user wants (key `names`)."""

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from linkwright.stages.graph.globs import unusable
from linkwright.stages.graph.mechanism import WORLD_LINK, Connection, Mechanism
from linkwright.stages.graph.section import NamesSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.mjcf_extras import NewName
from linkwright.stages.robot.model.sensing import Sensor
from linkwright.stages.robot.text.globs import listed, matching, with_plain


def renamed(mechanism: Mechanism, wanted: NamesSection, log: Diagnostics) -> Mechanism:
    """The mechanism with the names that `wanted` gives; no other name changes.

    An entry means the one body or joint (a connection, or what holds a frame) that has this name; else the
    one that is called so in CAD or that the glob matches. E-RENAME for none or several, E-NAME for a name
    that is not free.
    """
    links = _new_names(
        [body.name for body in mechanism.bodies],
        [with_plain(body.titles) for body in mechanism.bodies],
        (wanted.links, "names.links", "link"),
        log,
    )
    titles = {one.name: {one.ref.name, one.title} for one in mechanism.connections}
    titles |= {marker.joint: set() for marker in mechanism.markers if marker.joint}
    names = list(titles)
    joints = _new_names(names, list(titles.values()), (wanted.joints, "names.joints", "joint"), log)
    bodies = tuple(replace(body, name=links.get(i, body.name)) for i, body in enumerate(mechanism.bodies))
    connections = tuple(_called(one, joints.get(i, one.name)) for i, one in enumerate(mechanism.connections))
    called = {names[i]: name for i, name in joints.items()}
    for old, new in zip(mechanism.connections, connections, strict=True):
        called |= {one.name: other.name for one, other in zip(old.dofs, new.dofs, strict=True)}
    specs = tuple(
        replace(spec, connections=tuple(called.get(name, name) for name in spec.connections))
        for spec in mechanism.relations
    )
    of_links = {mechanism.bodies[i].name: name for i, name in links.items()}
    made = replace(
        mechanism,
        bodies=bodies,
        connections=connections,
        relations=specs,
        markers=tuple(replace(one, joint=called.get(one.joint, one.joint)) for one in mechanism.markers),
        actuators=tuple(replace(one, dof=called.get(one.dof, one.dof)) for one in mechanism.actuators),
        sensors=tuple(_measuring(one, called, of_links) for one in mechanism.sensors),
        keyframes=tuple(
            replace(one, given=tuple((called.get(name, name), value) for name, value in one.given))
            for one in mechanism.keyframes
        ),
        mjcf=mechanism.mjcf and mechanism.mjcf.renamed(_new_name(called, of_links)),
    )
    _check_free(made, {*links.values(), *joints.values()}, log)
    return made


def _new_name(dofs: Mapping[str, str], links: Mapping[str, str]) -> NewName:
    """By kind: those of links are bodies, and an equality may be a connection that closes a loop."""
    tables = {"body": links, "joint": dofs, "equality": dofs}
    return lambda kind, name: tables.get(kind, {}).get(name, name)


def _measuring(sensor: Sensor, dofs: Mapping[str, str], links: Mapping[str, str]) -> Sensor:
    """The sensor by the new names of what it is on."""

    def new(kind: str, name: str) -> str:
        table = dofs if kind == "joint" else links if kind in ("body", "xbody") else {}
        return table.get(name, name)

    return replace(
        sensor,
        name_of_target=new(sensor.target, sensor.name_of_target),
        name_of_relative=new(sensor.relative_to, sensor.name_of_relative),
    )


def _new_names(
    names: Sequence[str],
    titles: Sequence[Collection[str]],
    asked: tuple[Mapping[str, str], str, str],
    log: Diagnostics,
) -> dict[int, str]:
    """New names by the number of the thing; E-RENAME for an entry that does not mean exactly one."""
    wanted, where, kind = asked
    found: dict[int, str] = {}
    every = [{name, *more} for name, more in zip(names, titles, strict=True)]
    for glob, new in wanted.items():
        hits = [names.index(glob)] if glob in names else matching(glob, every)
        if not hits:
            hint = f"name one of: {listed(names)}"
            log.unmatched("E-RENAME", f"no {kind} matches {glob!r}", where, hint, glob)
        elif len(hits) > 1:
            hint = f"name one of: {listed(names[i] for i in hits)}"
            log.report("E-RENAME", f"{len(hits)} {kind}s match {glob!r}", where, hint)
        elif names[hits[0]] == WORLD_LINK:
            text = f"the assembly's origin is always called {WORLD_LINK!r}"
            log.report("E-RENAME", text, where, f"remove {glob!r}")
        elif hits[0] in found:
            text = f"{glob!r} means {names[hits[0]]!r}, which is already renamed to {found[hits[0]]!r}"
            log.report("E-RENAME", text, where, "remove one of the two")
        else:
            found[hits[0]] = new
    return found


def _called(connection: Connection, name: str) -> Connection:
    """The connection by another name: so are its dofs, where they have it in front of theirs."""
    dofs = (
        replace(dof, name=name + dof.name.removeprefix(connection.name))
        if dof.name.startswith(connection.name)
        else dof
        for dof in connection.dofs
    )
    return replace(connection, name=name, dofs=tuple(dofs))


def _check_free(mechanism: Mechanism, new: Collection[str], log: Diagnostics) -> None:
    """E-NAME for each new name that is invalid, or that something else has too."""
    counts = Counter(body.name for body in mechanism.bodies)
    counts.update(name for marker in mechanism.markers for name in (marker.name, marker.joint))
    for connection in mechanism.connections:
        # A connection of one dof has that dof's name: the two are one thing.
        counts.update(_names_of(connection))
    for connection in mechanism.connections:
        new = {*new, *_names_of(connection)} if connection.name in new else new
    for name in sorted(new):
        taken = [name] if counts[name] > 1 else []
        reason = unusable(name, taken)
        if reason:
            hint = "links, joints and frames share their names: choose another, or rename that too"
            log.report("E-NAME", reason, "names", hint if taken else "choose another")


def _names_of(connection: Connection) -> set[str]:
    return {connection.name, *(dof.name for dof in connection.dofs)}
