"""Names of mesh files: one scheme, no two alike on any file system."""

from collections.abc import Mapping


def file_names(pieces: Mapping[str, tuple[int, bool]]) -> dict[str, tuple[list[str], str]]:
    """For each link, in order: the names of its visual files and of its collision file.

    `pieces`: for each link, how many visual files it has and whether it has a collider. A link's
    files are `<link>.stl`, or `<link>_<k>.stl` with k from 1 for several, and `<link>_collision.stl`.
    Where that is another link's file (links `arm` and `arm_1`), the underscore is doubled until it
    is not. Names that differ in case alone count as alike.
    """
    stems = {link.casefold() for link in pieces}
    taken: set[str] = set()
    names = {}
    for link, (count, collides) in pieces.items():
        width = len(str(count))
        suffixes = [f"{k:0{width}d}" for k in range(1, count + 1)] if count > 1 else []
        suffixes += ["collision"] if collides else []
        gap = "_"
        while any(_key(link, gap, suffix) in stems | taken for suffix in suffixes):
            gap += "_"
        taken |= {_key(link, gap, suffix) for suffix in suffixes}
        several = [f"{link}{gap}{suffix}.stl" for suffix in suffixes]
        collision = several.pop() if collides else ""
        names[link] = (several if count > 1 else [f"{link}.stl"] * count, collision)
    return names


def _key(link: str, gap: str, suffix: str) -> str:
    return f"{link}{gap}{suffix}".casefold()
