"""What the page's own MuJoCo knows: an older one than the one that the robot is built with."""

import functools
import gzip
import json
from collections.abc import Iterator
from pathlib import Path

from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.mujoco.mjcf_schema import MjcfSchema

VERSION = "3.14.0"
_LISTED = Path(__file__).parents[1] / "viewer" / "engine" / f"mjcf-{VERSION}.json.gz"

_BUILTIN = frozenset({"box", "cylinder", "disc", "ellipsoid", "grid", "square"})
"""Shapes of `<mesh builtin>` that came after 3.14."""

_FOR_THE_EYE = frozenset({"castshadow", "savecanonical", "savecompiled", "passthrough", "embed"})
"""Attributes that change no motion: no loss in the page."""

_INSTEAD = {
    "springyield": "the spring does not yield",
    "speculative": "contacts are found only where shapes touch",
    "plastic": "no spring has yielded at the start",
    "yield": "the material does not yield",
    "actuatorfrcrange": "the force of the tendon's actuators is not limited",
    "armature": "the tendon has no armature",
}


@functools.cache
def schema() -> MjcfSchema:
    """The elements and attributes of MJCF that it knows, by its own account (`mj_printSchema`)."""
    listed = json.loads(gzip.decompress(_LISTED.read_bytes()))["elements"]
    ways = ((tuple(way.split("/")) if way else (), names) for way, names in listed.items())
    return MjcfSchema(dict(ways))


def without_newer(root: Element) -> list[dict[str, str]]:
    """Takes out of a document, in place, what the page's MuJoCo does not know. Returns what that is, where it
    was, and what the page has instead."""
    return list(_without(root, ("mujoco",)))


def is_newer_shape(mesh: Element) -> bool:
    """Whether a mesh is a built-in shape that the page's MuJoCo cannot make."""
    return mesh.get("builtin") in _BUILTIN


def _without(node: Element, way: tuple[str, ...]) -> Iterator[dict[str, str]]:
    attributes, children = schema().known(way)
    if attributes is not None:
        for name in sorted(set(node.attrib) - attributes):
            del node.attrib[name]
            if name not in _FOR_THE_EYE:
                yield _lack(f"the attribute {name}", node, _INSTEAD.get(name, "MuJoCo's default"))
    for child in list(node):
        if children is not None and tag(child) not in children:
            node.remove(child)
            yield _lack(f"the element <{tag(child)}>", child, "it is left out")
        else:
            yield from _without(child, (*way, tag(child)))


def _lack(what: str, node: Element, instead: str) -> dict[str, str]:
    name = node.get("name") or node.get("class")
    return {"what": what, "place": f"{tag(node)} {name}" if name else tag(node), "instead": instead}
