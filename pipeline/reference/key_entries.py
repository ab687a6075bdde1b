"""Reads the keys of the configuration and their documentation from `keys.json`."""

import difflib
import functools
import json
from collections.abc import Iterable
from dataclasses import dataclass

from linkwright.pipeline.reference import DATA


@dataclass(frozen=True, slots=True)
class KeyEntry:
    """A key or a section of the configuration."""

    key: str
    """The full key, with `<name>` or `<glob>` for a part that may be any name."""

    source: str
    """The kind of source that the key belongs to; "" for all."""

    type: str
    unit: str
    default: str
    allowed: str
    words: tuple[str, ...]
    """The values of a key that is a choice."""

    meaning: str
    example: str
    later: bool
    """Whether the key is decided, but not supported yet."""

    @property
    def names(self) -> list[str]:
        """The parts of the key."""
        return self.key.split(".")

    @property
    def is_section(self) -> bool:
        return self.type.startswith("section")


@functools.cache
def entries() -> tuple[KeyEntry, ...]:
    """Returns all keys and sections in the order of the configuration."""
    rows = json.loads(DATA.read_text(encoding="utf-8"))
    return tuple(KeyEntry(**{**row, "words": tuple(row["words"])}) for row in rows)


def is_placeholder(name: str) -> bool:
    """Tells whether a part of a key is a placeholder for any name."""
    return name.startswith("<")


def matching(key: str, among: Iterable[KeyEntry]) -> list[KeyEntry]:
    """Returns the entries for a key as a user types it, such as `joints.elbow.damping`."""
    parts = key.split(".")
    return [
        entry
        for entry in among
        if len(entry.names) == len(parts)
        and all(is_placeholder(name) or name == part for name, part in zip(entry.names, parts))
    ]


def nearest(text: str, candidates: Iterable[str], limit: int = 3) -> list[str]:
    """Returns the candidates whose spelling is similar to `text`, the most similar first."""
    return difflib.get_close_matches(text, sorted(set(candidates)), n=limit, cutoff=0.6)
