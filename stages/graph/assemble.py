"""The main flow of the graph stage."""

from collections.abc import Mapping
from fnmatch import fnmatchcase

import numpy as np

from stages.graph.assembly import Assembly, Mate, read_assembly
from stages.graph.bodies import Bodies, find_bodies
from stages.graph.joints import KINDS, Placed, place
from stages.graph.keys import GraphKeys
from stages.graph.limits import MateKey, resolve_limits
from stages.graph.mass import (
    SHEET,
    Masses,
    check_link_masses,
    check_masses,
    part_key,
    read_masses,
    with_sheets,
)
from stages.graph.naming import Names, is_link_name, name_everything
from stages.graph.properties import check_limits, with_properties
from stages.graph.relations import on_their_drivers, read_relations, related_mates
from stages.graph.tree import Tree, choose_root, spanning_tree, weights
from stages.robot.bundle import Bundle
from stages.robot.errors import AssemblyError, Diagnostic
from stages.robot.inertia import ZERO, is_physical, merged, moved
from stages.robot.model import Array, Base, Frame, Joint, Link, MeshRef, Part, Provenance, Robot, frozen
from stages.robot.names import legal
from stages.robot.poses import inverse


def assemble(bundle: Bundle, keys: GraphKeys) -> Robot:
    """Reads, merges, names, roots, places and weighs: one robot from one bundle."""
    problems: list[Diagnostic] = []
    assembly = read_assembly(bundle.body(bundle.definition))
    unknown_limits = resolve_limits(assembly, bundle)
    found = list(assembly.diagnostics)
    masses = with_sheets(read_masses(bundle), assembly, found)
    _check_mates(assembly, problems)
    bodies = find_bodies(assembly, problems)
    check_masses(assembly, masses, problems)
    _raise(problems)
    bodies.moving = [mate for mate in bodies.moving if not _is_rigid(mate, bodies, found)]
    names = name_everything(assembly, bodies, masses)
    check_link_masses(bodies, assembly, masses, names.links, problems)
    _raise(problems)
    part_mass = {part.path: masses[part_key(part.record)][0].mass for part in assembly.parts}
    root = choose_root(keys.root.select, assembly, bodies, names, weights(part_mass, bodies))
    tree = spanning_tree(bodies, names, root, related_mates(assembly), assembly)
    _check_loops(tree, unknown_limits, problems, found)
    placed = place(assembly, bodies, tree, names, keys.loops.solref, found)
    joints = with_properties(placed.joints, keys.joints)
    relations = read_relations(assembly, names, joints, found, problems)
    unknown = _unknown(placed.joints, joints, unknown_limits)
    joints = check_limits(on_their_drivers(joints, relations), unknown, found, problems)
    links = tuple(_link(body, assembly, bodies, names, placed, masses, bundle) for body in tree.order)
    _check_links(links, problems)
    _tell_names(assembly, bodies, names, found)
    _raise(problems)
    return Robot(
        name=keys.name,
        links=links,
        joints=joints,
        loops=placed.loops,
        relations=relations,
        frames=_frames(assembly, bodies, names, placed, keys, found),
        base=_base(keys, bodies, tree, names, found),
        provenance=Provenance(**bundle.root),
        diagnostics=tuple(found),
    )


def _raise(problems: list[Diagnostic]) -> None:
    if problems:
        msg = f"the assembly cannot be built: {len(problems)} problem(s)"
        raise AssemblyError(msg, problems=sorted(problems, key=lambda p: (p.code, p.where)))


def _check_mates(assembly: Assembly, problems: list[Diagnostic]) -> None:
    """What this robot would need and cannot have yet, by name."""
    if len(assembly.parts) > 1 and not assembly.mates and not assembly.groups:
        msg = "the assembly has no mates: its parts hang on nothing"
        hint = "mate them in Onshape: FASTENED for what is one link, REVOLUTE or SLIDER for a joint"
        raise AssemblyError(msg, where=assembly.root.get("elementId", ""), hint=hint)
    for mate in assembly.mates:
        if mate.ref.type not in KINDS and mate.ref.type != "FASTENED":
            problems.append(
                Diagnostic("E-MATE-TYPE", f"a {mate.ref.type} mate is not supported yet", mate.title)
            )
        for entity in mate.entities:
            occurrence = assembly.occurrences.get(entity.path)
            if occurrence is not None and _mirrors(occurrence.world_from_occurrence):
                problems.append(
                    Diagnostic("E-MIRROR", f"{occurrence.title} is mirrored: not supported yet", mate.title)
                )


def _mirrors(transform: Array) -> bool:
    return bool(np.linalg.det(transform[:3, :3]) < 0)


def _is_rigid(mate: Mate, bodies: Bodies, found: list[Diagnostic]) -> bool:
    """Whether both sides of a moving mate are in one body: then it moves nothing."""
    first, second = (bodies.of[entity.path] for entity in mate.entities)
    if first != second:
        return False
    found.append(
        Diagnostic(
            "W-MATE-RIGID",
            "both sides of this mate are in one link (fastened or fixed), so it moves nothing",
            mate.title,
            "suppress the mate that holds them, or this one",
        )
    )
    return True


def _check_loops(
    tree: Tree,
    unknown_limits: Mapping[MateKey, str],
    problems: list[Diagnostic],
    found: list[Diagnostic],
) -> None:
    for mate in tree.cut:
        unknown = unknown_limits.get((mate.ref.owner, mate.ref.feature))
        if unknown:
            found.append(Diagnostic("W-LIMIT", f"its limits in CAD are not known: {unknown}", mate.title))
        if mate.limits:
            found.append(
                Diagnostic(
                    "W-LOOP-LIMIT",
                    "this mate closes a loop, where its limits are not enforced",
                    mate.title,
                    "leave one mate of the loop without limits: it will be the one that closes it",
                )
            )
        if mate.ref.type != "REVOLUTE":
            problems.append(
                Diagnostic(
                    "E-LOOP",
                    f"a loop of {mate.ref.type} mates alone is not supported yet",
                    mate.title,
                    "suppress one mate of the loop",
                )
            )


def _link(
    body: int,
    assembly: Assembly,
    bodies: Bodies,
    names: Names,
    placed: Placed,
    masses: Masses,
    bundle: Bundle,
) -> Link:
    link_from_world = inverse(placed.world_from_link[body])
    tessellations = {studio.key: studio.tessellation for studio in bundle.studios}
    parts = []
    for path in bodies.members[body]:
        occurrence = assembly.occurrences[path]
        key = part_key(occurrence.record)
        reply = tessellations.get(key[0])
        inertial, volume = masses[key]
        parts.append(
            Part(
                path=path,
                name=occurrence.title,
                part_id=key[1],
                mesh=MeshRef(reply, key[1]) if reply else None,
                link_from_part=frozen(link_from_world @ occurrence.world_from_occurrence),
                world_from_part=occurrence.world_from_occurrence,
                inertial=inertial,
                volume=volume,
                collides=assembly.body_types.get(key) != SHEET or inertial.mass > 0,
            )
        )
    inertial = merged([moved(part.inertial, part.link_from_part) for part in parts]) if parts else ZERO
    return Link(names.links[body], inertial, tuple(parts), names.paths[body])


def _unknown(
    drawn: tuple[Joint, ...], joints: tuple[Joint, ...], reasons: Mapping[MateKey, str]
) -> dict[str, str]:
    """Why limits are not known, by joint, of the joints to which YAML gave none either."""
    keys = {joint.name: (joint.mate.owner, joint.mate.feature) for joint in joints}
    return {
        joint.name: reasons[keys[joint.name]]
        for before, joint in zip(drawn, joints, strict=True)
        if keys[joint.name] in reasons and joint.limits is before.limits
    }


def _check_links(links: tuple[Link, ...], problems: list[Diagnostic]) -> None:
    """No engine moves a body whose inertia no solid can have: names the parts that cause it."""
    for link in links:
        if not is_physical(link.inertial):
            culprits = [part.name for part in link.parts if not is_physical(part.inertial)]
            problems.append(
                Diagnostic(
                    "E-INERTIA",
                    f"the link {link.name!r} has an inertia that no solid can have",
                    ", ".join(culprits) or link.name,
                    "mend the part's material or its mass override in Onshape",
                )
            )


def _tell_names(assembly: Assembly, bodies: Bodies, names: Names, found: list[Diagnostic]) -> None:
    """Names of which nothing could be kept, and `link_` connectors that name nothing."""
    typed = [(name, assembly.occurrences[path].names[-1]) for name, path in zip(names.links, names.paths)]
    typed += [(names.joints[m.ref.owner, m.ref.feature], m.ref.name) for m in bodies.moving]
    for name, text in sorted(typed):
        if "unnamed" in name and not legal(text):
            message = f"{text!r} has no letter that a robot file may hold: called {name!r}"
            found.append(Diagnostic("W-NAME", message, name, "give it a name with letters or digits"))
    named: dict[int, str] = {}
    for connector in sorted(assembly.connectors, key=lambda c: (c.names, c.name, c.feature)):
        if not is_link_name(connector):
            continue
        body = bodies.of.get(connector.entity.path)
        if body is None:
            message = "the connector names no link: it is on no part"
            found.append(Diagnostic("W-NAME", message, connector.title, "put it on a part of the link"))
        elif named.setdefault(body, connector.title) != connector.title:
            message = f"the link has its name from {named[body]} already"
            found.append(Diagnostic("W-NAME", message, connector.title, "remove one of the two connectors"))


def _frames(
    assembly: Assembly,
    bodies: Bodies,
    names: Names,
    placed: Placed,
    keys: GraphKeys,
    found: list[Diagnostic],
) -> tuple[Frame, ...]:
    """Mate connectors that the designer placed, as frames on their links."""
    frames = []
    for connector in assembly.connectors:
        name = names.frames.get((connector.owner, connector.feature))
        if is_link_name(connector) or name is None:
            continue
        if not any(fnmatchcase(name, glob) for glob in keys.frames.include):
            continue
        body = bodies.of.get(connector.entity.path)
        if body is None:
            found.append(
                Diagnostic(
                    "W-FRAME",
                    "the connector is on no part (origin or sub-assembly): left out",
                    connector.title,
                )
            )
            continue
        pose = inverse(placed.world_from_link[body]) @ assembly.world_from(connector.entity)
        if _mirrors(pose):
            found.append(
                Diagnostic("W-FRAME", "the connector is on a mirrored part: left out", connector.title)
            )
            continue
        frames.append(Frame(name, names.links[body], frozen(pose), connector.name))
    return tuple(sorted(frames, key=lambda frame: frame.name))


def _base(keys: GraphKeys, bodies: Bodies, tree: Tree, names: Names, found: list[Diagnostic]) -> Base:
    if keys.root.base != "auto":
        return Base(keys.root.base == "fixed", f"root.base is {keys.root.base}")
    if bodies.world == tree.root:
        return Base(True, bodies.fixed_by)
    if bodies.world is not None:
        held = names.links[bodies.world]
        found.append(
            Diagnostic(
                "W-BASE",
                f"the root floats, though CAD fixes {held!r} ({bodies.fixed_by})",
                names.links[tree.root],
                f"choose that root (root.select={held}), or say root.base: fixed or free",
            )
        )
    return Base(False, "nothing fixes the root link to the world")
