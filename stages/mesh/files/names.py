"""Names of mesh files: one scheme, unique on every file system."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from linkwright.stages.robot.text.names import plain, shortest_unique

_LONGEST = 200
"""Letters of a link's name in that of a file, which may have 255."""


def file_names(
    files: Mapping[str, tuple[int | Sequence[str], int]],
) -> dict[str, tuple[list[str], list[str]]]:
    """For each link, in order: the names of its visual files and of its collision files.

    `files`: for each link, the number of its visual files, or a word for each, and that of its collision
    files. With words they are named `<link>_<word>.stl`, else `<link>.stl`, or
    `<link>_<k>.stl` with k from 1 for several, and `<link>_collision.stl`, or `<link>_collision_<k>.stl`.
    Where another link has a file of that name (links `arm` and `arm_1`), underscores are added until none
    has. Names that differ only in case count as the same. Letters that some file systems lack are left out,
    and long names are shortened.
    """
    stem_of = _stems(files)
    stems = {stem.casefold() for stem in stem_of.values()}
    taken: set[str] = set()
    names = {}
    for link, (visuals, colliders) in files.items():
        stem = stem_of[link]
        words = _numbered("", visuals) if isinstance(visuals, int) else list(visuals)
        suffixes = words + _numbered("collision", colliders)
        gap = "_"
        while any(_key(stem, gap, suffix) in stems | taken for suffix in suffixes if suffix):
            gap += "_"
        taken |= {_key(stem, gap, suffix) for suffix in suffixes if suffix}
        own = [f"{stem}{gap}{suffix}.stl" if suffix else f"{stem}.stl" for suffix in suffixes]
        names[link] = (own[: len(words)], own[len(words) :])
    return names


def part_words(names: Sequence[str]) -> list[str]:
    """A word for each visual file of a link by the name of its part, unique within the link: the shortest end
    of the name that no other part has, and a number where a part has several files."""
    counts = Counter(names)
    paths = {name: name.split("/") for name in counts}
    # Colliders have the word "collision".
    short = {
        name: f"part_{word}" if word.startswith("collision") else word
        for name, word in shortest_unique(paths).items()
    }
    numbers: Counter[str] = Counter()
    words = []
    for name in names:
        numbers[name] += 1
        words.append(short[name] if counts[name] == 1 else f"{short[name]}__{numbers[name]}")
    return words


def _numbered(word: str, count: int) -> list[str]:
    """The endings of the names of `count` files of one kind: the word, with numbers if there are several."""
    if count < 2:
        return [word] * count
    width = len(str(count))
    return [f"{word}_{k:0{width}d}".lstrip("_") for k in range(1, count + 1)]


def _stems(links: Iterable[str]) -> dict[str, str]:
    """The stem of each link's file names: its name where that can name files, else the nearest name that no
    other link has."""
    stems: dict[str, str] = {}
    taken: set[str] = set()
    for link in sorted(links, key=lambda name: (_stem(name) != name, name)):
        stem, count = _stem(link), 1
        while stem.casefold() in taken:
            count += 1
            stem = f"{_stem(link)}_{count}"
        stems[link] = stem
        taken.add(stem.casefold())
    return stems


def _stem(link: str) -> str:
    return plain(link)[:_LONGEST]


def _key(link: str, gap: str, suffix: str) -> str:
    return f"{link}{gap}{suffix}".casefold()
