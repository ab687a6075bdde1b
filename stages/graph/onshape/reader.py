"""Reads an Onshape assembly into a mechanism."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from linkwright.stages.graph.dofs import residual
from linkwright.stages.graph.mechanism import (
    WORLD_LINK,
    Connection,
    Marker,
    Mechanism,
    RelationSpec,
    RigidBody,
)
from linkwright.stages.graph.onshape.assembly import Assembly, Mate, Path
from linkwright.stages.graph.onshape.bodies import Bodies, find_bodies
from linkwright.stages.graph.onshape.definition import read_assembly
from linkwright.stages.graph.onshape.hidden import without_hidden
from linkwright.stages.graph.onshape.mass.part_mass import SHEET, PartMass, part_key, part_masses
from linkwright.stages.graph.onshape.mass.part_solids import PartSolids
from linkwright.stages.graph.onshape.mates.joints import JOINT_TYPES, dofs_of, right_handed
from linkwright.stages.graph.onshape.mates.limits import with_limits
from linkwright.stages.graph.onshape.mates.parallel import Absorbed, MateKey, combine_mates
from linkwright.stages.graph.onshape.naming import AssemblyNames, is_link_name, name_everything
from linkwright.stages.graph.onshape.onshape_to_robot import translate_names
from linkwright.stages.graph.onshape.patterns.instances import with_copies
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.bundle import OnshapeBundle
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import AssemblyError
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import MeshRef, Part, Provenance, frozen
from linkwright.stages.robot.motion.kinematics import chain
from linkwright.stages.robot.text.names import legal_name

PartMasses = Mapping[Path, PartMass]


def read_mechanism(
    bundle: OnshapeBundle, keys: GraphSections, log: Diagnostics
) -> tuple[Mechanism, GraphSections]:
    """Reads an assembly definition and the other replies of its bundle; raises AssemblyError if they cannot
    be read. Also returns the keys, completed by the conventions of the document.
    """
    assembly = read_assembly(bundle.body(bundle.definition))
    log.add(assembly.diagnostics)
    if keys.hidden == "drop":
        assembly = without_hidden(assembly, log)
    assembly = with_limits(assembly, bundle)
    if keys.conventions == "onshape_to_robot":
        assembly, keys = translate_names(assembly, keys, log)
    assembly = with_copies(assembly, keys, PartSolids(assembly, bundle), log)
    _require_mates(assembly, keys)
    masses = part_masses(assembly, bundle, keys.mass, log)
    bodies, absorbed = _combined_bodies(assembly, keys, log)
    names = name_everything(assembly, bodies, {path: part_mass.volume for path, part_mass in masses.items()})
    _report_names(assembly, bodies, names, log)
    connections = tuple(_connection(mate, assembly, bodies, names) for mate in bodies.moving)
    mechanism = Mechanism(
        bodies=tuple(_bodies(assembly, bodies, names, masses, bundle)),
        connections=connections,
        relations=tuple(_relations(assembly, connections, absorbed)),
        markers=tuple(_markers(assembly, bodies, names, log)),
        provenance=Provenance(**bundle.root),
    )
    return mechanism, keys


def _require_mates(assembly: Assembly, keys: GraphSections) -> None:
    if (
        keys.root.disconnected == "error"
        and len(assembly.parts) > 1
        and not assembly.mates
        and not assembly.groups
    ):
        msg = "the assembly has no mates: nothing connects its parts"
        hint = "mate them in Onshape: FASTENED within a link, REVOLUTE or SLIDER for a joint"
        raise AssemblyError(msg, where=assembly.root.get("elementId", ""), hint=hint)


def _combined_bodies(
    assembly: Assembly, keys: GraphSections, log: Diagnostics
) -> tuple[Bodies, Mapping[MateKey, Absorbed]]:
    """Returns the bodies, after merging bodies that several mates hold rigidly together; and the mates that
    other mates replace."""
    welds: list[tuple[Path, Path]] = []
    while True:
        body_log, mate_log = Diagnostics(optional=log.optional), Diagnostics()
        bodies = find_bodies(assembly, keys, body_log, welds)
        result = combine_mates(bodies.moving, assembly, bodies.of, mate_log)
        if not result.welds:
            log.add([*body_log.problems, *body_log.notes, *mate_log.problems, *mate_log.notes])
            return replace(bodies, moving=list(result.mates)), result.absorbed
        welds += result.welds
        log.add([*mate_log.problems, *mate_log.notes])


def _bodies(
    assembly: Assembly, bodies: Bodies, names: AssemblyNames, masses: PartMasses, bundle: OnshapeBundle
) -> Iterator[RigidBody]:
    tessellations = {studio.key: studio.tessellation for studio in bundle.studios}
    for number, members in enumerate(bodies.members):
        parts = []
        titles = {names.links[number]}
        for path in members:
            occurrence = assembly.occurrences[path]
            key = part_key(occurrence.record)
            reply = tessellations.get(key[0])
            part_mass = masses[path]
            parts.append(
                Part(
                    path=path,
                    name=occurrence.title,
                    part_id=key[1],
                    mesh=MeshRef(reply, key[1]) if reply else None,
                    link_from_part=occurrence.world_from_occurrence,
                    world_from_part=occurrence.world_from_occurrence,
                    inertial=part_mass.inertial,
                    volume=part_mass.volume,
                    collides=assembly.body_types.get(key) != SHEET or part_mass.inertial.mass > 0,
                    standard=key in assembly.standard,
                    estimated=part_mass.estimated,
                )
            )
            for name in occurrence.names:
                titles |= {name, legal_name(name)}
        yield RigidBody(
            name=names.links[number],
            path=names.paths[number],
            parts=tuple(parts),
            titles=frozenset(titles),
            fixed_reason=(bodies.fixed_by or "it is the assembly's origin") if number == bodies.world else "",
            world_from_body=frozen(np.eye(4)),
        )


def _connection(mate: Mate, assembly: Assembly, bodies: Bodies, names: AssemblyNames) -> Connection:
    name = names.joints[mate.ref.key]
    first, second, mirrored = right_handed(*(assembly.world_from(entity) for entity in mate.entities))
    relative = inverse(second) @ first
    dofs = dofs_of(name, mate.ref.type, mate.limits or {}, relative, mirrored, mate.limit_origin)
    second_from_first = chain(dofs, {dof.name: dof.saved for dof in dofs})
    return Connection(
        name=name,
        type=JOINT_TYPES[mate.ref.type],
        bodies=(bodies.of[mate.entities[0].path], bodies.of[mate.entities[1].path]),
        world_from_frames=(frozen(first), frozen(second)),
        dofs=dofs,
        residual=residual(relative, second_from_first),
        ref=mate.ref,
        title=mate.title,
    )


def _relations(
    assembly: Assembly, connections: tuple[Connection, ...], absorbed: Mapping[MateKey, Absorbed]
) -> Iterator[RelationSpec]:
    """Yields the relations; a relation of an absorbed mate becomes one of the mate that replaces it.
    Relations are left out if none of their mates moves anything (W-MATE-RIGID)."""
    connection_names = {connection.ref.key: connection.name for connection in connections}
    names_by_key = {key: (name, 1) for key, name in connection_names.items()}
    names_by_key |= {
        key: (connection_names[mate.by] if mate.sign else "", mate.sign) for key, mate in absorbed.items()
    }
    idle_mates = {mate.key for mate in assembly.mates} - names_by_key.keys()
    for relation in sorted(assembly.relations, key=lambda r: (r.title, r.owner, r.feature)):
        if relation.mates and all((*mate, "") in idle_mates for mate in relation.mates):
            continue
        name_signs = [names_by_key.get((*mate, ""), ("", 0)) for mate in relation.mates]
        is_inverted = sum(sign < 0 for _, sign in name_signs) % 2 == 1
        yield RelationSpec(
            title=relation.title,
            type=relation.type,
            connections=tuple(name for name, _ in name_signs),
            ratio=relation.ratio,
            length=relation.length,
            reverse=relation.reverse != is_inverted,
        )


def _markers(assembly: Assembly, bodies: Bodies, names: AssemblyNames, log: Diagnostics) -> Iterator[Marker]:
    """Yields a marker for each mate connector that the designer placed on a part; reports W-FRAME for others,
    and for left-handed connectors."""
    for connector in assembly.connectors:
        if is_link_name(connector):
            continue
        body = bodies.of.get(connector.entity.path)
        if body is None:
            message = "the connector is on no part (origin or sub-assembly): left out"
            log.report("W-FRAME", message, connector.title, "put it on a part")
            continue
        frame = assembly.world_from(connector.entity)
        if np.linalg.det(frame[:3, :3]) < 0:
            message = "the connector is on a mirrored part, so it is left-handed: its y axis is reversed"
            log.report("W-FRAME", message, connector.title, "put a new connector on the mirrored part")
            frame = frame @ np.diag([1.0, -1.0, 1.0, 1.0])
        name = names.frames[connector.owner, connector.feature]
        yield Marker(name, connector.title, body, frozen(frame), connector.name)


def _report_names(assembly: Assembly, bodies: Bodies, names: AssemblyNames, log: Diagnostics) -> None:
    """Reports W-NAME for names without a usable letter, and for `link_` connectors that name no link."""
    typed_names = [
        (name, assembly.occurrences[path].names[-1])
        for name, path in zip(names.links, names.paths, strict=True)
        if name != WORLD_LINK
    ]
    typed_names += [(names.joints[m.ref.key], m.ref.name) for m in bodies.moving]
    for name, text in sorted(typed_names):
        if "unnamed" in name and not legal_name(text):
            message = f"{text!r} has no letter or digit that a robot file allows: {name!r} is used"
            log.report("W-NAME", message, name, "give it a name with letters or digits")
    names_of_bodies: dict[int, str] = {}
    for connector in sorted(assembly.connectors, key=lambda c: (c.names, c.name, c.feature)):
        if not is_link_name(connector):
            continue
        body = bodies.of.get(connector.entity.path)
        if body is None:
            message = "the connector names no link: it is on no part"
            log.report("W-NAME", message, connector.title, "put it on a part of the link")
        elif not bodies.members[body]:
            message = f"the connector names no link: the assembly's origin is always called {WORLD_LINK!r}"
            log.report("W-NAME", message, connector.title, "put it on a part of the link")
        elif names_of_bodies.setdefault(body, connector.title) != connector.title:
            message = f"the link already has the name of {names_of_bodies[body]}"
            log.report("W-NAME", message, connector.title, "remove one of the two connectors")
