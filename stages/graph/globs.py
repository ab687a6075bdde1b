"""Globs and names that users give: a glob must match something, a new name must be free."""

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from fnmatch import translate
from typing import TypeVar

from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Joint, Loop, Robot
from linkwright.stages.robot.text.globs import there_are
from linkwright.stages.robot.text.names import RESERVED

Entry = TypeVar("Entry")


def entries_of(
    things: Sequence[Collection[str]],
    wanted: Mapping[str, Entry],
    where: str,
    kind: str,
    log: Diagnostics,
) -> Iterator[tuple[int, ...]]:
    """For each thing, given by its names, which entries of `wanted` match one of them, in their order.

    E-GLOB for each entry but "*" that matches nothing: it lists the first names, as things of a `kind`.
    """
    patterns = [(glob, re.compile(translate(glob)).match) for glob in wanted]
    found = [
        tuple(
            index
            for index, (glob, matches) in enumerate(patterns)
            if glob in names or any(map(matches, names))
        )
        for names in things
    ]
    used = {index for indices in found for index in indices}
    for index, glob in enumerate(wanted):
        if index not in used:
            hint = there_are(glob, {f"{kind}s": [min(names, key=lambda n: (len(n), n)) for names in things]})
            log.unmatched("E-GLOB", f"no {kind} matches {glob!r}", where, hint, glob)
    return iter(found)


def unusable(name: str, taken: Collection[str]) -> str:
    """Why this name is not allowed; "" if it is."""
    if not re.fullmatch("[A-Za-z0-9_]+", name):
        return f"invalid name {name!r}: only letters without accents, digits and _ are allowed"
    if name in RESERVED:
        return f"the name {name!r} is reserved"
    return f"the name {name!r} is taken" if name in taken else ""


def names_in(robot: Robot) -> set[str]:
    """Every name that something in the robot has."""
    joints: list[Joint | Loop] = [*robot.joints, *robot.loops]
    return (
        {link.name for link in robot.links}
        | {frame.name for frame in robot.frames}
        | {joint.name for joint in joints}
        | {dof.name for joint in joints for dof in joint.dofs}
    )
