"""Matches the globs that users give with names, and checks that new names are free."""

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from fnmatch import translate
from typing import TypeVar

from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Joint, Loop, Robot
from linkwright.stages.robot.text.globs import no_match_hint
from linkwright.stages.robot.text.names import RESERVED

Entry = TypeVar("Entry")


def entries_of(
    name_groups: Sequence[Collection[str]],
    sections: Mapping[str, Entry],
    where: str,
    kind: str,
    log: Diagnostics,
) -> Iterator[tuple[int, ...]]:
    """Yields for each thing the indices of the globs of `sections` that match any of its names, in order.
    `name_groups`: the names of each thing; `kind`: what the things are, such as "joint". Reports E-GLOB for
    each glob that matches nothing, with the shortest name of each thing.
    """
    patterns = [(glob, re.compile(translate(glob)).match) for glob in sections]
    indices_by_thing = [
        tuple(
            index
            for index, (glob, matches) in enumerate(patterns)
            if glob in names or any(map(matches, names))
        )
        for names in name_groups
    ]
    used_indices = {index for indices in indices_by_thing for index in indices}
    for index, glob in enumerate(sections):
        if index not in used_indices:
            hint = no_match_hint(
                glob, {f"{kind}s": [min(names, key=lambda n: (len(n), n)) for names in name_groups]}
            )
            log.report_unmatched("E-GLOB", f"no {kind} matches {glob!r}", where, hint, glob)
    return iter(indices_by_thing)


def why_unusable(name: str, taken_names: Collection[str]) -> str:
    """Returns why this name is not allowed; "" if it is."""
    if not re.fullmatch("[A-Za-z0-9_]+", name):
        return f"invalid name {name!r}: only letters without accents, digits and _ are allowed"
    if name in RESERVED:
        return f"the name {name!r} is reserved"
    return f"the name {name!r} is taken" if name in taken_names else ""


def names_in(robot: Robot) -> set[str]:
    """Returns every name that something in the robot has."""
    joints: list[Joint | Loop] = [*robot.joints, *robot.loops]
    return (
        {link.name for link in robot.links}
        | {frame.name for frame in robot.frames}
        | {joint.name for joint in joints}
        | {dof.name for joint in joints for dof in joint.dofs}
    )
