"""Translates the names of documents made for onshape-to-robot to features and keys of our own.

There a mate is a joint because of its name: `dof_NAME`, with `_inv` for the opposite direction and `wheel` or
`continuous` for no limits; `closing_NAME` closes a loop, `frame_NAME` marks a frame, `fix_NAME` and FASTENED
mates without a prefix weld, and any other mate is ignored. Only the root assembly's features count, and each
of its instances is rigid. The rules are those of the code of release 1.8.3; what that does by accident
(undeclared loops, relations of inverted mates) is not copied here.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import networkx as nx
import numpy as np

from linkwright.stages.graph.onshape.assembly import Assembly, Connector, Entity, Mate, Path
from linkwright.stages.graph.onshape.naming import LINK_PREFIX, is_link_name
from linkwright.stages.graph.onshape.onshape_to_robot_names import (
    CLOSING,
    DOF,
    FIX,
    FRAME,
    IGNORED_MATES,
    joint_words,
    translated_mates,
    unprefixed_name,
    with_inverted_mates,
)
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import frozen
from linkwright.stages.robot.section import Section
from linkwright.stages.robot.text.globs import exact_glob, name_list, without_number
from linkwright.stages.robot.text.names import legal_name, legal_name_or_unnamed

AnySection = TypeVar("AnySection", bound=Section)


def translate_names(
    assembly: Assembly, keys: GraphSections, log: Diagnostics
) -> tuple[Assembly, GraphSections]:
    """Returns the assembly with plain names, and the keys that replace the conventions.

    It is called once limits are known, before anything is copied or merged. The root is the first instance,
    unless `root` chooses another, and is fixed where one of its occurrences is; links are called after their
    first instance; q counts from the saved pose.
    """
    mates_by_meaning = _by_meaning(assembly, log)
    link_of_instance = _links_by_instance(assembly, mates_by_meaning)
    markers = _markers(assembly, mates_by_meaning, log)
    assembly = _without_instances(assembly, {marker.instance for marker in markers})
    names = _link_names(assembly, link_of_instance, mates_by_meaning[DOF])
    root = link_of_instance[_instances(assembly)[0]]
    if keys.root.select == "auto" and keys.root.frame is None:
        keys = _with_values(keys, root=_with_values(keys.root, select=exact_glob(names[root])))
        assembly = _with_fixed_root(assembly, link_of_instance, root, log)
    keys = _translated_keys(keys, mates_by_meaning[CLOSING])
    log.report(
        "I-PEER",
        f"names mean what they mean in onshape-to-robot: the root is {keys.root.select}, q = 0 is the saved "
        f"pose (zero: saved), sub-assemblies are rigid (depth.max: {keys.depth.max})",
        "conventions",
    )
    inverted_mates = {
        (mate.ref.owner, mate.ref.feature) for mate in mates_by_meaning[DOF] if joint_words(mate).inverted
    }
    return replace(
        assembly,
        mates=translated_mates(assembly, mates_by_meaning, log),
        relations=[with_inverted_mates(relation, inverted_mates) for relation in assembly.relations],
        connectors=[
            *(marker.connector for marker in markers),
            *_named_connectors(assembly),
            *_connectors_for_unnamed_links(assembly, link_of_instance, names),
        ],
    ), keys


def _translated_keys(keys: GraphSections, closings: Sequence[Mate]) -> GraphSections:
    """Returns the keys that replace the conventions, except those of the root. `closings`: the `closing_`
    mates, at which loops are cut."""
    if keys.depth.max is None:
        keys = _with_values(keys, depth=_with_values(keys.depth, max=0))
    cut = (*keys.loops.cut, *(exact_glob(mate.title) for mate in closings))
    return _with_values(keys, zero="saved", loops=_with_values(keys.loops, cut=cut))


def _with_values(keys: AnySection, **values: object) -> AnySection:
    return keys.model_copy(update=values)


@dataclass(frozen=True, slots=True, eq=False)
class _Marker:
    """A frame, with the instance that only marks its place and is left out."""

    connector: Connector
    instance: Path


def _by_meaning(assembly: Assembly, log: Diagnostics) -> dict[str, list[Mate]]:
    """Returns the root assembly's mates by the meaning of their names. Reports W-PEER-MATE for ignored
    mates."""
    mates_by_meaning: dict[str, list[Mate]] = {DOF: [], CLOSING: [], FRAME: [], FIX: []}
    ignored_titles: dict[str, list[str]] = {reason: [] for reason in IGNORED_MATES}
    for mate in assembly.mates:
        prefix = next(
            (known_prefix for known_prefix in mates_by_meaning if mate.ref.name.startswith(known_prefix)), ""
        )
        if mate.ref.owner:
            if prefix in (DOF, CLOSING):
                ignored_titles["inner"].append(mate.title)
        elif not all(entity.path for entity in mate.entities):
            ignored_titles["origin"].append(mate.title)
        elif prefix or mate.ref.type == "FASTENED":
            mates_by_meaning[prefix or FIX].append(mate)
        else:
            ignored_titles["without prefix"].append(mate.title)
    for reason, titles in ignored_titles.items():
        message, hint = IGNORED_MATES[reason]
        if titles:
            log.report("W-PEER-MATE", f"{message}: {name_list(titles)}", titles[0], hint)
    return mates_by_meaning


def _instances(assembly: Assembly) -> list[Path]:
    """Returns the root assembly's own instances, in its order: the first is the root."""
    return [path for path in assembly.occurrences if len(path) == 1]


def _links_by_instance(
    assembly: Assembly, mates_by_meaning: Mapping[str, Sequence[Mate]]
) -> dict[Path, Path]:
    """Returns each instance's link: the first, in the root assembly's order, of those welded with it."""
    welded = nx.Graph()
    instances = _instances(assembly)
    welded.add_nodes_from(instances)
    welded.add_edges_from(_sides(mate) for mate in mates_by_meaning[FIX])
    for group in assembly.groups:
        if not group.owner:
            nx.add_path(welded, [path[:1] for path in group.members])
    order = {path: number for number, path in enumerate(instances)}
    return {
        path: min(welded_instances, key=order.__getitem__)
        for welded_instances in nx.connected_components(welded)
        for path in welded_instances
    }


def _sides(mate: Mate) -> tuple[Path, Path]:
    """Returns the instances of the root assembly that a mate joins."""
    first, second = (entity.path[:1] for entity in mate.entities)
    return first, second


def _markers(
    assembly: Assembly, mates_by_meaning: Mapping[str, Sequence[Mate]], log: Diagnostics
) -> list[_Marker]:
    """Returns the frames that `frame_` mates mark. Each is the frame of an instance that no other mate holds,
    on the instance at the other side of its mate. Reports E-PEER-FRAME and I-PEER-MARKER."""
    held_instances = {_instances(assembly)[0]}
    held_instances.update(
        side for prefix in (DOF, FIX) for mate in mates_by_meaning[prefix] for side in _sides(mate)
    )
    held_instances.update(
        path[:1] for group in assembly.groups for path in group.members if len(group.members) > 1
    )
    markers = []
    for mate in mates_by_meaning[FRAME]:
        loose = [entity for entity in mate.entities if entity.path[:1] not in held_instances]
        if len(loose) != 1:
            message = "a frame_ mate joins a link and a part that only marks the frame: "
            message += "both sides are parts of links" if not loose else "nothing else holds either side"
            log.report(
                "E-PEER-FRAME", message, mate.title, "free the marker of other mates, or rename this one"
            )
            continue
        marker = loose[0]
        (carrier,) = (entity for entity in mate.entities if entity is not marker)
        held_instances.add(marker.path[:1])
        carrier_from_marker = inverse(assembly.world_from_path(carrier.path)) @ assembly.world_from_path(
            marker.path
        )
        entity = Entity(carrier.path, frozen(carrier_from_marker))
        connector = Connector(
            owner=(), feature=mate.ref.feature, name=unprefixed_name(mate), names=(), entity=entity
        )
        markers.append(_Marker(connector, marker.path[:1]))
    if markers:
        titles = name_list(assembly.occurrences[frame_marker.instance].title for frame_marker in markers)
        message = f"instances that only mark frames are left out: {titles}"
        log.report("I-PEER-MARKER", message, "conventions", "name a connector frame_NAME to keep the part")
    return markers


def _without_instances(assembly: Assembly, removed_instances: Collection[Path]) -> Assembly:
    """Returns the assembly without some of its instances, and without the features that refer to them."""

    def stays(path: Path) -> bool:
        return path[:1] not in removed_instances

    return replace(
        assembly,
        occurrences={path: occurrence for path, occurrence in assembly.occurrences.items() if stays(path)},
        mates=[mate for mate in assembly.mates if stays(mate.ref.owner)],
        relations=[relation for relation in assembly.relations if stays(relation.owner)],
        groups=[
            replace(group, members=tuple(filter(stays, group.members)))
            for group in assembly.groups
            if stays(group.owner)
        ],
        connectors=[
            connector
            for connector in assembly.connectors
            if stays(connector.owner) and stays(connector.entity.path)
        ],
        patterns=[pattern for pattern in assembly.patterns if stays(pattern.owner)],
    )


def _link_names(
    assembly: Assembly, link_of_instance: Mapping[Path, Path], joints: Sequence[Mate]
) -> dict[Path, str]:
    """Returns the name of each link: by its `link_` connector, else after its first instance, numbered in the
    order of the joints from the root."""
    connector_names = _names_from_connectors(assembly, link_of_instance)
    neighbours: dict[Path, list[Path]] = {link_of_instance[path]: [] for path in _instances(assembly)}
    for mate in joints:
        first, second = (link_of_instance[side] for side in _sides(mate))
        neighbours[first].append(second)
        neighbours[second].append(first)
    # Names are unique over joints and links here, and joints, which others refer to, keep theirs.
    taken_names = {legal_name("_".join(joint_words(mate).words)) for mate in joints}
    names: dict[Path, str] = {}
    counts: dict[str, int] = {}
    waiting = list(reversed(neighbours))
    while waiting:
        link = waiting.pop()
        if link in names:
            continue
        waiting.extend(reversed(neighbours[link]))
        if link in connector_names:
            names[link] = connector_names[link]
            continue
        name = legal_name_or_unnamed(without_number(assembly.occurrences[link].names[-1]))
        name += "_link" if name in taken_names else ""
        counts[name] = counts.get(name, 0) + 1
        names[link] = name if counts[name] == 1 else f"{name}_{counts[name]}"
    return names


def _names_from_connectors(assembly: Assembly, link_of_instance: Mapping[Path, Path]) -> dict[Path, str]:
    """Returns the names that `link_` connectors give to links. The first connector of a link in the order of
    names wins, since later entries of a dict replace earlier ones."""
    return {
        link_of_instance[connector.entity.path[:1]]: legal_name(connector.name[len(LINK_PREFIX) :])
        for connector in sorted(
            assembly.connectors, key=lambda connector: (connector.name, connector.feature), reverse=True
        )
        if not connector.owner and is_link_name(connector) and connector.entity.path
    }


def _connectors_for_unnamed_links(
    assembly: Assembly, link_of_instance: Mapping[Path, Path], names: Mapping[Path, str]
) -> Iterator[Connector]:
    """Yields connectors that name the links without a `link_` connector."""
    named_links = set(_names_from_connectors(assembly, link_of_instance))
    for link, name in names.items():
        if link not in named_links:
            part_path = min(part.path for part in assembly.parts if part.path[:1] == link)
            entity = Entity(part_path, frozen(np.eye(4)))
            # It is not in CAD, so its name serves as the id of its feature.
            yield Connector(owner=(), feature=name, name=LINK_PREFIX + name, names=(), entity=entity)


def _named_connectors(assembly: Assembly) -> Iterator[Connector]:
    """Yields the root assembly's connectors that name links or mark frames."""
    for connector in assembly.connectors:
        if connector.owner or not connector.entity.path:
            continue
        if is_link_name(connector):
            yield connector
        elif connector.name.startswith(FRAME):
            yield replace(connector, name=connector.name[len(FRAME) :])


def _with_fixed_root(
    assembly: Assembly, link_of_instance: Mapping[Path, Path], root: Path, log: Diagnostics
) -> Assembly:
    """Returns the assembly without fixed instances outside the root link. Reports W-PEER-FIXED for them."""
    fixed_instances = {
        path: replace(occurrence, fixed=False)
        for path, occurrence in assembly.occurrences.items()
        if occurrence.fixed and link_of_instance[path[:1]] != root
    }
    if fixed_instances:
        titles = name_list(occurrence.title for occurrence in fixed_instances.values())
        message = f"fixed in CAD, but not in the root link, so they are not fixed in the robot: {titles}"
        log.report("W-PEER-FIXED", message, "conventions", "choose the root yourself (root.select) or fix it")
    return replace(assembly, occurrences={**assembly.occurrences, **fixed_instances})
