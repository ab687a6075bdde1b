"""The keys of the configuration, as the schema documents them: read from `keys.json`."""

import difflib
import functools
import json
from collections.abc import Iterable
from dataclasses import dataclass

from linkwright.pipeline.reference import DATA


@dataclass(frozen=True, slots=True)
class KeyEntry:
    """A key or a section of the configuration.

    `key` has `<name>` or `<glob>` where any name may stand. `source`: the kind of source that the key
    belongs to, "" for all. `words`: the values of a key that is a choice. `later`: decided, but not
    supported yet.
    """

    key: str
    source: str
    type: str
    unit: str
    default: str
    allowed: str
    words: tuple[str, ...]
    meaning: str
    example: str
    later: bool

    @property
    def names(self) -> list[str]:
        """The parts of the key."""
        return self.key.split(".")

    @property
    def is_section(self) -> bool:
        return self.type.startswith("section")


@functools.cache
def entries() -> tuple[KeyEntry, ...]:
    """Every key and section, in the order of the configuration."""
    rows = json.loads(DATA.read_text(encoding="utf-8"))
    return tuple(KeyEntry(**{**row, "words": tuple(row["words"])}) for row in rows)


def is_any(name: str) -> bool:
    """Whether a part of a key stands for any name."""
    return name.startswith("<")


def matching(key: str, among: Iterable[KeyEntry]) -> list[KeyEntry]:
    """The entries for a key as a user types it, such as `joints.elbow.damping`."""
    typed = key.split(".")
    return [
        entry
        for entry in among
        if len(entry.names) == len(typed)
        and all(is_any(name) or name == part for name, part in zip(entry.names, typed))
    ]


def nearest(text: str, candidates: Iterable[str], limit: int = 3) -> list[str]:
    """The candidates that are spelled much like `text`, the nearest first."""
    return difflib.get_close_matches(text, sorted(set(candidates)), n=limit, cutoff=0.6)
