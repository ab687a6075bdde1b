"""Rigid bodies: which parts move as one.

Parts joined by FASTENED mates or mate groups are one body; so are all parts fixed to the world.
"""

from dataclasses import dataclass

import networkx as nx

from stages.graph.assembly import Assembly, Mate, Path
from stages.robot.errors import Diagnostic

WORLD: Path = ()
"""The assembly origin, as a node beside the part occurrences."""


@dataclass(slots=True)
class Bodies:
    """`of`: occurrence path → body, of parts and of sub-assemblies whose own frame one body carries;
    `members`: body → sorted part paths; `world`: the fixed body, if any, and why (`fixed_by`);
    `moving`: the mates between occurrences that may move."""

    of: dict[Path, int]
    members: list[tuple[Path, ...]]
    world: int | None
    fixed_by: str
    moving: list[Mate]


def find_bodies(assembly: Assembly, problems: list[Diagnostic]) -> Bodies:
    """Merges what is rigid, sub-assembly frames included.

    The frame of a sub-assembly moves with its parts where they are one body, else with the part
    that is fastened to it from inside. What hangs on a frame that no part carries is a problem.
    """
    leaves = _leaves(assembly)
    rigid = nx.utils.UnionFind([WORLD, *assembly.occurrences])
    reasons = []
    for occurrence in assembly.occurrences.values():
        if occurrence.fixed:
            rigid.union(WORLD, occurrence.path)
            reasons.append(f"{occurrence.title} is fixed")
    for mate in assembly.mates:
        if mate.ref.type == "FASTENED":
            first, second = (entity.path for entity in mate.entities)
            rigid.union(first, second)
            if WORLD in (first, second):
                reasons.append(f"{mate.title} fastens it to the assembly origin")
    for group in assembly.groups:
        rigid.union(*group.members)
    _carry_frames(rigid, leaves)
    problems.extend(_uncarried(assembly, rigid, leaves))
    return _collect(assembly, rigid, min(reasons, default=""), problems)


def _leaves(assembly: Assembly) -> dict[Path, list[Path]]:
    """Part paths under every sub-assembly occurrence."""
    leaves: dict[Path, list[Path]] = {}
    for part in assembly.parts:
        for depth in range(1, len(part.path)):
            leaves.setdefault(part.path[:depth], []).append(part.path)
    return leaves


def _carry_frames(rigid: nx.utils.UnionFind, leaves: dict[Path, list[Path]]) -> None:
    """Joins each sub-assembly's frame to its parts, once those are one body.

    That may make one body of what hangs on two frames, so it is tried until nothing changes.
    """
    waiting = sorted(leaves, key=len, reverse=True)
    while waiting:
        left = []
        for path in waiting:
            if len({rigid[leaf] for leaf in leaves[path]}) == 1:
                rigid.union(path, leaves[path][0])
            else:
                left.append(path)
        if len(left) == len(waiting):
            return
        waiting = left


def _uncarried(
    assembly: Assembly, rigid: nx.utils.UnionFind, leaves: dict[Path, list[Path]]
) -> list[Diagnostic]:
    """Whatever holds a sub-assembly whose frame none of its own parts carries."""

    def loose(path: Path) -> bool:
        return path in leaves and rigid[path] not in {rigid[leaf] for leaf in leaves[path]}

    found = []
    for occurrence in assembly.occurrences.values():
        if occurrence.fixed and loose(occurrence.path):
            found.append(
                Diagnostic(
                    "E-FIXED-SUBASSEMBLY",
                    "the sub-assembly is fixed, but its parts move against each other: which of them "
                    "is meant is not known (not supported yet)",
                    occurrence.title,
                    "fix its base part instead, or fasten that part to the sub-assembly's own origin",
                )
            )
    holders = [(mate.title, [e.path for e in mate.entities]) for mate in assembly.mates]
    holders += [(group.title, list(group.members)) for group in assembly.groups]
    found.extend(
        Diagnostic(
            "E-MATE-SUBASSEMBLY",
            f"this holds {assembly.occurrences[path].title} as a whole, whose parts move against each "
            "other: which of them is meant is not known (not supported yet)",
            title,
            "mate to a part inside it, or fasten its base part to its own origin",
        )
        for title, paths in holders
        for path in paths
        if loose(path)
    )
    return found


def _collect(
    assembly: Assembly, rigid: nx.utils.UnionFind, fixed_by: str, problems: list[Diagnostic]
) -> Bodies:
    groups: dict[Path, list[Path]] = {}
    for part in assembly.parts:
        groups.setdefault(rigid[part.path], []).append(part.path)
    members = sorted(tuple(sorted(paths)) for paths in groups.values())
    body_of_root = {rigid[paths[0]]: index for index, paths in enumerate(members)}
    of = {path: body_of_root[rigid[path]] for path in assembly.occurrences if rigid[path] in body_of_root}
    moving = []
    for mate in assembly.mates:
        if mate.ref.type == "FASTENED":
            continue
        paths = [entity.path for entity in mate.entities]
        if WORLD in paths:
            problems.append(
                Diagnostic(
                    "E-MATE-ORIGIN",
                    f"a {mate.ref.type} mate to the assembly origin is not supported yet",
                    mate.title,
                    "fix a part at the origin and mate to that part",
                )
            )
        elif all(path in of for path in paths):  # else it is among the problems already
            moving.append(mate)
    return Bodies(of, members, body_of_root.get(rigid[WORLD]), fixed_by, moving)
