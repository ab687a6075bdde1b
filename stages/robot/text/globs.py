"""Matches globs that users write, and lists names in messages."""

import json
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from difflib import get_close_matches
from fnmatch import fnmatchcase

_MAX_LISTED_NAMES = 20
"""Largest number of names that a message lists."""

_YAML_WORDS = frozenset({"true", "false", "null", "yes", "no", "on", "off"})
"""Words that YAML does not read as text."""


def without_number(name: str) -> str:
    """Returns the name of an instance without its number: "Foot <2>" → "Foot"."""
    return re.sub(r"\s*<\d+>\s*\Z", "", name)


def with_plain_titles(titles: Collection[str]) -> set[str]:
    """Returns the titles of instances, and the same titles without their numbers."""
    return {*titles, *(without_number(title) for title in titles)}


def exact_glob(name: str) -> str:
    """Returns the glob that matches only this name."""
    return re.sub(r"([*?[])", r"[\1]", name)


def matches_glob(name: str, glob: str) -> bool:
    """Tells whether a glob is equal to a name, or matches it as a pattern."""
    return name == glob or fnmatchcase(name, glob)


def did_you_mean(name: str, names: Iterable[str], max_names: int = 1) -> str:
    """Returns a question with the names that are similar to `name`, the most similar first; "" if no name
    is similar."""
    matches = get_close_matches(name, list(names), max_names)
    return f"did you mean {' or '.join(matches)}?" if matches else ""


def no_match_hint(glob: str, names_by_kind: Mapping[str, Iterable[str]]) -> str:
    """Returns the hint for a glob that matches nothing: the most similar name, and all names by kind, such as
    "did you mean arm? links are: arm, base"."""
    # Lists, since iterators give their names only once.
    lists = {kind: list(names) for kind, names in names_by_kind.items()}
    question = did_you_mean(glob, [name for names in lists.values() for name in names])
    all_names = "; ".join(f"{kind} are: {name_list(names) or 'none'}" for kind, names in lists.items())
    return f"{question} {all_names}".lstrip()


def yaml_key(name: str) -> str:
    """Returns a YAML key that, as a glob, matches only this name; it is in quotes if YAML needs them."""
    glob = exact_glob(name)
    is_plain = re.fullmatch(r"[A-Za-z_][\w.-]*", glob, re.ASCII) and glob.lower() not in _YAML_WORDS
    return glob if is_plain else json.dumps(glob, ensure_ascii=False)


def name_list(names: Iterable[str]) -> str:
    """Returns the names for a message, sorted and without duplicates. After 20 names, it only counts the
    others."""
    sorted_names = sorted(set(names))
    other_count = len(sorted_names) - _MAX_LISTED_NAMES
    remainder = f" and {other_count} more" if other_count > 0 else ""
    return ", ".join(sorted_names[:_MAX_LISTED_NAMES]) + remainder


def matching_indices(glob: str, name_sets: Sequence[Collection[str]]) -> list[int]:
    """Returns the indices of the objects that a glob selects. `name_sets`: the names of each object.

    These are the objects with a name equal to the glob, or, without any, those with a name that matches it.
    """
    equal = [index for index, names in enumerate(name_sets) if glob in names]
    return equal or [
        index for index, names in enumerate(name_sets) if any(fnmatchcase(name, glob) for name in names)
    ]
