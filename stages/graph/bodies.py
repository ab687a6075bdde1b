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
    """`of`: part path → body; `members`: body → sorted part paths; `world`: the fixed body, if any."""

    of: dict[Path, int]
    members: list[tuple[Path, ...]]
    world: int | None
    fixed_by: str
    moving: list[Mate]


def find_bodies(assembly: Assembly, problems: list[Diagnostic]) -> Bodies:
    """Merges what is rigid. `moving` keeps the mates that join two bodies, entities resolved to parts."""
    rigid = nx.utils.UnionFind([WORLD, *(part.path for part in assembly.parts)])
    leaves = _leaves(assembly)
    fixed_by = ""
    pairs: list[tuple[Path, Path, str]] = []
    for occurrence in assembly.occurrences.values():
        if occurrence.fixed:
            pairs.append((WORLD, occurrence.path, occurrence.title))
            fixed_by = min(filter(None, (fixed_by, f"{occurrence.title} is fixed")))
    for mate in assembly.mates:
        if mate.ref.type == "FASTENED":
            first, second = (entity.path for entity in mate.entities)
            pairs.append((first, second, mate.title))
            if WORLD in (first, second):
                fixed_by = min(filter(None, (fixed_by, f"{mate.title} fastens it to the assembly origin")))
    for group in assembly.groups:
        pairs.extend((group.members[0], member, group.title) for member in group.members[1:])
    _merge(rigid, leaves, pairs, problems)
    return _collect(assembly, rigid, leaves, fixed_by, problems)


def _leaves(assembly: Assembly) -> dict[Path, list[Path]]:
    """Part paths under every sub-assembly occurrence."""
    leaves: dict[Path, list[Path]] = {}
    for part in assembly.parts:
        for depth in range(1, len(part.path)):
            leaves.setdefault(part.path[:depth], []).append(part.path)
    return leaves


def _part_of(rigid: nx.utils.UnionFind, leaves: dict[Path, list[Path]], path: Path) -> Path | None:
    """The part that stands for `path`: itself, or any part of a sub-assembly that is one body."""
    inside = leaves.get(path)
    if inside is None:
        return path if path in rigid.parents else None  # a sub-assembly without any part
    return inside[0] if len({rigid[leaf] for leaf in inside}) == 1 else None


def _merge(
    rigid: nx.utils.UnionFind,
    leaves: dict[Path, list[Path]],
    pairs: list[tuple[Path, Path, str]],
    problems: list[Diagnostic],
) -> None:
    """Unites all pairs. One that names a sub-assembly waits until that has become one body."""
    while pairs:
        waiting = []
        for first, second, title in pairs:
            a, b = _part_of(rigid, leaves, first), _part_of(rigid, leaves, second)
            if a is None or b is None:
                waiting.append((first, second, title))
            else:
                rigid.union(a, b)
        if len(waiting) == len(pairs):
            problems.extend(_flexible(title) for *_, title in waiting)
            return
        pairs = waiting


def _flexible(title: str) -> Diagnostic:
    return Diagnostic(
        "E-MATE-SUBASSEMBLY",
        "this holds a sub-assembly as a whole, whose parts move against each other: "
        "which of them is meant is not known (not supported yet)",
        title,
        "mate to a part inside the sub-assembly instead",
    )


def _collect(
    assembly: Assembly,
    rigid: nx.utils.UnionFind,
    leaves: dict[Path, list[Path]],
    fixed_by: str,
    problems: list[Diagnostic],
) -> Bodies:
    groups: dict[Path, list[Path]] = {}
    for part in assembly.parts:
        groups.setdefault(rigid[part.path], []).append(part.path)
    members = sorted(tuple(sorted(paths)) for paths in groups.values())
    of = {path: index for index, paths in enumerate(members) for path in paths}
    world = next((of[path] for path in of if rigid[path] == rigid[WORLD]), None)
    moving = []
    for mate in assembly.mates:
        if mate.ref.type == "FASTENED":
            continue
        sides = [_part_of(rigid, leaves, entity.path) for entity in mate.entities]
        if WORLD in sides:
            problems.append(
                Diagnostic(
                    "E-MATE-ORIGIN",
                    f"a {mate.ref.type} mate to the assembly origin is not supported yet",
                    mate.title,
                    "fix a part at the origin and mate to that part",
                )
            )
        elif None in sides:
            problems.append(_flexible(mate.title))
        else:
            of.update({entity.path: of[side] for entity, side in zip(mate.entities, sides) if side})
            moving.append(mate)
    return Bodies(of, members, world, fixed_by, moving)
