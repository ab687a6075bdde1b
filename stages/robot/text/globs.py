"""Globs that users give, and names in messages."""

import json
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from difflib import get_close_matches
from fnmatch import fnmatchcase

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


def did_you_mean(name: str, known: Iterable[str], most: int = 1) -> str:
    """A question with the nearest of the known names, the nearest first; "" where none is near."""
    near = get_close_matches(name, list(known), most)
    return f"did you mean {' or '.join(near)}?" if near else ""


def there_are(asked: str, known: Mapping[str, Iterable[str]]) -> str:
    """What a message says of a glob that nothing matches: the nearest name, and what there is, by kind."""
    names = {kind: list(every) for kind, every in known.items()}
    near = did_you_mean(asked, [name for every in names.values() for name in every])
    there = "; ".join(f"{kind} are: {listed(every) or 'none'}" for kind, every in names.items())
    return f"{near} {there}".lstrip()


def as_key(name: str) -> str:
    """The YAML key whose glob matches only this name."""
    glob = escaped(name)
    plain = re.fullmatch(r"[A-Za-z_][\w.-]*", glob, re.ASCII) and glob.lower() not in _YAML_WORDS
    return glob if plain else json.dumps(glob, ensure_ascii=False)


_YAML_WORDS = frozenset({"true", "false", "null", "yes", "no", "on", "off"})
"""Keys that YAML does not read as text."""


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
