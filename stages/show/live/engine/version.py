"""Removes from a model what the page's MuJoCo does not know: it may be older than the MuJoCo of builds."""

import functools
import gzip
import json
from collections.abc import Iterator
from pathlib import Path

from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.mujoco.mjcf_schema import MjcfSchema

VERSION = "3.14.0"
_SCHEMA_FILE = Path(__file__).parents[1] / "viewer" / "engine" / f"mjcf-{VERSION}.json.gz"

_BUILTIN = frozenset({"box", "cylinder", "disc", "ellipsoid", "grid", "square"})
"""Shapes of `<mesh builtin>` that MuJoCo has only since a version after 3.14."""

_HARMLESS = frozenset({"castshadow", "savecanonical", "savecompiled", "passthrough", "embed"})
"""Attributes without effect on motion, whose removal is not reported."""

_REPLACEMENTS = {
    "springyield": "the spring does not yield",
    "speculative": "contacts are found only where shapes touch",
    "plastic": "no spring has yielded at the start",
    "yield": "the material does not yield",
    "actuatorfrcrange": "the force of the tendon's actuators is not limited",
    "armature": "the tendon has no armature",
}


@functools.cache
def schema() -> MjcfSchema:
    """Returns the elements and attributes of MJCF that the page's MuJoCo knows, from its list
    (`mj_printSchema`)."""
    names_of_elements = json.loads(gzip.decompress(_SCHEMA_FILE.read_bytes()))["elements"]
    paths = ((tuple(path.split("/")) if path else (), names) for path, names in names_of_elements.items())
    return MjcfSchema(dict(paths))


def remove_newer(root: Element) -> list[dict[str, str]]:
    """Removes from a document, in place, the elements and attributes that the page's MuJoCo does not know.
    Returns each with its place and the page's replacement."""
    return list(_remove_unknown(root, ("mujoco",)))


def is_newer_shape(mesh: Element) -> bool:
    """Tells whether a mesh is a built-in shape that the page's MuJoCo cannot make."""
    return mesh.get("builtin") in _BUILTIN


def _remove_unknown(node: Element, path: tuple[str, ...]) -> Iterator[dict[str, str]]:
    attributes, children = schema().allowed(path)
    if attributes is not None:
        for name in sorted(set(node.attrib) - attributes):
            del node.attrib[name]
            if name not in _HARMLESS:
                yield _lack(f"the attribute {name}", node, _REPLACEMENTS.get(name, "MuJoCo's default"))
    for child in list(node):
        if children is not None and tag(child) not in children:
            node.remove(child)
            yield _lack(f"the element <{tag(child)}>", child, "it is left out")
        else:
            yield from _remove_unknown(child, (*path, tag(child)))


def _lack(feature: str, node: Element, instead: str) -> dict[str, str]:
    name = node.get("name") or node.get("class")
    return {"what": feature, "place": f"{tag(node)} {name}" if name else tag(node), "instead": instead}
