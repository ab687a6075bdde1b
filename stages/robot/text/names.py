"""Turns names that designers type into names that every simulator accepts."""

import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence

RESERVED = frozenset({"world"})
"""Names that simulators use themselves."""

SPELLED = str.maketrans(
    {"ß": "ss", "æ": "ae", "Æ": "AE", "œ": "oe", "Œ": "OE", "ø": "o", "Ø": "O", "ł": "l", "Ł": "L"}
)
"""Spelling of letters that do not decompose into a plain letter and an accent."""

MAX_LETTERS = 80
"""Largest number of letters of a legal name, without the number of its instance. Names of files, which may
have 255 letters, consist of a few of these."""

_MAX_COUNTED = 100
"""Suffix from which free suffixes are searched for by bisection."""


def legal_name(text: str) -> str:
    """Returns `text` in the letters a-z, 0-9 and _, with at most `MAX_LETTERS`; "" if no letter is left.

    The instance suffix " <1>" is left out, and " <3>" becomes "_3", so that a second instance does not rename
    the first.
    """
    text, suffix = _instance(text)
    letters = unicodedata.normalize("NFKD", text.translate(SPELLED)).encode("ascii", "ignore").decode()
    letters = re.sub(r"[^A-Za-z0-9]+", "_", letters).strip("_").lower()[:MAX_LETTERS].rstrip("_")
    return letters + suffix if letters else ""


def plain(text: str) -> str:
    """Returns `text` in the letters A-Z, a-z, 0-9 and _, changed as little as possible; "unnamed" if no
    letter is left."""
    if re.fullmatch("[A-Za-z0-9_]+", text):
        return text
    ascii_text = unicodedata.normalize("NFKD", text.translate(SPELLED)).encode("ascii", "ignore").decode()
    return re.sub(r"[^A-Za-z0-9]+", "_", ascii_text).strip("_") or "unnamed"


def legal_name_or_unnamed(text: str) -> str:
    """Returns the legal name; if no letter is left, "unnamed" with the suffix of the instance."""
    return legal_name(text) or "unnamed" + _instance(text)[1]


def _instance(text: str) -> tuple[str, str]:
    """Returns a name without its instance suffix, and the legal form of the suffix: "" for <1>, "_3" for
    <3>."""
    match = re.fullmatch(r"(.*?)\s*<(\d+)>\s*", text, flags=re.DOTALL)
    if not match:
        return text, ""
    count = int(match.group(2))
    return match.group(1), f"_{count}" if count > 1 else ""


def shortest_unique(paths: Mapping[str, Sequence[str]], taken_names: Iterable[str] = ()) -> dict[str, str]:
    """Returns a unique legal name for each key, from the shortest tail of its path that no other path shares.

    `paths`: key → words from the outermost to the innermost ("leg <2>", "foot <1>"). Names in `taken_names`
    and reserved names are avoided. Names that are equal even with the whole path get "_2", "_3" in the order
    of the paths, then of the keys, so that the order of the mapping does not matter.
    """
    taken_names = set(taken_names) | RESERVED
    words = {key: [legal_name_or_unnamed(word) for word in path] for key, path in paths.items()}
    depth = dict.fromkeys(words, 1)
    while True:
        tails = {key: "_".join(words[key][-depth[key] :]) for key in words}
        owners: dict[str, list[str]] = {}
        for key, tail in tails.items():
            owners.setdefault(tail, []).append(key)
        # Keys with the same tail take a further word of their path, if there is any.
        lengthened = [
            key for keys in owners.values() if len(keys) > 1 for key in keys if depth[key] < len(words[key])
        ]
        if not lengthened:
            break
        for key in lengthened:
            depth[key] += 1
    names: dict[str, str] = {}
    for tail in sorted(owners):
        for key in sorted(owners[tail], key=lambda key: (tuple(paths[key]), key)):
            names[key] = free_name(tail, taken_names)
            taken_names.add(names[key])
    return names


def free_name(name: str, taken_names: set[str]) -> str:
    """Returns `name` if it is not taken, else `name` with the first free suffix of _2, _3, ...; if all below
    `_MAX_COUNTED` are taken, with any free suffix."""
    if name not in taken_names:
        return name
    for count in range(2, _MAX_COUNTED):
        if f"{name}_{count}" not in taken_names:
            return f"{name}_{count}"
    # If the taken suffixes have no gaps, this finds the first free suffix too, in log n steps instead of n.
    low, high = _MAX_COUNTED - 1, 2 * _MAX_COUNTED
    while f"{name}_{high}" in taken_names:
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if f"{name}_{middle}" in taken_names else (low, middle)
    return f"{name}_{high}"


def common_stem(names: Sequence[str]) -> str:
    """Returns a single name itself; of several, the part before the last "_" that all share, or ""."""
    if len(names) == 1:
        return names[0]
    stems = {name.rpartition("_")[0] for name in names}
    return stems.pop() if len(stems) == 1 else ""
