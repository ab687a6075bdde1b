"""Globs and names that users give: a glob must match something, a new name must be free."""

import json
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from fnmatch import fnmatchcase, translate
from typing import TypeVar

from stages.robot.diagnostics import Diagnostics
from stages.robot.model import Joint, Loop, Robot
from stages.robot.names import RESERVED

Entry = TypeVar("Entry")

_SHOWN = 20


def unnumbered(name: str) -> str:
    """The name of an instance without its number: "Foot <2>" → "Foot"."""
    return re.sub(r"\s*<\d+>\s*\Z", "", name)


def with_plain(titles: Collection[str]) -> set[str]:
    """Titles of instances, and the same without their numbers."""
    return {*titles, *(unnumbered(title) for title in titles)}


def escaped(name: str) -> str:
    """The glob that matches only this name."""
    return re.sub(r"([*?[])", r"[\1]", name)


def fits(name: str, glob: str) -> bool:
    """Whether a glob matches this name: literally, or as a pattern."""
    return name == glob or fnmatchcase(name, glob)


def as_key(name: str) -> str:
    """The YAML key whose glob matches only this name."""
    glob = escaped(name)
    plain = re.fullmatch(r"[A-Za-z_][\w.-]*", glob, re.ASCII) and glob.lower() not in _YAML_WORDS
    return glob if plain else json.dumps(glob, ensure_ascii=False)


_YAML_WORDS = frozenset({"true", "false", "null", "yes", "no", "on", "off"})
"""Keys that YAML does not read as text."""


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
        if index not in used and glob != "*":
            known = listed(min(names, key=lambda n: (len(n), n)) for names in things)
            hint = f"{kind}s are: {known or 'none'}"
            log.report("E-GLOB", f"no {kind} matches {glob!r}", where, hint)
    return iter(found)


def listed(names: Iterable[str]) -> str:
    """The names as a sorted list for a message, without duplicates; a very long list is cut."""
    every = sorted(set(names))
    more = f" and {len(every) - _SHOWN} more" if len(every) > _SHOWN else ""
    return ", ".join(every[:_SHOWN]) + more


def matching(glob: str, things: Sequence[Collection[str]]) -> list[int]:
    """The things with a name equal to `glob`, else those with a name that matches it."""
    exact = [index for index, names in enumerate(things) if glob in names]
    return exact or [
        index for index, names in enumerate(things) if any(fnmatchcase(name, glob) for name in names)
    ]


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
