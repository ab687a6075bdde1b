"""Compares two robots, table by table of robot.json."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from linkwright.pipeline.changes.change import Change
from linkwright.pipeline.changes.pairs import Entry, Key, Names, name_of, paired, renamed
from linkwright.pipeline.changes.values import alike, described, is_pose

KEYED_BY: Mapping[str, Key] = {
    "links": "name",
    "joints": "name",
    "loops": "name",
    "relations": "name",
    "couplings": "follower",
    "frames": "name",
    "lowered": "joint",
    "merged": "link",
    "fused": "link",
    "transmissions": "name",
    "actuators": "name",
    "armatures": "dof",
    "compensated": "link",
    "keyframes": "name",
    "sensors": "name",
    "sensor_sites": "name",
    "cameras": "name",
    "shapes": ("link", "role", "number"),
    "colliders": ("link", "number"),
    "excludes": ("link_a", "link_b"),
    "touching": ("link_a", "link_b"),
    "surplus": "file",
}
"""Table of robot.json → the key by which its rows are found."""

_NAMED_AS: Mapping[str, Callable[[Names], Mapping[str, str]]] = {
    **dict.fromkeys(("links", "merged", "fused", "compensated"), lambda names: names.links),
    **dict.fromkeys(("shapes", "colliders", "excludes", "touching"), lambda names: names.links),
    **dict.fromkeys(
        ("joints", "loops", "couplings", "lowered", "actuators", "armatures"), lambda names: names.joints
    ),
}
"""Table → the new names of what its rows are found by; others have names of their own."""

_LINKS = ("parent", "child", "link", "link_a", "link_b", "into", "root")
_JOINTS = ("follower", "driver", "dof", "joint")
_OF_JOINTS = ("given", "values", "compensating")
"""Fields that name links, joints or dofs, and several of these."""

_WITH_DOFS = ("joints", "loops")
"""Tables whose rows list their degrees of freedom; the units of a row are those of its first."""

_APART = ("format", "version", "source", "order", *KEYED_BY)
"""What has rows of its own, or is no property of the robot: its document, and the places in arrays, which
follow from all else but the order of the rows."""

_OF_PARTS = ("path", "world")
"""Fields of a part that are its key, or follow from the others: where it stands in the assembly."""

_NOT_COMPARED = ("cad", "provenance", "unset", "estimated", "parts")
"""Fields of a row that say where its values come from; parts have a table of their own."""


def compare(before: Mapping[str, Any], after: Mapping[str, Any]) -> tuple[Change, ...]:
    """Every difference between two robots but those of rounding, in the order of robot.json."""
    names = renamed(before, after)
    return (*_robot(before, after, names), *_tables(before, after, names), *_order(before, after, names))


def _robot(before: Mapping[str, Any], after: Mapping[str, Any], names: Names) -> Iterator[Change]:
    """Differences of the robot as a whole, and of tables that this version does not know."""
    for key in dict.fromkeys((*before, *after)):
        if key not in _APART:
            one = _in_new_names(key, before.get(key), names)
            yield from _fields("robot", after["name"], key, one, after.get(key))


def _tables(before: Mapping[str, Any], after: Mapping[str, Any], names: Names) -> Iterator[Change]:
    for table, key in KEYED_BY.items():
        known = _NAMED_AS[table](names) if table in _NAMED_AS else {}
        pairs = paired(before.get(table, ()), after.get(table, ()), key, known)
        for one in pairs.removed:
            yield Change(table, name_of(one, key), "removed", before=one, text=_presence(table, one))
        for one in pairs.added:
            yield Change(table, name_of(one, key), "added", after=one, text=_presence(table, one))
        for one, other in pairs.both:
            yield from _rows(table, key, one, other, names)
        if table == "links":
            yield from _parts(before, after, names)


def _rows(table: str, key: Key, before: Entry, after: Entry, names: Names) -> Iterator[Change]:
    """Differences of a row that both robots have."""
    name, was = name_of(after, key), name_of(before, key)
    kind = after["dofs"][0]["kind"] if table in _WITH_DOFS and after["dofs"] else "turn"
    # An actuator that has the name of its joint has nothing of its own to tell.
    if was != name and table in ("links", "joints", "loops"):
        yield Change(table, name, "renamed", "name", was, name, f"was {was}")
    for field in dict.fromkeys((*before, *after)):
        if field == key or field in key or field in _NOT_COMPARED:
            continue
        if field == "dofs" and table in _WITH_DOFS:
            yield from _dofs(table, name, before[field], after[field], names)
        else:
            one = _in_new_names(field, before.get(field), names)
            yield from _fields(table, name, field, one, after.get(field), kind)


def _dofs(table: str, joint: str, before: Any, after: Any, names: Names) -> Iterator[Change]:
    """Differences of the degrees of freedom of a joint."""
    pairs = paired(before, after, "name", names.joints)
    for one in pairs.removed:
        yield Change(table, joint, "changed", one["name"], before=one, text=f"{one['name']} removed")
    for one in pairs.added:
        yield Change(table, joint, "changed", one["name"], after=one, text=f"{one['name']} added")
    for one, other in pairs.both:
        alone = len(after) == 1 and other["name"] == joint
        for field in dict.fromkeys((*one, *other)):
            if field in ("name", *_NOT_COMPARED):
                continue
            path = field if alone else f"{other['name']}.{field}"
            yield from _fields(table, joint, path, one.get(field), other.get(field), other["kind"])


def _parts(before: Mapping[str, Any], after: Mapping[str, Any], names: Names) -> Iterator[Change]:
    """CAD parts that came, went, went to another link, or moved in it."""
    old, new = _parts_of(before), _parts_of(after)
    for key, (link, part) in old.items():
        if key not in new:
            yield Change("parts", part["name"], "removed", before=part, text=f"from {link}, {_mass(part)}")
    for key, (link, part) in new.items():
        if key not in old:
            yield Change("parts", part["name"], "added", after=part, text=f"to {link}, {_mass(part)}")
            continue
        was, earlier = old[key]
        was = names.links.get(was, was)
        if was != link:
            yield Change("parts", part["name"], "changed", "link", was, link, f"went from {was} to {link}")
        for field in dict.fromkeys((*earlier, *part)):
            # Where a part goes to another link its pose is in another frame.
            if field not in _OF_PARTS and not (field == "pose" and was != link):
                yield from _fields("parts", part["name"], field, earlier.get(field), part.get(field))


def _parts_of(robot: Mapping[str, Any]) -> dict[tuple[Any, ...], tuple[str, Entry]]:
    """The parts of all links, by where they are in the assembly, else by link and name, and by which of
    several alike they are."""
    found: dict[tuple[Any, ...], tuple[str, Entry]] = {}
    for link in robot["links"]:
        for part in link["parts"]:
            key = tuple(part["path"]) or (link["name"], part["name"])
            number = 0
            while (*key, number) in found:
                number += 1
            found[*key, number] = link["name"], part
    return found


def _fields(
    section: str, name: str, path: str, before: Any, after: Any, kind: str = "turn"
) -> Iterator[Change]:
    """Differences of a value, of a mapping for each of its keys."""
    if isinstance(before, Mapping) and isinstance(after, Mapping) and not is_pose(before):
        for key in dict.fromkeys((*before, *after)):
            yield from _fields(section, name, f"{path}.{key}", before.get(key), after.get(key), kind)
    elif not alike(before, after, path):
        yield Change(section, name, "changed", path, before, after, described(path, before, after, kind))


def _order(before: Mapping[str, Any], after: Mapping[str, Any], names: Names) -> Iterator[Change]:
    """Tables of a file whose rows are the same in another order: arrays of a controller would be mixed up."""
    old, new = before.get("order") or {}, after.get("order") or {}
    for file in old.keys() & new.keys():
        for table in sorted(old[file].keys() & new[file].keys()):
            one = [names.joints.get(row["name"], row["name"]) for row in old[file][table]]
            other = [row["name"] for row in new[file][table]]
            if one != other and Counter(one) == Counter(other):
                shown, now = (", ".join(name or "(unnamed)" for name in row) for row in (one, other))
                text = f"{table} have another order: {shown} → {now}"
                yield Change("order", file, "changed", table, one, other, text)


def _in_new_names(field: str, value: Any, names: Names) -> Any:
    """A value of the first robot with the names that the second has for the same things."""
    if field in _OF_JOINTS and isinstance(value, Mapping):
        return {names.joints.get(key, key): one for key, one in value.items()}
    if field in _OF_JOINTS and isinstance(value, list):
        return [names.joints.get(one, one) for one in value]
    known = names.links if field in _LINKS else names.joints if field in _JOINTS else {}
    return known.get(value, value) if known and isinstance(value, str) else value


def _presence(table: str, row: Entry) -> str:
    """What is said of a row that came or went."""
    if table == "links":
        return _mass(row)
    if table in ("joints", "loops"):
        ends = ("parent", "child") if table == "joints" else ("link_a", "link_b")
        return f"{row['type']}, between {row[ends[0]]} and {row[ends[1]]}"
    if table in ("relations", "couplings"):
        return f"{row['multiplier']:.6g} times {row['driver']}"
    if table == "shapes":
        return str(row["file"] or (row["primitive"] or {}).get("kind", ""))
    if table == "armatures":
        return f"{row['value']:.6g}, {row['reason']}"
    if table in ("excludes", "touching"):
        return f"{1000 * row['depth']:.3g} mm deep at home"
    return f"on {row['link']}" if "link" in row else ""


def _mass(row: Entry) -> str:
    return f"{row['mass']:.6g} kg"
