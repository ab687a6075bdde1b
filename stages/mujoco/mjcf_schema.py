"""The elements and attributes of MJCF that a MuJoCo knows, by its own account."""

import functools
import re
from collections.abc import Collection, Mapping

import mujoco

Known = tuple[frozenset[str] | None, frozenset[str] | None]
"""The attributes and the children of an element; None: any."""

_LINE = re.compile(r"( *)(\S+) \(.\) *(.*)")

_FRAMES = frozenset(["pos", "quat", "axisangle", "xyaxes", "zaxis", "euler"])

_ANYWHERE = frozenset({"include"})
"""Elements that may be in any other."""

_REPEATED = {"worldbody": "body", "frame": "body", "replicate": "body"}
"""Elements that may have in them what a body may have."""

_IN_BODIES = frozenset(["body", "frame", "replicate", "composite"])
"""Elements of a body that MuJoCo's account leaves out, or means by repetition."""

_OWN: dict[str, frozenset[str] | None] = {
    "worldbody": None,
    "frame": _FRAMES | {"name", "childclass", "scale"},
    "replicate": _FRAMES | {"count", "sep", "offset", "childclass", "name"},
    "composite": None,
}
"""Attributes of elements that MuJoCo's account leaves out; None: any."""


Way = tuple[str, ...]
"""The tags from the root to an element."""


class MjcfSchema:
    """What a version of MuJoCo knows. `listed`: the attributes of each element, by its way below the root."""

    def __init__(self, listed: Mapping[Way, Collection[str]]) -> None:
        children: dict[Way, set[str]] = {}
        for way in listed:
            if way:
                children.setdefault(way[:-1], set()).add(way[-1])
        children[()] = (children[()] - {"body"}) | {"worldbody"}
        children["body",] |= _IN_BODIES
        children["default",] |= {"default"}
        self._by_way: dict[Way, Known] = {
            way: (frozenset(attributes), frozenset(children.get(way, ())) | _ANYWHERE)
            for way, attributes in listed.items()
        }

    def known(self, way: Way) -> Known:
        """What an element may have, by the tags from the root to it."""
        if "composite" in way[:-1] or "include" in way:
            return None, None
        attributes, children = self._by_way.get(_plain(way), (None, None))
        own = way[-1]
        if own in _OWN:
            attributes = _OWN[own]
        if attributes is not None and len(way) > 1 and way[1] == "worldbody":
            attributes = attributes | _extra(own)
        return attributes, children


def known(way: Way) -> Known:
    """What the installed MuJoCo knows that an element may have, by the tags from the root to it."""
    return installed().known(way)


@functools.cache
def installed() -> MjcfSchema:
    """What the installed MuJoCo knows."""
    return MjcfSchema(listed())


def _extra(tag: str) -> frozenset[str]:
    """Attributes of an element in a body that MuJoCo reads, and does not list."""
    return frozenset({"childclass"}) if tag in ("body", "frame") else frozenset()


def _plain(way: Way) -> Way:
    """A way without repetition: bodies in bodies count once, defaults in defaults too."""
    found: list[str] = []
    for tag in way[1:]:
        one = _REPEATED.get(tag, tag)
        if not (found and one == found[-1] and one in ("body", "default")):
            found.append(one)
    return tuple(found)


def listed() -> dict[Way, set[str]]:
    """The tags from below the root to each element, and its attributes, as `mj_printSchema` lists them."""
    found: dict[Way, set[str]] = {}
    above: list[str] = []
    way: Way = ()
    for line in mujoco.mj_printSchema(False, True).splitlines():
        match = _LINE.match(line)
        if match:
            level = len(match[1]) // 3
            name = {"(world)body": "body", "mujoco": ""}.get(match[2], match[2])
            above[level:] = [name]
            way = tuple(above[1:])
            found.setdefault(way, set()).update(match[3].split())
        elif line.strip():
            found[way].update(line.split())
    return found
