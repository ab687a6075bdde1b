"""Finds the rigid bodies of an assembly: the parts that move together.

Parts joined by FASTENED mates or mate groups are one body; so are all parts fixed to the world, and all parts
in a rigid sub-assembly. The assembly's origin is a body of its own where something moves relative to it and
nothing is fixed to it.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import networkx as nx
import numpy as np

from linkwright.stages.graph.onshape.assembly import Assembly, Mate, Path
from linkwright.stages.graph.onshape.rigid_subassemblies import rigid_subassemblies
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.text.plural import count

WORLD: Path = ()
"""The assembly's origin, as a node beside the occurrences."""

MAX_LISTED = 6
"""Largest number of bodies of a sub-assembly that are listed by name."""


@dataclass(slots=True)
class Bodies:
    """The rigid bodies of an assembly."""

    of: dict[Path, int]
    """Occurrence path → index of the body, for parts, for sub-assemblies whose frame a body carries, and for
    the assembly's origin, (), if it is a body."""
    members: list[tuple[Path, ...]]
    """Sorted paths of each body's parts; empty for an origin to which no part is fixed."""
    world: int | None
    """Index of the body that has the assembly's origin; None if no body has it."""
    fixed_by: str
    """The part or mate that holds the origin; "" if `world` has no parts."""
    moving: list[Mate]
    """Mates between different bodies that can move."""


def find_bodies(
    assembly: Assembly, keys: GraphSections, log: Diagnostics, welds: Sequence[tuple[Path, Path]] = ()
) -> Bodies:
    """Merges occurrences that are rigidly connected, also the frames of sub-assemblies, and the pairs of
    `welds`. The frame of a sub-assembly moves with its parts if they are one body, else with the part that is
    fixed in it or fastened to its origin. Reports E-MATE-SUBASSEMBLY for a mate to a frame that no part
    carries, and mates that move nothing, except those that only `welds` make rigid.
    """
    merger = _Merger(assembly, rigid_subassemblies(assembly, keys.depth, log))
    merger.merge_drawn()
    idle = {mate.key for mate in assembly.mates if merger.is_idle(mate)}
    merger.merge(welds)
    _report_uncarried(merger, log)
    bodies = merger.bodies()
    _report_idle(merger, [mate for mate in assembly.mates if mate.key in idle], log)
    _report_mirrored(assembly, bodies.moving, log)
    return bodies


class _Merger:
    """Merges the occurrences and the origin step by step. `stiff`: paths of rigid sub-assemblies."""

    def __init__(self, assembly: Assembly, stiff: frozenset[Path]) -> None:
        self.assembly, self.stiff = assembly, stiff
        self.rigid = nx.utils.UnionFind([WORLD, *assembly.occurrences])
        self.reasons: list[str] = []
        self.leaves: dict[Path, list[Path]] = {}
        for part in assembly.parts:
            for depth in range(1, len(part.path)):
                self.leaves.setdefault(part.path[:depth], []).append(part.path)
        # A sub-assembly whose parts are mated to its origin has a frame of its own, as the root has.
        self.anchored = {
            mate.ref.owner
            for mate in assembly.mates
            if any(entity.path == mate.ref.owner for entity in mate.entities)
        }

    def merge_drawn(self) -> None:
        """Merges what mates, groups and the key `depth` make rigid."""
        for occurrence in self.assembly.occurrences.values():
            if occurrence.fixed:
                self.rigid.union(WORLD, occurrence.path)
                self.reasons.append(f"{occurrence.title} is fixed")
            if occurrence.path[:-1] in self.stiff:
                self.rigid.union(occurrence.path[:-1], occurrence.path)
        for mate in self.assembly.mates:
            first, second = (entity.path for entity in mate.entities)
            if mate.ref.type == "FASTENED" or mate.ref.owner in self.stiff:
                self.rigid.union(first, second)
                if WORLD in (first, second):
                    self.reasons.append(f"{mate.title} fastens it to the assembly origin")
        for group in self.assembly.groups:
            self.rigid.union(*group.members)
        self._carry_frames()
        for path in sorted((o.path for o in self.assembly.occurrences.values() if o.fixed), key=len):
            if len(path) > 1 and self.is_loose(path[:-1]):
                self.rigid.union(path, path[:-1])
        self._carry_frames()

    def merge(self, pairs: Iterable[tuple[Path, Path]]) -> None:
        """Makes the two occurrences of each pair one body."""
        for first, second in pairs:
            self.rigid.union(first, second)
        self._carry_frames()

    def _carry_frames(self) -> None:
        """Joins each sub-assembly's frame to its parts, once those are one body.

        That may join the parts on two frames into one body, so it is repeated until nothing changes.
        """
        unmerged = sorted(self.leaves, key=len, reverse=True)
        while unmerged:
            loose_frames = []
            for path in unmerged:
                body = self.rigid[self.leaves[path][0]]
                if all(self.rigid[leaf] == body for leaf in self.leaves[path]):
                    self.rigid.union(path, body)
                else:
                    loose_frames.append(path)
            if len(loose_frames) == len(unmerged):
                return
            unmerged = loose_frames[::-1]  # a chain that this order ran against is then done in a single pass

    def is_idle(self, mate: Mate) -> bool:
        """Tells whether a mate of a movable type has both sides in one body."""
        first, second = (self.rigid[entity.path] for entity in mate.entities)
        return mate.ref.type != "FASTENED" and bool(first == second)

    def is_loose(self, path: Path) -> bool:
        """Tells whether this is a sub-assembly whose frame none of its parts carries."""
        body = self.rigid[path]
        return path in self.leaves and all(self.rigid[leaf] != body for leaf in self.leaves[path])

    def bodies(self) -> Bodies:
        """Returns the bodies as merged so far, in the order of their parts; an origin without parts is
        first."""
        groups: dict[Path, list[Path]] = {}
        for part in self.assembly.parts:
            groups.setdefault(self.rigid[part.path], []).append(part.path)
        if self.rigid[WORLD] not in groups and self._moves_against_origin():
            groups[self.rigid[WORLD]] = []
        members = sorted((tuple(sorted(paths)), root) for root, paths in groups.items())
        numbers = {root: number for number, (_, root) in enumerate(members)}
        nodes = (WORLD, *self.assembly.occurrences)
        body_of = {path: numbers[self.rigid[path]] for path in nodes if self.rigid[path] in numbers}
        moving = [
            mate
            for mate in self.assembly.mates
            if not self.is_idle(mate)
            and mate.ref.type != "FASTENED"
            and all(entity.path in body_of for entity in mate.entities)  # else it is reported as a problem
        ]
        world = body_of.get(WORLD)
        parts = [paths for paths, _ in members]
        reason = min(self.reasons, default="") if world is not None and parts[world] else ""
        return Bodies(body_of, parts, world, reason, moving)

    def _moves_against_origin(self) -> bool:
        origin = self.rigid[WORLD]
        return any(
            sum(self.rigid[entity.path] == origin for entity in mate.entities) == 1
            for mate in self.assembly.mates
        )


def _report_uncarried(merger: _Merger, log: Diagnostics) -> None:
    """Reports each feature that holds a sub-assembly whose frame is fixed to none of its parts."""
    assembly, rigid = merger.assembly, merger.rigid
    body_nodes = {rigid[part.path] for part in assembly.parts} | {rigid[WORLD]}
    uncarried_frames = {
        path: f"parts move against each other ({_first_parts(merger, path)}): it is "
        "ambiguous which of them the mate holds"
        for path in merger.leaves
        if merger.is_loose(path) and not (path in merger.anchored and rigid[path] in body_nodes)
    }
    for path, reason in sorted(uncarried_frames.items()):
        occurrence = assembly.occurrences[path]
        if occurrence.fixed:
            text, hint = f"the sub-assembly is fixed, but its {reason}", "fix its base part instead"
            log.report(
                "E-FIXED-SUBASSEMBLY", text, occurrence.title, f"{hint}, {_remedy(occurrence.names[-1])}"
            )
    holders = [(mate.title, [entity.path for entity in mate.entities]) for mate in assembly.mates]
    holders += [(group.title, list(group.members)) for group in assembly.groups]
    holders += [
        (assembly.occurrences[path[:-1]].title, [path])
        for path in uncarried_frames
        if path[:-1] in merger.stiff
    ]
    for title, paths in holders:
        for path in paths:
            if path in uncarried_frames:
                occurrence = assembly.occurrences[path]
                text = f"this holds the sub-assembly {occurrence.title} as a whole, "
                text += f"but its {uncarried_frames[path]}"
                hint = f"mate to a part inside it, {_remedy(occurrence.names[-1])}"
                log.report("E-MATE-SUBASSEMBLY", text, title, hint)


def _remedy(name: str) -> str:
    return f'fasten its base part to its own origin, or make it rigid (depth.rigid: ["{name}"])'


def _first_parts(merger: _Merger, path: Path) -> str:
    """Returns the titles of the first part of each body in a sub-assembly."""
    first: dict[Path, str] = {}
    for leaf in merger.leaves[path]:
        first.setdefault(merger.rigid[leaf], "/".join(merger.assembly.occurrences[leaf].names[len(path) :]))
    names = sorted(first.values())
    return "; ".join(names[:MAX_LISTED] + ["..."] * (len(names) > MAX_LISTED))


def _report_idle(merger: _Merger, mates: Sequence[Mate], log: Diagnostics) -> None:
    """Reports mates that move nothing; those of rigid sub-assemblies are counted for the outermost."""
    rigid_counts: Counter[Path] = Counter()
    for mate in mates:
        path = mate.ref.owner
        if path not in merger.stiff:
            text = "both sides of this mate are in one link (fastened, fixed or rigid), so it moves nothing"
            log.report(
                "W-MATE-RIGID", text, mate.title, "suppress this mate, or the one that makes them one link"
            )
            continue
        while path[:-1] in merger.stiff:
            path = path[:-1]
        rigid_counts[path] += 1
    for path, number in sorted(rigid_counts.items()):
        welded = path in merger.assembly.stiff
        text = f"the sub-assembly is rigid: {count(number, 'joint')} inside it cannot move"
        hint = "mirror: joints lets it move" if welded else "depth.flexible makes it flexible"
        log.report("I-RIGID", text, merger.assembly.occurrences[path].title, hint)


def _report_mirrored(assembly: Assembly, moving: Sequence[Mate], log: Diagnostics) -> None:
    """Reports W-MIRROR for mates between a mirrored instance and one that is not: the y axis of the mirrored
    frame is reversed, so that both are right-handed."""
    for mate in moving:
        hands = {np.linalg.det(assembly.world_from(entity)[:3, :3]) > 0 for entity in mate.entities}
        if len(hands) == 2:
            text = "only one side of this mate is mirrored, so its zero was chosen by Linkwright"
            log.report("W-MIRROR", text, mate.title, "check its zero and its limits")
