"""Matches globs that users give, and lists names in messages."""

import json
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from difflib import get_close_matches
from fnmatch import fnmatchcase

_MAX_LISTED = 20


def unnumbered(name: str) -> str:
    """Returns the name of an instance without its number: "Foot <2>" → "Foot"."""
    return re.sub(r"\s*<\d+>\s*\Z", "", name)


def with_plain(titles: Collection[str]) -> set[str]:
    """Returns titles of instances, and the same titles without their numbers."""
    return {*titles, *(unnumbered(title) for title in titles)}


def escaped(name: str) -> str:
    """Returns the glob that matches only this name."""
    return re.sub(r"([*?[])", r"[\1]", name)


def fits(name: str, glob: str) -> bool:
    """Returns whether a glob matches this name: literally, or as a pattern."""
    return name == glob or fnmatchcase(name, glob)


def did_you_mean(name: str, names: Iterable[str], max_names: int = 1) -> str:
    """Returns a question with the names near `name`, the nearest first; "" where none is near."""
    matches = get_close_matches(name, list(names), max_names)
    return f"did you mean {' or '.join(matches)}?" if matches else ""


def there_are(glob: str, names_by_kind: Mapping[str, Iterable[str]]) -> str:
    """Returns the hint for a glob that matches nothing: the nearest name, and all names by kind."""
    names = {kind: list(texts) for kind, texts in names_by_kind.items()}
    suggestion = did_you_mean(glob, [name for texts in names.values() for name in texts])
    lists = "; ".join(f"{kind} are: {listed(texts) or 'none'}" for kind, texts in names.items())
    return f"{suggestion} {lists}".lstrip()


def as_key(name: str) -> str:
    """Returns the YAML key whose glob matches only this name."""
    glob = escaped(name)
    plain = re.fullmatch(r"[A-Za-z_][\w.-]*", glob, re.ASCII) and glob.lower() not in _YAML_WORDS
    return glob if plain else json.dumps(glob, ensure_ascii=False)


_YAML_WORDS = frozenset({"true", "false", "null", "yes", "no", "on", "off"})
"""Keys that YAML does not read as text."""


def listed(names: Iterable[str]) -> str:
    """Returns the names as a sorted list for a message, without duplicates; a very long list is cut."""
    sorted_names = sorted(set(names))
    remainder = f" and {len(sorted_names) - _MAX_LISTED} more" if len(sorted_names) > _MAX_LISTED else ""
    return ", ".join(sorted_names[:_MAX_LISTED]) + remainder


def matching(glob: str, things: Sequence[Collection[str]]) -> list[int]:
    """Returns the indices of the things with a name equal to `glob`, else of those whose name matches it."""
    exact = [index for index, names in enumerate(things) if glob in names]
    return exact or [
        index for index, names in enumerate(things) if any(fnmatchcase(name, glob) for name in names)
    ]
