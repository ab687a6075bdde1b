"""Renames links and joints as the user wants (key `names`)."""

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from linkwright.stages.graph.globs import why_unusable
from linkwright.stages.graph.mechanism import WORLD_LINK, Connection, Mechanism
from linkwright.stages.graph.section import NamesSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.mjcf_extras import NewName
from linkwright.stages.robot.model.sensing import Sensor
from linkwright.stages.robot.text.globs import matching_indices, name_list, with_plain_titles


def rename_mechanism(mechanism: Mechanism, section: NamesSection, log: Diagnostics) -> Mechanism:
    """Returns the mechanism with the names that `section` gives; no other name changes.

    An entry is for the body or joint (a connection, or the joint of a frame) that has this name, else for the
    only body or joint whose name in CAD the glob matches. Reports E-RENAME for no match or several, E-NAME
    for a name that is not free.
    """
    links = _new_names(
        [body.name for body in mechanism.bodies],
        [with_plain_titles(body.titles) for body in mechanism.bodies],
        (section.links, "names.links", "link"),
        log,
    )
    titles = {
        connection.name: {connection.ref.name, connection.title} for connection in mechanism.connections
    }
    titles |= {marker.joint: set() for marker in mechanism.markers if marker.joint}
    names = list(titles)
    joints = _new_names(names, list(titles.values()), (section.joints, "names.joints", "joint"), log)
    bodies = tuple(replace(body, name=links.get(i, body.name)) for i, body in enumerate(mechanism.bodies))
    connections = tuple(
        _with_name(connection, joints.get(i, connection.name))
        for i, connection in enumerate(mechanism.connections)
    )
    joint_names = {names[i]: name for i, name in joints.items()}
    for old, new in zip(mechanism.connections, connections, strict=True):
        joint_names |= {
            old_dof.name: new_dof.name for old_dof, new_dof in zip(old.dofs, new.dofs, strict=True)
        }
    specs = tuple(
        replace(spec, connections=tuple(joint_names.get(name, name) for name in spec.connections))
        for spec in mechanism.relations
    )
    link_names = {mechanism.bodies[i].name: name for i, name in links.items()}
    renamed_mechanism = replace(
        mechanism,
        bodies=bodies,
        connections=connections,
        relations=specs,
        markers=tuple(
            replace(marker, joint=joint_names.get(marker.joint, marker.joint)) for marker in mechanism.markers
        ),
        actuators=tuple(
            replace(actuator, dof=joint_names.get(actuator.dof, actuator.dof))
            for actuator in mechanism.actuators
        ),
        sensors=tuple(_renamed_sensor(sensor, joint_names, link_names) for sensor in mechanism.sensors),
        keyframes=tuple(
            replace(
                keyframe,
                given=tuple((joint_names.get(name, name), value) for name, value in keyframe.given),
            )
            for keyframe in mechanism.keyframes
        ),
        mjcf=mechanism.mjcf and mechanism.mjcf.renamed(_new_name(joint_names, link_names)),
    )
    _check_new_names(renamed_mechanism, {*links.values(), *joints.values()}, log)
    return renamed_mechanism


def _new_name(dofs: Mapping[str, str], links: Mapping[str, str]) -> NewName:
    """Returns a function that renames by kind: links are bodies, and an equality may be a connection that
    closes a loop."""
    tables = {"body": links, "joint": dofs, "equality": dofs}
    return lambda kind, name: tables.get(kind, {}).get(name, name)


def _renamed_sensor(sensor: Sensor, dofs: Mapping[str, str], links: Mapping[str, str]) -> Sensor:
    """Returns the sensor under the new names of its objects."""

    def new_name(kind: str, name: str) -> str:
        table = dofs if kind == "joint" else links if kind in ("body", "xbody") else {}
        return table.get(name, name)

    return replace(
        sensor,
        name_of_target=new_name(sensor.target, sensor.name_of_target),
        name_of_relative=new_name(sensor.relative_to, sensor.name_of_relative),
    )


def _new_names(
    names: Sequence[str],
    titles: Sequence[Collection[str]],
    entries: tuple[Mapping[str, str], str, str],
    log: Diagnostics,
) -> dict[int, str]:
    """Returns the new names by the index of the body or joint. `entries`: the key's content, its name, and
    "link" or "joint". Reports E-RENAME for an entry that does not match exactly one body or joint."""
    new_names, where, kind = entries
    names_by_index: dict[int, str] = {}
    all_titles = [{name, *other_titles} for name, other_titles in zip(names, titles, strict=True)]
    for glob, new in new_names.items():
        matches = [names.index(glob)] if glob in names else matching_indices(glob, all_titles)
        if not matches:
            hint = f"name one of: {name_list(names)}"
            log.report_unmatched("E-RENAME", f"no {kind} matches {glob!r}", where, hint, glob)
        elif len(matches) > 1:
            hint = f"name one of: {name_list(names[i] for i in matches)}"
            log.report("E-RENAME", f"{len(matches)} {kind}s match {glob!r}", where, hint)
        elif names[matches[0]] == WORLD_LINK:
            text = f"the assembly's origin is always called {WORLD_LINK!r}"
            log.report("E-RENAME", text, where, f"remove {glob!r}")
        elif matches[0] in names_by_index:
            name, new_name = names[matches[0]], names_by_index[matches[0]]
            text = f"{glob!r} means {name!r}, which is already renamed to {new_name!r}"
            log.report("E-RENAME", text, where, "remove one of the two")
        else:
            names_by_index[matches[0]] = new
    return names_by_index


def _with_name(connection: Connection, name: str) -> Connection:
    """Returns the connection under another name; dofs whose names begin with the old name are renamed too."""
    dofs = (
        replace(dof, name=name + dof.name.removeprefix(connection.name))
        if dof.name.startswith(connection.name)
        else dof
        for dof in connection.dofs
    )
    return replace(connection, name=name, dofs=tuple(dofs))


def _check_new_names(mechanism: Mechanism, new_names: Collection[str], log: Diagnostics) -> None:
    """Reports E-NAME for each new name that is invalid, or that something else has too."""
    counts = Counter(body.name for body in mechanism.bodies)
    counts.update(name for marker in mechanism.markers for name in (marker.name, marker.joint))
    for connection in mechanism.connections:
        # A connection of one dof has that dof's name: the two count once.
        counts.update(_names_of(connection))
    for connection in mechanism.connections:
        new_names = {*new_names, *_names_of(connection)} if connection.name in new_names else new_names
    for name in sorted(new_names):
        duplicates = [name] if counts[name] > 1 else []
        reason = why_unusable(name, duplicates)
        if reason:
            hint = "links, joints and frames share their names: choose another, or rename that too"
            log.report("E-NAME", reason, "names", hint if duplicates else "choose another")


def _names_of(connection: Connection) -> set[str]:
    return {connection.name, *(dof.name for dof in connection.dofs)}
