"""Tells which elements and attributes of MJCF a version of MuJoCo accepts, by its own list."""

import functools
import re
from collections.abc import Collection, Mapping

import mujoco

Allowed = tuple[frozenset[str] | None, frozenset[str] | None]
"""(attributes, children) that an element may have; None means any."""

_LINE = re.compile(r"( *)(\S+) \(.\) *(.*)")

_FRAMES = frozenset(["pos", "quat", "axisangle", "xyaxes", "zaxis", "euler"])

_CHILDREN_OF_ALL = frozenset({"include"})
"""Elements that may be in every element."""

_STANDS_FOR = {"worldbody": "body", "frame": "body", "replicate": "body"}
"""Element → the element whose children it may contain."""

_CHILDREN_OF_BODIES = frozenset(["body", "frame", "replicate", "composite"])
"""Children of a body that MuJoCo's list leaves out, or includes only by repetition."""

_UNLISTED_ATTRIBUTES: dict[str, frozenset[str] | None] = {
    "worldbody": None,
    "frame": _FRAMES | {"name", "childclass", "scale"},
    "replicate": _FRAMES | {"count", "sep", "offset", "childclass", "name"},
    "composite": None,
}
"""Attributes of elements that MuJoCo's list leaves out; None means any."""


TagPath = tuple[str, ...]
"""The tags from the root to an element."""


class MjcfSchema:
    """The elements and attributes that a version of MuJoCo accepts. `listed`: the path of an element below
    the root → its attributes."""

    def __init__(self, listed: Mapping[TagPath, Collection[str]]) -> None:
        children: dict[TagPath, set[str]] = {}
        for path in listed:
            if path:
                children.setdefault(path[:-1], set()).add(path[-1])
        children[()] = (children[()] - {"body"}) | {"worldbody"}
        children["body",] |= _CHILDREN_OF_BODIES
        children["default",] |= {"default"}
        self._by_path: dict[TagPath, Allowed] = {
            path: (frozenset(attributes), frozenset(children.get(path, ())) | _CHILDREN_OF_ALL)
            for path, attributes in listed.items()
        }

    def allowed(self, path: TagPath) -> Allowed:
        """Returns the attributes and children that an element may have. `path`: the tags from the root to the
        element."""
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
    """Returns the attributes of an element in a body that MuJoCo reads, but does not list."""
    return frozenset({"childclass"}) if tag in ("body", "frame") else frozenset()


def _without_repetition(path: TagPath) -> TagPath:
    """Returns a path below the root without repetition: nested bodies count once, and so do nested
    defaults."""
    plain: list[str] = []
    for tag in path[1:]:
        name = _STANDS_FOR.get(tag, tag)
        if not (plain and name == plain[-1] and name in ("body", "default")):
            plain.append(name)
    return tuple(plain)


def listed() -> dict[TagPath, set[str]]:
    """Returns the attributes of each element by its path below the root, as `mj_printSchema` lists them."""
    table: dict[TagPath, set[str]] = {}
    ancestors: list[str] = []
    path: TagPath = ()
    for line in mujoco.mj_printSchema(False, True).splitlines():
        match = _LINE.match(line)
        if match:
            level = len(match[1]) // 3
            name = {"(world)body": "body", "mujoco": ""}.get(match[2], match[2])
            ancestors[level:] = [name]
            path = tuple(ancestors[1:])
            table.setdefault(path, set()).update(match[3].split())
        elif line.strip():
            table[path].update(line.split())
    return table
