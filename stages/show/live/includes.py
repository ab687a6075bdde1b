"""A scene as one document: its includes resolved, and a name for every body and geom."""

from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from linkwright.stages.formats.xml import Element, parse, tag
from linkwright.stages.mujoco.includes import resolve

OWN = "linkwright:"
"""How the names begin that are given here to what has none."""

_COPIED = frozenset({"replicate", "composite", "flexcomp", "default"})
"""Elements whose content MuJoCo copies, each copy with a name of its own, or that make nothing themselves."""

_MOST_FILES = 100


def flat(folder: Path, name: str) -> Element:
    """The root of a scene's file with the content of all that it includes, in its place. ValueError for a
    file outside of the folder, or for includes that never end."""
    read = 0

    def root_of(name: str) -> Element:
        nonlocal read
        path, read = PurePosixPath(name), read + 1
        if path.is_absolute() or ".." in path.parts or read > _MOST_FILES:
            raise ValueError(f"{name} is included from outside of the build, or in a circle")
        return parse((folder / path).read_bytes(), large=True)

    root = root_of(name)
    resolve(root, lambda include: root_of(include.get("file", "")))
    return root


def with_names(root: Element) -> Element:
    """Names each body and geom that has no name, in place, so that they are found in the compiled model."""
    for number, node in enumerate(_in_bodies(root)):
        if node.get("name") is None:
            node.set("name", f"{OWN}{number}")
    return root


def _in_bodies(root: Element) -> Iterator[Element]:
    """The bodies and geoms of the document, in its order, but not what MuJoCo makes copies of."""
    waiting = [root]
    while waiting:
        node = waiting.pop()
        if tag(node) in ("body", "geom"):
            yield node
        if tag(node) not in _COPIED:
            waiting.extend(reversed(list(node)))


def actuator_tags(root: Element) -> tuple[str, ...]:
    """The tag of each actuator, in the order of the compiled model."""
    return tuple(tag(one) for section in root.iterchildren("actuator") for one in section)
