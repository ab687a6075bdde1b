"""Names mesh files by a single scheme, with names that are unique on every file system."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from linkwright.stages.robot.text.names import plain, shortest_unique

_MAX_LINK_LETTERS = 200
"""Largest number of letters of a link's name in a file name, which may have 255 in all."""


class FileCounts(NamedTuple):
    """The numbers of mesh files of a link."""

    visuals: int | Sequence[str]
    """Number of visual files, or a word for each if each belongs to one part."""
    colliders: int
    """Number of collision files."""


def file_names(
    counts: Mapping[str, FileCounts],
) -> dict[str, tuple[list[str], list[str]]]:
    """Returns the names of the visual files and of the collision files of each link, in order.

    `counts`: the numbers of files by link. Visual files are named `<link>_<word>.stl` if there are words,
    else `<link>.stl`, or `<link>_<k>.stl`, counted from 1, if there are several; collision files are named
    `<link>_collision.stl` or `<link>_collision_<k>.stl`. If another link has a file of the same name (links
    `arm` and `arm_1`), underscores are added until the name is unique. Case is ignored when names are
    compared. Letters that some file systems lack are left out, and long names are shortened.
    """
    stem_of = stems(counts)
    folded_stems = {stem.casefold() for stem in stem_of.values()}
    names_in_use: set[str] = set()
    names = {}
    for link, (visuals, colliders) in counts.items():
        stem = stem_of[link]
        words = _numbered("", visuals) if isinstance(visuals, int) else list(visuals)
        suffixes = words + _numbered("collision", colliders)
        separator = "_"
        while any(
            _folded_name(stem, separator, suffix) in folded_stems | names_in_use
            for suffix in suffixes
            if suffix
        ):
            separator += "_"
        names_in_use |= {_folded_name(stem, separator, suffix) for suffix in suffixes if suffix}
        names_of_link = [f"{stem}{separator}{suffix}.stl" if suffix else f"{stem}.stl" for suffix in suffixes]
        names[link] = (names_of_link[: len(words)], names_of_link[len(words) :])
    return names


def part_words(names: Sequence[str]) -> list[str]:
    """Returns a short word for each visual file of a link, unique within the link. It is the shortest ending
    of its part's name that no other part shares, with a number if the part has several files."""
    counts = Counter(names)
    paths = {name: name.split("/") for name in counts}
    # A part called "collision" must not look like a collider's file.
    short_name = {
        name: f"part_{word}" if word.startswith("collision") else word
        for name, word in shortest_unique(paths).items()
    }
    numbers: Counter[str] = Counter()
    words = []
    for name in names:
        numbers[name] += 1
        words.append(short_name[name] if counts[name] == 1 else f"{short_name[name]}__{numbers[name]}")
    return words


def _numbered(word: str, count: int) -> list[str]:
    """Returns the name endings of `count` files of a kind: the word, with numbers if there are several."""
    if count < 2:
        return [word] * count
    width = len(str(count))
    return [f"{word}_{k:0{width}d}".lstrip("_") for k in range(1, count + 1)]


def stems(links: Iterable[str]) -> dict[str, str]:
    """Maps each link to the stem of its file names: its own name if that is a valid file name, else a similar
    name that no other link has."""
    stem_of: dict[str, str] = {}
    stems_in_use: set[str] = set()
    for link in sorted(links, key=lambda name: (_stem(name) != name, name)):
        stem, count = _stem(link), 1
        while stem.casefold() in stems_in_use:
            count += 1
            stem = f"{_stem(link)}_{count}"
        stem_of[link] = stem
        stems_in_use.add(stem.casefold())
    return stem_of


def _stem(link: str) -> str:
    return plain(link)[:_MAX_LINK_LETTERS]


def _folded_name(link: str, separator: str, suffix: str) -> str:
    return f"{link}{separator}{suffix}".casefold()
