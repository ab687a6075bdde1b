"""Lists the differences of two snapshots, key by key."""

from collections.abc import Iterator

from linkwright.pipeline.snapshots.text import CONFIGURATION, FIGURES, Entries, read_entries
from linkwright.stages.robot.text.plural import count

_NOUNS = {CONFIGURATION: "key", FIGURES: "figure"}
_ABSENT_VALUES = {CONFIGURATION: "(default)"}


def differences(old: str, new: str) -> list[str]:
    """Returns lines about the differences of two snapshots' texts; [] if they are equal."""
    before, after = read_entries(old), read_entries(new)
    if before is None or after is None:
        return ["it is a snapshot of another format"]
    lines: list[str] = []
    for section in dict.fromkeys(section for section, _ in (*before, *after)):
        changed = [*_changed_lines(before, after, section)]
        if changed:
            noun = _NOUNS.get(section, "choice")
            lines += [f"{count(len(changed), noun)} changed:", *(f"  {line}" for line in changed)]
    if not lines and [*before.items()] != [*after.items()]:
        moved_key = next(new[1] for old, new in zip(before, after, strict=True) if old != new)
        return [f"the order of its keys changed, from {moved_key} on: where globs match, the later one wins"]
    return lines


def _changed_lines(before: Entries, after: Entries, section: str) -> Iterator[str]:
    default_value = _ABSENT_VALUES.get(section, "(none)")
    for entry in dict.fromkeys([*after, *before]):
        old, new = before.get(entry, default_value), after.get(entry, default_value)
        if entry[0] == section and old != new:
            yield f"{entry[1]}: {old} → {new}"
