"""Pairs the rows of two robots: by name, or by CAD if a row was renamed."""

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

Entry = Mapping[str, Any]
"""A row of a table of robot.json."""

Key = str | tuple[str, ...]
"""The field, or the fields, by which a row is found."""

_MIN_COMMON_PARTS = 0.5
"""Least share of common parts for which two links with different names count as the same link."""


@dataclass(frozen=True, slots=True)
class Pairs:
    """The rows of a table in two robots."""

    both: tuple[tuple[Entry, Entry], ...]
    """The pairs of rows that both robots have."""
    removed: tuple[Entry, ...]
    """The rows of only the first robot."""
    added: tuple[Entry, ...]
    """The rows of only the second robot."""


@dataclass(frozen=True, slots=True)
class Names:
    """Maps names in the first robot to names in the second robot, where they differ."""

    links: Mapping[str, str]
    joints: Mapping[str, str]
    """Names of joints, loops and dofs."""


def pair_rows(before: Sequence[Entry], after: Sequence[Entry], key: Key, names: Mapping[str, str]) -> Pairs:
    """Pairs rows by `key`; rows of `before` are looked up by their names in the second robot."""
    new_rows = {_key_value(row, key, {}): row for row in after}
    both, removed = [], []
    for row in before:
        name = _key_value(row, key, names)
        if name in new_rows:
            both.append((row, new_rows.pop(name)))
        else:
            removed.append(row)
    return Pairs(tuple(both), tuple(removed), tuple(new_rows.values()))


def row_title(row: Entry, key: Key) -> str:
    """Returns the title of a row: its key fields, joined."""
    if isinstance(key, str):
        return str(row[key])
    joint = " and " if key == ("link_a", "link_b") else " "
    return joint.join(str(row[field]) for field in key)


def _key_value(row: Entry, key: Key, names: Mapping[str, str]) -> Hashable:
    """Returns the values of the key fields; links, and all keys of a single field, get their new names."""
    if isinstance(key, str):
        return names.get(row[key], row[key])
    return tuple(
        names.get(row[field], row[field]) if field.startswith("link") else row[field] for field in key
    )


def match_names(before: Mapping[str, Any], after: Mapping[str, Any]) -> Names:
    """Returns the new names of renamed links, joints and dofs. Two links are the same if they share at least
    half of their CAD parts; two joints, if they are the same mate."""
    links = _match_renamed(before["links"], after["links"], _is_same_link)
    joints = _match_renamed(before["joints"], after["joints"], _is_same_mate)
    loops = _match_renamed(before["loops"], after["loops"], _is_same_mate)
    dofs: dict[str, str] = {}
    for table, names in (("joints", joints), ("loops", loops)):
        old, new = ({row["name"]: row for row in robot[table]} for robot in (before, after))
        for old_name, new_name in names.items():
            pairs = zip(old[old_name]["dofs"], new[new_name]["dofs"], strict=False)
            changed = ((dof["name"], later["name"]) for dof, later in pairs if dof["name"] != later["name"])
            dofs |= dict(changed)
    return Names(links, joints | loops | dofs)


def _match_renamed(
    before: Sequence[Entry], after: Sequence[Entry], is_same: Callable[[Entry, Entry], bool]
) -> dict[str, str]:
    """Maps the names of renamed rows to their names in the other robot."""
    common = {row["name"] for row in before} & {row["name"] for row in after}
    unmatched = [row for row in after if row["name"] not in common]
    new_names = {}
    for row in before:
        if row["name"] in common:
            continue
        twin = next((later for later in unmatched if is_same(row, later)), None)
        if twin is not None:
            unmatched.remove(twin)
            new_names[row["name"]] = twin["name"]
    return new_names


def _is_same_link(first: Entry, second: Entry) -> bool:
    parts, other_parts = (
        {tuple(part["path"]) for part in link["parts"] if part["path"]} for link in (first, second)
    )
    return bool(parts) and len(parts & other_parts) >= _MIN_COMMON_PARTS * max(len(parts), len(other_parts))


def _is_same_mate(first: Entry, second: Entry) -> bool:
    mate, other_mate = ((joint["cad"] or {}) for joint in (first, second))
    key = ("owner", "feature")
    return bool(mate.get("feature")) and [mate.get(k) for k in key] == [other_mate.get(k) for k in key]
