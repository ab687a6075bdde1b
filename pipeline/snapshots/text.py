"""Writes and reads the text of a snapshot: lines `key: value` in sections, so that a diff shows each change.

Its configuration contains only differences from the defaults. So each line is a setting in a file, and a new
version of Linkwright, whose new keys no file sets, leaves the text unchanged.
"""

import functools
import json
import operator
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import Any

from linkwright.pipeline.config.compose import Composed
from linkwright.pipeline.config.plain import as_written
from linkwright.pipeline.config.presets import GROUPS, MULTIPLE_GROUPS
from linkwright.pipeline.key_path import Place, key_of
from linkwright.pipeline.snapshots.figures import Figures
from linkwright.pipeline.snapshots.subjects import SnapshotSubject

HEAD = "linkwright snapshot"
FORMAT = 1
"""Must be increased when earlier texts can no longer be compared."""

CHOICES, CONFIGURATION, FIGURES = "choices", "configuration", "figures"

ALWAYS_WRITTEN: Place = ("source", "kind")
"""The key that is always written, since it determines which other keys its section has."""

Entries = Mapping[tuple[str, str], str]
"""Maps section and key to the value; the section of the subject is ""."""


def snapshot_text(subject: SnapshotSubject, composed: Composed, figures: Figures) -> str:
    """Returns the snapshot's text, which is the same in any folder and on any computer."""
    chosen = (f"{key}: {_on_one_line(option)}" for key, option in subject.chosen_options.items())
    lines = [f"{HEAD} {FORMAT}", *chosen]
    sections = {
        CHOICES: _choices(composed),
        CONFIGURATION: dict(_changed_keys(composed)),
        FIGURES: figures.lines(),
    }
    for name, entries in sections.items():
        lines += ["", f"[{name}]", *(f"{key}: {_on_one_line(value)}" for key, value in entries.items())]
    return "\n".join(lines) + "\n"


def read_entries(snapshot: str) -> Entries | None:
    """Returns the entries of a snapshot's text; None if the text is not a snapshot of this format."""
    head, *lines = snapshot.replace("\r\n", "\n").split("\n")
    if head != f"{HEAD} {FORMAT}":
        return None
    section = ""
    entries: dict[tuple[str, str], str] = {}
    for line in lines:
        key, colon, value = line.partition(": ")
        if colon:
            # A name in a key may contain a colon: keys that begin alike are one entry with all values.
            earlier_value = entries.get((section, key))
            entries[section, key] = value if earlier_value is None else f"{earlier_value}; {value}"
        elif line.startswith("["):
            section = line.strip("[]")
    return entries


def subject_of(entries: Entries) -> SnapshotSubject:
    """Returns the subject of a snapshot."""
    return SnapshotSubject(*(_read_text(entries.get(("", key), "")) for key in ("robot", "experiment")))


def _choices(composed: Composed) -> dict[str, Any]:
    """Returns the chosen options of each group, including defaults, without the option `none`."""
    choices = composed.config.hydra.runtime.choices
    option_of_group = {str(group): option for group, option in choices.items()}
    chosen = {group: option_of_group.get(group) for group in GROUPS if group not in MULTIPLE_GROUPS}
    plan = composed.plan.tree()
    for group in MULTIPLE_GROUPS:
        chosen[group] = sorted(name for name, keys in plan[group].items() if keys is not None)
    chosen |= {
        group: option for group, option in option_of_group.items() if group not in GROUPS and "/" not in group
    }
    return {group: chosen[group] for group in sorted(chosen) if chosen[group] not in (None, "none", [])}


def _changed_keys(composed: Composed) -> Iterator[tuple[str, Any]]:
    """Yields the keys of the configuration that differ from the defaults, with their values; interpolations
    stay as they are written."""
    plan = composed.plan
    changed = plan.model_dump(mode="json", by_alias=True, exclude_defaults=True)
    written, computed = as_written(composed.config), sorted(composed.computed, key=str)
    for place, value in _changed_places(plan.tree(), changed, computed):
        # The written tree lacks what validation added, or has another structure there.
        with suppress(KeyError, IndexError, TypeError):
            value = _with_interpolations(value, place, written, computed)
        yield key_of(place), value


def _changed_places(
    tree: Any, changed: Any, computed: list[Place], place: Place = ()
) -> Iterator[tuple[Place, Any]]:
    """Yields (place, value) of the leaves of `tree` that differ from the default, so that they are in
    `changed`, or that are computed, even if they equal the default; `ALWAYS_WRITTEN` in any case."""
    for name, value in tree.items():
        inner_place = (*place, name)
        is_changed = isinstance(changed, Mapping) and name in changed
        is_computed = any(computed_place[: len(inner_place)] == inner_place for computed_place in computed)
        changed_below = changed[name] if is_changed else {}
        if isinstance(value, Mapping) and value and inner_place not in computed:
            if is_changed or is_computed:
                yield from _changed_places(value, changed_below, computed, inner_place)
        elif is_changed or is_computed or inner_place == ALWAYS_WRITTEN:
            yield inner_place, value


def _with_interpolations(value: Any, place: Place, written: Any, computed: list[Place]) -> Any:
    """Returns a value with its interpolations as they are written."""
    written_value = functools.reduce(operator.getitem, place, written)
    if place in computed:
        return written_value
    for computed_place in computed:
        if computed_place[: len(place)] == place:
            value = _with_written_part(value, computed_place[len(place) :], written_value)
    return value


def _with_written_part(value: Any, place: Place, written: Any) -> Any:
    """Returns a value in which the part at a place is replaced by the written text."""
    if not place:
        return written
    changed: Any = list(value) if isinstance(value, list) else dict(value)
    changed[place[0]] = _with_written_part(value[place[0]], place[1:], written[place[0]])
    return changed


def _on_one_line(value: Any) -> str:
    """Returns a value as JSON in a line; a text without quotes if it cannot be taken for JSON."""
    if isinstance(value, str) and value and value.isprintable() and value == value.strip():
        try:
            json.loads(value)
        except ValueError:
            return value
    line = json.dumps(value, ensure_ascii=False)
    return line if line.isprintable() else json.dumps(value)


def _read_text(line: str) -> str:
    """Returns the text that `_on_one_line` wrote as a line."""
    try:
        return str(json.loads(line))
    except ValueError:
        return line
