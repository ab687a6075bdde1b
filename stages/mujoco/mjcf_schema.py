"""Defines which elements and attributes of MJCF a version of MuJoCo accepts, by the schema that it prints."""

import functools
import re
from collections.abc import Collection, Mapping

import mujoco

Allowed = tuple[frozenset[str] | None, frozenset[str] | None]
"""(attributes, tags of children) that an element may have; None means any."""

_ELEMENT_LINE = re.compile(r"( *)(\S+) \(.\) *(.*)")
"""A line of the printed schema that begins an element: indentation, tag and attributes."""

_POSE_ATTRIBUTES = frozenset(["pos", "quat", "axisangle", "xyaxes", "zaxis", "euler"])

_COMMON_CHILDREN = frozenset({"include"})
"""Children that every element may have."""

_LISTED_TAGS = {"worldbody": "body", "frame": "body", "replicate": "body"}
"""Tag → the tag under which the schema lists the children of the element."""

_CHILDREN_OF_BODIES = frozenset(["body", "frame", "replicate", "composite"])
"""Children of a body that the schema does not list, or implies by repetition."""

_UNLISTED_ATTRIBUTES: dict[str, frozenset[str] | None] = {
    "worldbody": None,
    "frame": _POSE_ATTRIBUTES | {"name", "childclass", "scale"},
    "replicate": _POSE_ATTRIBUTES | {"count", "sep", "offset", "childclass", "name"},
    "composite": None,
}
"""Tag → attributes of elements that the schema does not list; None means any."""

TagPath = tuple[str, ...]
"""The tags from the root to an element."""


class MjcfSchema:
    """The elements and attributes that a version of MuJoCo accepts."""

    def __init__(self, listed: Mapping[TagPath, Collection[str]]) -> None:
        """`listed`: path of an element below the root → its attributes, as `listed()` returns them."""
        children: dict[TagPath, set[str]] = {}
        for path in listed:
            if path:
                children.setdefault(path[:-1], set()).add(path[-1])
        children[()] = (children[()] - {"body"}) | {"worldbody"}
        children["body",] |= _CHILDREN_OF_BODIES
        children["default",] |= {"default"}
        self._by_path: dict[TagPath, Allowed] = {
            path: (frozenset(attributes), frozenset(children.get(path, ())) | _COMMON_CHILDREN)
            for path, attributes in listed.items()
        }

    def allowed(self, path: TagPath) -> Allowed:
        """Returns the attributes and children that an element may have; (None, None) for an unknown element.
        `path`: the tags from the root to the element."""
        if "composite" in path[:-1] or "include" in path:
            return None, None
        attributes, children = self._by_path.get(_without_repetition(path), (None, None))
        name = path[-1]
        if name in _UNLISTED_ATTRIBUTES:
            attributes = _UNLISTED_ATTRIBUTES[name]
        if attributes is not None and len(path) > 1 and path[1] == "worldbody":
            attributes = attributes | _extra_attributes(name)
        return attributes, children


def allowed(path: TagPath) -> Allowed:
    """Returns the attributes and children that the installed MuJoCo accepts in an element. `path`: the tags
    from the root to the element."""
    return installed().allowed(path)


@functools.cache
def installed() -> MjcfSchema:
    """Returns the schema of the installed MuJoCo."""
    return MjcfSchema(listed())


def _extra_attributes(tag: str) -> frozenset[str]:
    """Returns the attributes of an element in the world's body that MuJoCo reads, but does not list."""
    return frozenset({"childclass"}) if tag in ("body", "frame") else frozenset()


def _without_repetition(path: TagPath) -> TagPath:
    """Returns the path below the root under which the schema lists an element: nested bodies count once, and
    so do nested defaults."""
    listed_path: list[str] = []
    for tag in path[1:]:
        name = _LISTED_TAGS.get(tag, tag)
        if not (listed_path and name == listed_path[-1] and name in ("body", "default")):
            listed_path.append(name)
    return tuple(listed_path)


def listed() -> dict[TagPath, set[str]]:
    """Returns the attributes of each element by its path below the root, from the text of
    `mj_printSchema`."""
    table: dict[TagPath, set[str]] = {}
    ancestors: list[str] = []
    path: TagPath = ()
    for line in mujoco.mj_printSchema(False, True).splitlines():
        match = _ELEMENT_LINE.match(line)
        if match:
            level = len(match[1]) // 3
            name = {"(world)body": "body", "mujoco": ""}.get(match[2], match[2])
            ancestors[level:] = [name]
            path = tuple(ancestors[1:])
            table.setdefault(path, set()).update(match[3].split())
        # Other lines continue the attributes of the last element.
        elif line.strip():
            table[path].update(line.split())
    return table
