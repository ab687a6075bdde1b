"""Compares two robots, table by table of robot.json."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from linkwright.pipeline.changes.change import Change
from linkwright.pipeline.changes.pairs import Entry, Key, Names, match_names, pair_rows, row_title
from linkwright.pipeline.changes.values import are_equal, change_text, is_pose

TABLE_KEYS: Mapping[str, Key] = {
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
"""Maps each table of robot.json to the field, or fields, that identify its rows."""

_NEW_NAMES: Mapping[str, Callable[[Names], Mapping[str, str]]] = {
    **dict.fromkeys(("links", "merged", "fused", "compensated"), lambda names: names.links),
    **dict.fromkeys(("shapes", "colliders", "excludes", "touching"), lambda names: names.links),
    **dict.fromkeys(
        ("joints", "loops", "couplings", "lowered", "actuators", "armatures"), lambda names: names.joints
    ),
}
"""Maps each table to the new names of its rows' keys. The rows of other tables are named differently."""

_LINK_FIELDS = ("parent", "child", "link", "link_a", "link_b", "into", "root")
"""Fields that name a link."""

_JOINT_FIELDS = ("follower", "driver", "dof", "joint")
"""Fields that name a joint or a dof."""

_JOINT_COLLECTIONS = ("given", "values", "compensating")
"""Fields that name several joints or dofs."""

_TABLES_WITH_DOFS = ("joints", "loops")
"""Tables whose rows list degrees of freedom; the kind of the first dof decides the units of a row."""

_SKIPPED_KEYS = ("format", "version", "source", "order", *TABLE_KEYS)
"""Keys that are not compared as values of the robot: tables, which are compared row by row; fields of the
document; and `order`, the positions in arrays, which `_order_changes` compares."""

_SKIPPED_PART_FIELDS = ("path", "world")
"""Fields of a part that are not compared: `path` is its key, and `world` follows from other fields."""

_SKIPPED_FIELDS = ("cad", "provenance", "unset", "estimated", "parts")
"""Fields of a row that are not compared: the origin of its values, and parts, which are a table here."""


def compare(before: Mapping[str, Any], after: Mapping[str, Any]) -> tuple[Change, ...]:
    """Returns all differences between two robots beyond rounding, in the order of robot.json."""
    names = match_names(before, after)
    return (
        *_robot_changes(before, after, names),
        *_table_changes(before, after, names),
        *_order_changes(before, after, names),
    )


def _robot_changes(before: Mapping[str, Any], after: Mapping[str, Any], names: Names) -> Iterator[Change]:
    """Yields differences of the robot as a whole, and of tables that this version does not know."""
    for key in dict.fromkeys((*before, *after)):
        if key not in _SKIPPED_KEYS:
            value = _with_new_names(key, before.get(key), names)
            yield from _field_changes("robot", after["name"], key, value, after.get(key))


def _table_changes(before: Mapping[str, Any], after: Mapping[str, Any], names: Names) -> Iterator[Change]:
    for table, row_key in TABLE_KEYS.items():
        new_names = _NEW_NAMES[table](names) if table in _NEW_NAMES else {}
        pairs = pair_rows(before.get(table, ()), after.get(table, ()), row_key, new_names)
        for row in pairs.removed:
            yield Change(table, row_title(row, row_key), "removed", before=row, text=_row_text(table, row))
        for row in pairs.added:
            yield Change(table, row_title(row, row_key), "added", after=row, text=_row_text(table, row))
        for earlier, later in pairs.both:
            yield from _row_changes(table, row_key, earlier, later, names)
        if table == "links":
            yield from _part_changes(before, after, names)


def _row_changes(table: str, row_key: Key, before: Entry, after: Entry, names: Names) -> Iterator[Change]:
    """Yields differences of a row that both robots have."""
    name, old_name = row_title(after, row_key), row_title(before, row_key)
    kind = after["dofs"][0]["kind"] if table in _TABLES_WITH_DOFS and after["dofs"] else "turn"
    # An actuator is named after its joint: its renaming would only repeat that of the joint.
    if old_name != name and table in ("links", "joints", "loops"):
        yield Change(table, name, "renamed", "name", old_name, name, f"was {old_name}")
    key_fields = (row_key,) if isinstance(row_key, str) else row_key
    for field in dict.fromkeys((*before, *after)):
        if field in key_fields or field in _SKIPPED_FIELDS:
            continue
        if field == "dofs" and table in _TABLES_WITH_DOFS:
            yield from _dof_changes(table, name, before[field], after[field], names)
        else:
            value = _with_new_names(field, before.get(field), names)
            yield from _field_changes(table, name, field, value, after.get(field), kind)


def _dof_changes(table: str, joint: str, before: Any, after: Any, names: Names) -> Iterator[Change]:
    """Yields differences of the degrees of freedom of a joint."""
    pairs = pair_rows(before, after, "name", names.joints)
    for dof in pairs.removed:
        yield Change(table, joint, "changed", dof["name"], before=dof, text=f"{dof['name']} removed")
    for dof in pairs.added:
        yield Change(table, joint, "changed", dof["name"], after=dof, text=f"{dof['name']} added")
    for earlier, later in pairs.both:
        is_single = len(after) == 1 and later["name"] == joint
        for field in dict.fromkeys((*earlier, *later)):
            if field in ("name", *_SKIPPED_FIELDS):
                continue
            path = field if is_single else f"{later['name']}.{field}"
            yield from _field_changes(table, joint, path, earlier.get(field), later.get(field), later["kind"])


def _part_changes(before: Mapping[str, Any], after: Mapping[str, Any], names: Names) -> Iterator[Change]:
    """Yields the changes of CAD parts: added or removed, gone to another link, or moved in their link."""
    old, new = _parts_of(before), _parts_of(after)
    for key, (link, part) in old.items():
        if key not in new:
            yield Change(
                "parts", part["name"], "removed", before=part, text=f"from {link}, {_mass_text(part)}"
            )
    for key, (link, part) in new.items():
        if key not in old:
            yield Change("parts", part["name"], "added", after=part, text=f"to {link}, {_mass_text(part)}")
            continue
        old_link, earlier = old[key]
        old_link = names.links.get(old_link, old_link)
        if old_link != link:
            yield Change(
                "parts", part["name"], "changed", "link", old_link, link, f"went from {old_link} to {link}"
            )
        for field in dict.fromkeys((*earlier, *part)):
            # In another link the part's pose is in another frame.
            if field not in _SKIPPED_PART_FIELDS and not (field == "pose" and old_link != link):
                yield from _field_changes("parts", part["name"], field, earlier.get(field), part.get(field))


def _parts_of(robot: Mapping[str, Any]) -> dict[tuple[Any, ...], tuple[str, Entry]]:
    """Maps a key of each part to its link and row. The key is the part's place in the assembly, else the
    names of link and part; a number at its end tells equal keys apart."""
    parts: dict[tuple[Any, ...], tuple[str, Entry]] = {}
    for link in robot["links"]:
        for part in link["parts"]:
            key = tuple(part["path"]) or (link["name"], part["name"])
            number = 0
            while (*key, number) in parts:
                number += 1
            parts[*key, number] = link["name"], part
    return parts


def _field_changes(
    section: str, name: str, path: str, before: Any, after: Any, kind: str = "turn"
) -> Iterator[Change]:
    """Yields the difference of a value, or the differences of a mapping's keys. `kind`: the kind of the dof
    whose units the value has, "turn" or "slide"."""
    if isinstance(before, Mapping) and isinstance(after, Mapping) and not is_pose(before):
        for key in dict.fromkeys((*before, *after)):
            yield from _field_changes(section, name, f"{path}.{key}", before.get(key), after.get(key), kind)
    elif not are_equal(before, after, path):
        yield Change(section, name, "changed", path, before, after, change_text(path, before, after, kind))


def _order_changes(before: Mapping[str, Any], after: Mapping[str, Any], names: Names) -> Iterator[Change]:
    """Yields a change for each table of a file whose rows are the same in another order, which would mix up a
    controller's arrays."""
    old, new = before.get("order") or {}, after.get("order") or {}
    for file in (file for file in new if file in old):
        for table in sorted(old[file].keys() & new[file].keys()):
            earlier = [names.joints.get(row["name"], row["name"]) for row in old[file][table]]
            later = [row["name"] for row in new[file][table]]
            if earlier != later and Counter(earlier) == Counter(later):
                texts = (", ".join(name or "(unnamed)" for name in row) for row in (earlier, later))
                text = f"{table} have another order: {' → '.join(texts)}"
                yield Change("order", file, "changed", table, earlier, later, text)


def _with_new_names(field: str, value: Any, names: Names) -> Any:
    """Returns a value of the first robot with the second robot's names for the same things."""
    if field in _JOINT_COLLECTIONS and isinstance(value, Mapping):
        return {names.joints.get(key, key): entry for key, entry in value.items()}
    if field in _JOINT_COLLECTIONS and isinstance(value, list):
        return [names.joints.get(name, name) for name in value]
    new_names = names.links if field in _LINK_FIELDS else names.joints if field in _JOINT_FIELDS else {}
    return new_names.get(value, value) if new_names and isinstance(value, str) else value


def _row_text(table: str, row: Entry) -> str:
    """Describes a row that was added or removed."""
    if table == "links":
        return _mass_text(row)
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


def _mass_text(row: Entry) -> str:
    return f"{row['mass']:.6g} kg"
