"""Names: from what a designer typed to what every simulator accepts."""

import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence

RESERVED = frozenset({"world"})

SPELLED = str.maketrans(
    {"ß": "ss", "æ": "ae", "Æ": "AE", "œ": "oe", "Œ": "OE", "ø": "o", "Ø": "O", "ł": "l", "Ł": "L"}
)
"""Letters that do not fall apart into a plain one and an accent."""

LONGEST = 80
"""So many letters of a word are kept: names name files, whose own names may have 255."""


def legal(text: str) -> str:
    """`text` in [A-Za-z0-9_], lower case, words joined by "_", cut short; "" where nothing is left.

    The instance suffix " <1>" goes; " <3>" stays as "_3", so that adding a second instance never
    renames the first.
    """
    text, suffix = _instance(text)
    plain = unicodedata.normalize("NFKD", text.translate(SPELLED)).encode("ascii", "ignore").decode()
    plain = re.sub(r"[^A-Za-z0-9]+", "_", plain).strip("_").lower()[:LONGEST].rstrip("_")
    return plain + suffix if plain else ""


def plain(text: str) -> str:
    """`text` in [A-Za-z0-9_], as near to it as can be: unchanged where it is so already."""
    if re.fullmatch("[A-Za-z0-9_]+", text):
        return text
    bare = unicodedata.normalize("NFKD", text.translate(SPELLED)).encode("ascii", "ignore").decode()
    return re.sub(r"[^A-Za-z0-9]+", "_", bare).strip("_") or "unnamed"


def legal_or_unnamed(text: str) -> str:
    """The legal name, or "unnamed" with the instance's number where no letter of it is legal."""
    return legal(text) or "unnamed" + _instance(text)[1]


def _instance(text: str) -> tuple[str, str]:
    """A name without its instance suffix, and what stands for that: "" for <1>, "_3" for <3>."""
    match = re.fullmatch(r"(.*?)\s*<(\d+)>\s*", text, flags=re.DOTALL)
    if not match:
        return text, ""
    count = int(match.group(2))
    return match.group(1), f"_{count}" if count > 1 else ""


def shortest_unique(paths: Mapping[str, Sequence[str]], taken: Iterable[str] = ()) -> dict[str, str]:
    """A unique legal name for each key, from the shortest tail of its path that no other shares.

    `paths`: key → words from the outermost to the innermost ("leg <2>", "foot <1>"). Names in
    `taken` and reserved ones are avoided. What is still alike after the whole path gets "_2",
    "_3" in the order of the paths, then of the keys, so the order of the mapping never matters.
    """
    taken = set(taken) | RESERVED
    words = {key: [legal_or_unnamed(word) for word in path] for key, path in paths.items()}
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
            names[key] = free(tail, taken)
            taken.add(names[key])
    return names


def free(name: str, taken: set[str]) -> str:
    """`name`, or with the first of _2, _3, ... that is not taken; of very many some that is not."""
    if name not in taken:
        return name
    for count in range(2, _NEAR):
        if f"{name}_{count}" not in taken:
            return f"{name}_{count}"
    # Without gaps this is the first, too, and it takes log n steps where one by one takes n.
    low, high = _NEAR - 1, 2 * _NEAR
    while f"{name}_{high}" in taken:
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if f"{name}_{middle}" in taken else (low, middle)
    return f"{name}_{high}"


_NEAR = 100
"""Counts that are tried one by one."""
