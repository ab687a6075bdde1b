"""Reads a scene as a single document without includes, in which every body and geom has a name."""

from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from linkwright.stages.formats.xml import Element, parse, tag
from linkwright.stages.mujoco.includes import replace_includes

NAME_PREFIX = "linkwright:"
"""Prefix of generated names."""

_COPIED = frozenset({"replicate", "composite", "flexcomp", "default"})
"""Elements whose content MuJoCo copies under other names, or that create nothing themselves."""

_MAX_FILES = 100
"""Largest number of files of a scene; more mean a circle of includes."""


def without_includes(folder: Path, name: str) -> Element:
    """Returns the root of a scene's file, with all includes replaced by their content. Raises ValueError if a
    file is outside of the folder, or if includes form a circle."""
    file_count = 0

    def root_of(name: str) -> Element:
        nonlocal file_count
        path, file_count = PurePosixPath(name), file_count + 1
        if path.is_absolute() or ".." in path.parts or file_count > _MAX_FILES:
            raise ValueError(f"{name} is included from outside of the build, or in a circle")
        return parse((folder / path).read_bytes(), large=True)

    root = root_of(name)
    replace_includes(root, lambda include: root_of(include.get("file", "")))
    return root


def with_names(root: Element) -> Element:
    """Gives a name to each body and geom without one, in place, so that they are found in the compiled
    model."""
    for number, node in enumerate(_in_bodies(root)):
        if node.get("name") is None:
            node.set("name", f"{NAME_PREFIX}{number}")
    return root


def _in_bodies(root: Element) -> Iterator[Element]:
    """Yields the bodies and geoms of the document, in its order, except those that MuJoCo copies."""
    stack = [root]
    while stack:
        node = stack.pop()
        if tag(node) in ("body", "geom"):
            yield node
        if tag(node) not in _COPIED:
            stack.extend(reversed(list(node)))


def actuator_tags(root: Element) -> tuple[str, ...]:
    """Returns the tag of each actuator, in the order of the compiled model."""
    return tuple(tag(actuator) for section in root.iterchildren("actuator") for actuator in section)
