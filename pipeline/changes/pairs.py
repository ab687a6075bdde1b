"""Which thing of one robot is which of another: by name, and where CAD has it under another name by that."""

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

Entry = Mapping[str, Any]
"""A row of a table of robot.json."""

Key = str | tuple[str, ...]
"""The field, or the fields, by which a row is found."""

_SAME_LINK = 0.5
"""A link under another name is one that has at least this share of the parts of both."""


@dataclass(frozen=True, slots=True)
class Pairs:
    """The rows of a table: those that both robots have, and those of one alone."""

    both: tuple[tuple[Entry, Entry], ...]
    removed: tuple[Entry, ...]
    added: tuple[Entry, ...]


@dataclass(frozen=True, slots=True)
class Names:
    """The names of the first robot → those of the second, where these differ: of links, and of joints and
    their dofs."""

    links: Mapping[str, str]
    joints: Mapping[str, str]


def paired(before: Sequence[Entry], after: Sequence[Entry], key: Key, names: Mapping[str, str]) -> Pairs:
    """Rows paired by `key`, those of `before` by the name that they have in the second robot."""
    later = {_found_by(one, key, {}): one for one in after}
    both, removed = [], []
    for one in before:
        name = _found_by(one, key, names)
        if name in later:
            both.append((one, later.pop(name)))
        else:
            removed.append(one)
    return Pairs(tuple(both), tuple(removed), tuple(later.values()))


def name_of(row: Entry, key: Key) -> str:
    """What a row is called by the fields by which it is found."""
    if isinstance(key, str):
        return str(row[key])
    joint = " and " if key == ("link_a", "link_b") else " "
    return joint.join(str(row[one]) for one in key)


def _found_by(row: Entry, key: Key, names: Mapping[str, str]) -> Hashable:
    if isinstance(key, str):
        return names.get(row[key], row[key])
    return tuple(names.get(row[one], row[one]) if one.startswith("link") else row[one] for one in key)


def renamed(before: Mapping[str, Any], after: Mapping[str, Any]) -> Names:
    """What CAD says is the same under another name: a link that shares at least half of its parts, a joint
    of the same mate."""
    links = _matched(before["links"], after["links"], _links_alike)
    joints = _matched(before["joints"], after["joints"], _mates_alike)
    loops = _matched(before["loops"], after["loops"], _mates_alike)
    dofs: dict[str, str] = {}
    for table, found in (("joints", joints), ("loops", loops)):
        old, new = ({one["name"]: one for one in robot[table]} for robot in (before, after))
        for was, now in found.items():
            pairs = zip(old[was]["dofs"], new[now]["dofs"], strict=False)
            dofs |= {one["name"]: other["name"] for one, other in pairs if one["name"] != other["name"]}
    return Names(links, joints | loops | dofs)


def _matched(
    before: Sequence[Entry], after: Sequence[Entry], same: Callable[[Entry, Entry], bool]
) -> dict[str, str]:
    """Names of rows that the other robot has under another name."""
    known = {one["name"] for one in before} & {one["name"] for one in after}
    waiting = [one for one in after if one["name"] not in known]
    found = {}
    for one in before:
        if one["name"] in known:
            continue
        twin = next((other for other in waiting if same(one, other)), None)
        if twin is not None:
            waiting.remove(twin)
            found[one["name"]] = twin["name"]
    return found


def _links_alike(one: Entry, other: Entry) -> bool:
    mine, theirs = ({tuple(part["path"]) for part in link["parts"] if part["path"]} for link in (one, other))
    return bool(mine) and len(mine & theirs) >= _SAME_LINK * max(len(mine), len(theirs))


def _mates_alike(one: Entry, other: Entry) -> bool:
    mine, theirs = ((joint["cad"] or {}) for joint in (one, other))
    key = ("owner", "feature")
    return bool(mine.get("feature")) and [mine.get(k) for k in key] == [theirs.get(k) for k in key]
