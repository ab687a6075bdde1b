"""Documents made for onshape-to-robot: translates the conventions of its names into our own terms.

There a mate is a joint because of its name: `dof_NAME`, with `_inv` for the opposite direction and
`wheel` or `continuous` for no limits; `closing_NAME` closes a loop, `frame_NAME` marks a frame, `fix_`
and what is FASTENED without a prefix welds, and any other mate is passed over. Only the root assembly's
features count, and each of its instances is rigid. After the code of its release 1.8.3; what that does
by accident (undeclared loops, relations of inverted mates) is not reproduced.
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
    apart,
    joint,
    rest,
    turned_round,
    words,
)
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import frozen
from linkwright.stages.robot.section import Section
from linkwright.stages.robot.text.globs import escaped, listed, unnumbered
from linkwright.stages.robot.text.names import legal, legal_or_unnamed

AnySection = TypeVar("AnySection", bound=Section)


def translated(assembly: Assembly, keys: GraphSections, log: Diagnostics) -> tuple[Assembly, GraphSections]:
    """The assembly with plain names, and the keys that replace the conventions.

    To be called once limits are known, before anything is copied or merged. The root is the first
    instance, unless `root` chooses another, and is fixed where one of its occurrences is; links are
    called after their first instance; q counts from the saved pose.
    """
    meant = _by_meaning(assembly, log)
    links = _links(assembly, meant)
    markers = _markers(assembly, meant, log)
    assembly = _without(assembly, {marker.instance for marker in markers})
    names = _link_names(assembly, links, meant[DOF])
    first = links[_instances(assembly)[0]]
    if keys.root.select == "auto" and keys.root.frame is None:
        keys = _with(keys, root=_with(keys.root, select=escaped(names[first])))
        assembly = _held_at_the_root(assembly, links, first, log)
    if keys.depth.max is None:
        keys = _with(keys, depth=_with(keys.depth, max=0))
    closings = [escaped(mate.title) for mate in meant[CLOSING]]
    keys = _with(keys, zero="saved", loops=_with(keys.loops, cut=(*keys.loops.cut, *closings)))
    log.report(
        "I-PEER",
        f"names mean what they do in onshape-to-robot: the root is {keys.root.select}, q = 0 is the saved "
        f"pose (zero: saved), sub-assemblies are rigid (depth.max: {keys.depth.max})",
        "conventions",
    )
    joints = [one for mate in meant[DOF] for one in joint(mate, assembly, log)]
    closed = [
        replace(mate, ref=replace(mate.ref, type=apart(mate)))
        for mate in meant[CLOSING]
        if _present(mate, assembly)
    ]
    welds = [replace(mate, ref=replace(mate.ref, type="FASTENED")) for mate in meant[FIX]]
    inverted = {(mate.ref.owner, mate.ref.feature) for mate in meant[DOF] if words(mate)[1]}
    return replace(
        assembly,
        mates=[*joints, *closed, *welds, *(mate for mate in assembly.mates if mate.ref.owner)],
        relations=[turned_round(relation, inverted) for relation in assembly.relations],
        connectors=[
            *(marker.connector for marker in markers),
            *_connectors(assembly),
            *_named(assembly, links, names),
        ],
    ), keys


def _with(keys: AnySection, **values: object) -> AnySection:
    return keys.model_copy(update=values)


@dataclass(frozen=True, slots=True, eq=False)
class _Marker:
    """A frame, and the instance that only shows where it is."""

    connector: Connector
    instance: Path


def _by_meaning(assembly: Assembly, log: Diagnostics) -> dict[str, list[Mate]]:
    """The root assembly's mates by the meaning of their names. W-PEER-MATE for ignored mates."""
    meant: dict[str, list[Mate]] = {DOF: [], CLOSING: [], FRAME: [], FIX: []}
    origin, idle, inside = [], [], []
    for mate in assembly.mates:
        prefix = next((one for one in meant if mate.ref.name.startswith(one)), "")
        if mate.ref.owner:
            inside += [mate.title] if prefix in (DOF, CLOSING) else []
        elif not all(entity.path for entity in mate.entities):
            origin.append(mate.title)
        elif prefix or mate.ref.type == "FASTENED":
            meant[prefix or FIX].append(mate)
        else:
            idle.append(mate.title)
    for titles, what, hint in (
        (
            origin,
            "mates to the assembly's origin are ignored, as by onshape-to-robot",
            "fix the part instead, or set root.base: fixed",
        ),
        (
            idle,
            "mates without a prefix are ignored, as by onshape-to-robot",
            "call it dof_NAME for a joint, or fix_NAME for a weld",
        ),
        (
            inside,
            "mates inside a sub-assembly are ignored, as by onshape-to-robot: it is rigid",
            "name it in depth.flexible, or set conventions: linkwright",
        ),
    ):
        if titles:
            log.report("W-PEER-MATE", f"{what}: {listed(titles)}", titles[0], hint)
    return meant


def _instances(assembly: Assembly) -> list[Path]:
    """The root assembly's own instances, in its order: the first is the root."""
    return [path for path in assembly.occurrences if len(path) == 1]


def _links(assembly: Assembly, meant: Mapping[str, Sequence[Mate]]) -> dict[Path, Path]:
    """Each instance's link: the first, in the root assembly's order, of those welded with it."""
    welded = nx.Graph()
    instances = _instances(assembly)
    welded.add_nodes_from(instances)
    welded.add_edges_from(_sides(mate) for mate in meant[FIX])
    for group in assembly.groups:
        if not group.owner:
            nx.add_path(welded, [path[:1] for path in group.members])
    order = {path: number for number, path in enumerate(instances)}
    return {
        path: min(together, key=order.__getitem__)
        for together in nx.connected_components(welded)
        for path in together
    }


def _present(mate: Mate, assembly: Assembly) -> bool:
    return all(entity.path in assembly.occurrences for entity in mate.entities)


def _sides(mate: Mate) -> tuple[Path, Path]:
    """The instances of the root assembly that a mate joins."""
    first, second = (entity.path[:1] for entity in mate.entities)
    return first, second


def _markers(assembly: Assembly, meant: Mapping[str, Sequence[Mate]], log: Diagnostics) -> list[_Marker]:
    """What `frame_` mates mark: the frame of an instance that nothing else holds, on the one it is on."""
    held = {_instances(assembly)[0]}
    held.update(side for kind in (DOF, FIX) for mate in meant[kind] for side in _sides(mate))
    held.update(path[:1] for group in assembly.groups for path in group.members if len(group.members) > 1)
    made = []
    for mate in meant[FRAME]:
        loose = [entity for entity in mate.entities if entity.path[:1] not in held]
        if len(loose) != 1:
            what = "a frame_ mate joins a link and a part that only marks the frame: "
            what += "both sides are parts of links" if not loose else "nothing else holds either side"
            log.report("E-PEER-FRAME", what, mate.title, "free the marker of other mates, or rename this one")
            continue
        marker = loose[0]
        (carrier,) = (entity for entity in mate.entities if entity is not marker)
        held.add(marker.path[:1])
        carrier_from_marker = inverse(assembly.world_from_path(carrier.path)) @ assembly.world_from_path(
            marker.path
        )
        entity = Entity(carrier.path, frozen(carrier_from_marker))
        made.append(_Marker(Connector((), mate.ref.feature, rest(mate), (), entity), marker.path[:1]))
    if made:
        titles = listed(assembly.occurrences[one.instance].title for one in made)
        what = f"instances that only mark frames are left out: {titles}"
        log.report("I-PEER-MARKER", what, "conventions", "name a connector frame_NAME to keep the part")
    return made


def _without(assembly: Assembly, gone: Collection[Path]) -> Assembly:
    """The assembly without some of its instances, and without the features that refer to them."""

    def stays(path: Path) -> bool:
        return path[:1] not in gone

    return replace(
        assembly,
        occurrences={path: one for path, one in assembly.occurrences.items() if stays(path)},
        mates=[mate for mate in assembly.mates if stays(mate.ref.owner)],
        relations=[relation for relation in assembly.relations if stays(relation.owner)],
        groups=[
            replace(group, members=tuple(filter(stays, group.members)))
            for group in assembly.groups
            if stays(group.owner)
        ],
        connectors=[one for one in assembly.connectors if stays(one.owner) and stays(one.entity.path)],
        patterns=[pattern for pattern in assembly.patterns if stays(pattern.owner)],
    )


def _link_names(assembly: Assembly, links: Mapping[Path, Path], joints: Sequence[Mate]) -> dict[Path, str]:
    """The name of each link: by its `link_` connector, else after its first instance, numbered in the order
    of the joints from the root."""
    given = _given(assembly, links)
    around: dict[Path, list[Path]] = {links[path]: [] for path in _instances(assembly)}
    for mate in joints:
        first, second = (links[side] for side in _sides(mate))
        around[first].append(second)
        around[second].append(first)
    # Names are unique over joints and links here, and it is joints that others know by name.
    taken = {legal("_".join(words(mate)[0])) for mate in joints}
    names: dict[Path, str] = {}
    counts: dict[str, int] = {}
    waiting = list(reversed(around))
    while waiting:
        link = waiting.pop()
        if link in names:
            continue
        waiting.extend(reversed(around[link]))
        if link in given:
            names[link] = given[link]
            continue
        name = legal_or_unnamed(unnumbered(assembly.occurrences[link].names[-1]))
        name += "_link" if name in taken else ""
        counts[name] = counts.get(name, 0) + 1
        names[link] = name if counts[name] == 1 else f"{name}_{counts[name]}"
    return names


def _given(assembly: Assembly, links: Mapping[Path, Path]) -> dict[Path, str]:
    """The names that `link_` connectors give to links."""
    return {
        links[one.entity.path[:1]]: legal(one.name[len(LINK_PREFIX) :])
        for one in sorted(assembly.connectors, key=lambda one: (one.name, one.feature), reverse=True)
        if not one.owner and is_link_name(one) and one.entity.path
    }


def _named(assembly: Assembly, links: Mapping[Path, Path], names: Mapping[Path, str]) -> Iterator[Connector]:
    """Connectors that name the links which have none."""
    given = set(_given(assembly, links))
    for link, name in names.items():
        if link not in given:
            part = min(part.path for part in assembly.parts if part.path[:1] == link)
            yield Connector((), name, LINK_PREFIX + name, (), Entity(part, frozen(np.eye(4))))


def _connectors(assembly: Assembly) -> Iterator[Connector]:
    """The root assembly's connectors that name links or mark frames."""
    for one in assembly.connectors:
        if one.owner or not one.entity.path:
            continue
        if is_link_name(one):
            yield one
        elif one.name.startswith(FRAME):
            yield replace(one, name=one.name[len(FRAME) :])


def _held_at_the_root(
    assembly: Assembly, links: Mapping[Path, Path], root: Path, log: Diagnostics
) -> Assembly:
    """The assembly in which only the root link is fixed (W-PEER-FIXED for others)."""
    held = {
        path: replace(one, fixed=False)
        for path, one in assembly.occurrences.items()
        if one.fixed and links[path[:1]] != root
    }
    if held:
        titles = listed(one.title for one in held.values())
        what = f"fixed in CAD, but not in the root link, so they are not fixed in the robot: {titles}"
        log.report("W-PEER-FIXED", what, "conventions", "choose the root yourself (root.select) or fix it")
    return replace(assembly, occurrences={**assembly.occurrences, **held})
