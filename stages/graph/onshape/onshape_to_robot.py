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
    as_joint_mate,
    joint_words,
    type_between_links,
    unprefixed_name,
    with_inverted_mates,
)
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import frozen
from linkwright.stages.robot.section import Section
from linkwright.stages.robot.text.globs import exact_glob, name_list, without_number
from linkwright.stages.robot.text.names import legal, legal_or_unnamed

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
    links = _links(assembly, mates_by_meaning)
    markers = _markers(assembly, mates_by_meaning, log)
    assembly = _without_instances(assembly, {marker.instance for marker in markers})
    names = _link_names(assembly, links, mates_by_meaning[DOF])
    first = links[_instances(assembly)[0]]
    if keys.root.select == "auto" and keys.root.frame is None:
        keys = _with_values(keys, root=_with_values(keys.root, select=exact_glob(names[first])))
        assembly = _with_fixed_root(assembly, links, first, log)
    if keys.depth.max is None:
        keys = _with_values(keys, depth=_with_values(keys.depth, max=0))
    closings = [exact_glob(mate.title) for mate in mates_by_meaning[CLOSING]]
    keys = _with_values(keys, zero="saved", loops=_with_values(keys.loops, cut=(*keys.loops.cut, *closings)))
    log.report(
        "I-PEER",
        f"names mean what they mean in onshape-to-robot: the root is {keys.root.select}, q = 0 is the saved "
        f"pose (zero: saved), sub-assemblies are rigid (depth.max: {keys.depth.max})",
        "conventions",
    )
    joints = [
        joint for mate in mates_by_meaning[DOF] if (joint := as_joint_mate(mate, assembly, log)) is not None
    ]
    loop_mates = [
        replace(mate, ref=replace(mate.ref, type=type_between_links(mate)))
        for mate in mates_by_meaning[CLOSING]
        if _has_both_sides(mate, assembly)
    ]
    welds = [replace(mate, ref=replace(mate.ref, type="FASTENED")) for mate in mates_by_meaning[FIX]]
    inverted_mates = {
        (mate.ref.owner, mate.ref.feature) for mate in mates_by_meaning[DOF] if joint_words(mate).inverted
    }
    return replace(
        assembly,
        mates=[*joints, *loop_mates, *welds, *(mate for mate in assembly.mates if mate.ref.owner)],
        relations=[with_inverted_mates(relation, inverted_mates) for relation in assembly.relations],
        connectors=[
            *(marker.connector for marker in markers),
            *_connectors(assembly),
            *_naming_connectors(assembly, links, names),
        ],
    ), keys


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
    origin_titles, plain_titles, inner_titles = [], [], []
    for mate in assembly.mates:
        prefix = next(
            (known_prefix for known_prefix in mates_by_meaning if mate.ref.name.startswith(known_prefix)), ""
        )
        if mate.ref.owner:
            inner_titles += [mate.title] if prefix in (DOF, CLOSING) else []
        elif not all(entity.path for entity in mate.entities):
            origin_titles.append(mate.title)
        elif prefix or mate.ref.type == "FASTENED":
            mates_by_meaning[prefix or FIX].append(mate)
        else:
            plain_titles.append(mate.title)
    for titles, message, hint in (
        (
            origin_titles,
            "mates to the assembly's origin are ignored, as by onshape-to-robot",
            "fix the part instead, or set root.base: fixed",
        ),
        (
            plain_titles,
            "mates without a prefix are ignored, as by onshape-to-robot",
            "call it dof_NAME for a joint, or fix_NAME for a weld",
        ),
        (
            inner_titles,
            "mates inside a sub-assembly are ignored, as by onshape-to-robot: it is rigid",
            "name it in depth.flexible, or set conventions: linkwright",
        ),
    ):
        if titles:
            log.report("W-PEER-MATE", f"{message}: {name_list(titles)}", titles[0], hint)
    return mates_by_meaning


def _instances(assembly: Assembly) -> list[Path]:
    """Returns the root assembly's own instances, in its order: the first is the root."""
    return [path for path in assembly.occurrences if len(path) == 1]


def _links(assembly: Assembly, mates_by_meaning: Mapping[str, Sequence[Mate]]) -> dict[Path, Path]:
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


def _has_both_sides(mate: Mate, assembly: Assembly) -> bool:
    return all(entity.path in assembly.occurrences for entity in mate.entities)


def _sides(mate: Mate) -> tuple[Path, Path]:
    """Returns the instances of the root assembly that a mate joins."""
    first, second = (entity.path[:1] for entity in mate.entities)
    return first, second


def _markers(
    assembly: Assembly, mates_by_meaning: Mapping[str, Sequence[Mate]], log: Diagnostics
) -> list[_Marker]:
    """Returns the frames that `frame_` mates mark: each that of an instance that nothing else holds, on its
    carrier."""
    held_instances = {_instances(assembly)[0]}
    held_instances.update(
        side for kind in (DOF, FIX) for mate in mates_by_meaning[kind] for side in _sides(mate)
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
        markers.append(
            _Marker(Connector((), mate.ref.feature, unprefixed_name(mate), (), entity), marker.path[:1])
        )
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


def _link_names(assembly: Assembly, links: Mapping[Path, Path], joints: Sequence[Mate]) -> dict[Path, str]:
    """Returns the name of each link: by its `link_` connector, else after its first instance, numbered in the
    order of the joints from the root."""
    connector_names = _link_titles(assembly, links)
    neighbours: dict[Path, list[Path]] = {links[path]: [] for path in _instances(assembly)}
    for mate in joints:
        first, second = (links[side] for side in _sides(mate))
        neighbours[first].append(second)
        neighbours[second].append(first)
    # Names are unique over joints and links here, and joints, which others refer to, keep theirs.
    taken_names = {legal("_".join(joint_words(mate).words)) for mate in joints}
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
        name = legal_or_unnamed(without_number(assembly.occurrences[link].names[-1]))
        name += "_link" if name in taken_names else ""
        counts[name] = counts.get(name, 0) + 1
        names[link] = name if counts[name] == 1 else f"{name}_{counts[name]}"
    return names


def _link_titles(assembly: Assembly, links: Mapping[Path, Path]) -> dict[Path, str]:
    """Returns the names that `link_` connectors give to links."""
    return {
        links[connector.entity.path[:1]]: legal(connector.name[len(LINK_PREFIX) :])
        for connector in sorted(
            assembly.connectors, key=lambda connector: (connector.name, connector.feature), reverse=True
        )
        if not connector.owner and is_link_name(connector) and connector.entity.path
    }


def _naming_connectors(
    assembly: Assembly, links: Mapping[Path, Path], names: Mapping[Path, str]
) -> Iterator[Connector]:
    """Yields connectors that name the links without a `link_` connector."""
    named_links = set(_link_titles(assembly, links))
    for link, name in names.items():
        if link not in named_links:
            part = min(part.path for part in assembly.parts if part.path[:1] == link)
            yield Connector((), name, LINK_PREFIX + name, (), Entity(part, frozen(np.eye(4))))


def _connectors(assembly: Assembly) -> Iterator[Connector]:
    """Yields the root assembly's connectors that name links or mark frames."""
    for connector in assembly.connectors:
        if connector.owner or not connector.entity.path:
            continue
        if is_link_name(connector):
            yield connector
        elif connector.name.startswith(FRAME):
            yield replace(connector, name=connector.name[len(FRAME) :])


def _with_fixed_root(
    assembly: Assembly, links: Mapping[Path, Path], root: Path, log: Diagnostics
) -> Assembly:
    """Returns the assembly in which only the root link is fixed (W-PEER-FIXED for others)."""
    fixed_instances = {
        path: replace(occurrence, fixed=False)
        for path, occurrence in assembly.occurrences.items()
        if occurrence.fixed and links[path[:1]] != root
    }
    if fixed_instances:
        titles = name_list(occurrence.title for occurrence in fixed_instances.values())
        message = f"fixed in CAD, but not in the root link, so they are not fixed in the robot: {titles}"
        log.report("W-PEER-FIXED", message, "conventions", "choose the root yourself (root.select) or fix it")
    return replace(assembly, occurrences={**assembly.occurrences, **fixed_instances})
