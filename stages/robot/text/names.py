"""Turns names that designers type into names that every simulator accepts."""

import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence

RESERVED = frozenset({"world"})

SPELLED = str.maketrans(
    {"ß": "ss", "æ": "ae", "Æ": "AE", "œ": "oe", "Œ": "OE", "ø": "o", "Ø": "O", "ł": "l", "Ł": "L"}
)
"""Letters that do not decompose into a plain letter and an accent."""

MAX_LETTERS = 80
"""Largest number of letters of a name: files are named by it, and their names may have 255."""


def legal_name(text: str) -> str:
    """Returns `text` in [A-Za-z0-9_], lower case, words joined by "_", cut short; "" where nothing is left.

    The instance suffix " <1>" goes; " <3>" stays as "_3", so that adding a second instance never
    renames the first.
    """
    text, suffix = _instance(text)
    plain = unicodedata.normalize("NFKD", text.translate(SPELLED)).encode("ascii", "ignore").decode()
    plain = re.sub(r"[^A-Za-z0-9]+", "_", plain).strip("_").lower()[:MAX_LETTERS].rstrip("_")
    return plain + suffix if plain else ""


def plain(text: str) -> str:
    """Returns `text` in [A-Za-z0-9_], changed as little as possible."""
    if re.fullmatch("[A-Za-z0-9_]+", text):
        return text
    bare = unicodedata.normalize("NFKD", text.translate(SPELLED)).encode("ascii", "ignore").decode()
    return re.sub(r"[^A-Za-z0-9]+", "_", bare).strip("_") or "unnamed"


def legal_name_or_unnamed(text: str) -> str:
    """Returns the legal name, or "unnamed" with the instance's number where no letter of it is legal."""
    return legal_name(text) or "unnamed" + _instance(text)[1]


def _instance(text: str) -> tuple[str, str]:
    """Returns a name without its instance suffix, and the replacement of that: "" for <1>, "_3" for <3>."""
    match = re.fullmatch(r"(.*?)\s*<(\d+)>\s*", text, flags=re.DOTALL)
    if not match:
        return text, ""
    count = int(match.group(2))
    return match.group(1), f"_{count}" if count > 1 else ""


def shortest_unique(paths: Mapping[str, Sequence[str]], taken_names: Iterable[str] = ()) -> dict[str, str]:
    """Returns a unique legal name for each key, from the shortest tail of its path that no other path shares.

    `paths`: key → words from the outermost to the innermost ("leg <2>", "foot <1>"). Names in `taken_names`
    and reserved names are avoided. Names that are still alike after the whole path get "_2", "_3" in the
    order of the paths, then of the keys, so the order of the mapping never matters.
    """
    taken_names = set(taken_names) | RESERVED
    words = {key: [legal_name_or_unnamed(word) for word in path] for key, path in paths.items()}
    depth = dict.fromkeys(words, 1)
    while True:
        tails = {key: "_".join(words[key][-depth[key] :]) for key in words}
        owners: dict[str, list[str]] = {}
        for key, tail in tails.items():
            owners.setdefault(tail, []).append(key)
        crowded = [
            key
            for tail, keys in owners.items()
            if len(keys) > 1
            for key in keys
            if depth[key] < len(words[key])
        ]
        if not crowded:
            break
        for key in crowded:
            depth[key] += 1
    names: dict[str, str] = {}
    for tail in sorted(owners):
        for key in sorted(owners[tail], key=lambda key: (tuple(paths[key]), key)):
            names[key] = free_name(tail, taken_names)
            taken_names.add(names[key])
    return names


def free_name(name: str, taken_names: set[str]) -> str:
    """Returns `name` if it is free, else `name` with the first free suffix of _2, _3, ...; after many of
    them, with any free suffix."""
    if name not in taken_names:
        return name
    for count in range(2, _MAX_COUNTED):
        if f"{name}_{count}" not in taken_names:
            return f"{name}_{count}"
    # Without gaps this finds the first too, in log n steps in place of n.
    low, high = _MAX_COUNTED - 1, 2 * _MAX_COUNTED
    while f"{name}_{high}" in taken_names:
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if f"{name}_{middle}" in taken_names else (low, middle)
    return f"{name}_{high}"


_MAX_COUNTED = 100
"""Suffixes below this are tried one by one."""
