"""Names of mesh files: one scheme, no two alike on any file system."""

from collections.abc import Iterable, Mapping

from stages.robot.names import plain

_LONGEST = 200
"""Letters of a link's name in that of a file, which may have 255."""


def file_names(pieces: Mapping[str, tuple[int, bool]]) -> dict[str, tuple[list[str], str]]:
    """For each link, in order: the names of its visual files and of its collision file.

    `pieces`: for each link, how many visual files it has and whether it has a collider. A link's
    files are `<link>.stl`, or `<link>_<k>.stl` with k from 1 for several, and `<link>_collision.stl`.
    Where that is another link's file (links `arm` and `arm_1`), the underscore is doubled until it
    is not. Names that differ in case alone count as alike. Letters that not every file system has are
    left out of a link's name, and so is what makes it very long.
    """
    stem_of = _stems(pieces)
    stems = {stem.casefold() for stem in stem_of.values()}
    taken: set[str] = set()
    names = {}
    for link, (count, collides) in pieces.items():
        stem = stem_of[link]
        width = len(str(count))
        suffixes = [f"{k:0{width}d}" for k in range(1, count + 1)] if count > 1 else []
        suffixes += ["collision"] if collides else []
        gap = "_"
        while any(_key(stem, gap, suffix) in stems | taken for suffix in suffixes):
            gap += "_"
        taken |= {_key(stem, gap, suffix) for suffix in suffixes}
        several = [f"{stem}{gap}{suffix}.stl" for suffix in suffixes]
        collision = several.pop() if collides else ""
        names[link] = (several if count > 1 else [f"{stem}.stl"] * count, collision)
    return names


def _stems(links: Iterable[str]) -> dict[str, str]:
    """What each link's files are called after: its name where that can name files, else the nearest to it
    that no other link has."""
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
