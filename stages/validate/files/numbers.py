"""Checks that every number is finite, and that each attribute has the right count of numbers."""

import math
from collections.abc import Iterator

from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.check import Finding
from linkwright.stages.validate.reading.documents import ModelDocument

URDF_COUNTS: dict[str, dict[str, int]] = {
    "origin": {"xyz": 3, "rpy": 3, "quat_xyzw": 4},
    "mass": {"value": 1},
    "inertia": dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 1),
    "axis": {"xyz": 3},
    "limit": dict.fromkeys(("lower", "upper", "effort", "velocity"), 1),
    "dynamics": {"damping": 1, "friction": 1},
    "mimic": {"multiplier": 1, "offset": 1},
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "mesh": {"scale": 3},
    "color": {"rgba": 4},
}
"""Number of numbers in each attribute of a URDF, by element."""

REQUIRED_ATTRIBUTES = {
    "mass": ("value",),
    "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
}
"""Attributes of a URDF without which an element is meaningless."""

MJCF_COUNTS = {
    "pos": 3,
    "quat": 4,
    "axis": 3,
    "axisangle": 4,
    "xyaxes": 6,
    "zaxis": 3,
    "euler": 3,
    "diaginertia": 3,
    "fullinertia": 6,
    "mass": 1,
    "ctrlrange": 2,
    "forcerange": 2,
    "actuatorfrcrange": 2,
    "armature": 1,
    "frictionloss": 1,
    "ref": 1,
    "kp": 1,
    "rgba": 4,
}
"""Number of numbers in attributes of an MJCF."""

NAME_ATTRIBUTES = frozenset(
    (
        *("name", "class", "childclass", "file", "model", "prefix", "meshdir", "texturedir", "assetdir"),
        *("joint", "joint1", "joint2", "jointinparent", "site", "site1", "site2", "cranksite", "slidersite"),
        *("refsite", "sidesite", "geom", "geom1", "geom2", "body", "body1", "body2", "subtree1", "subtree2"),
        *("mesh", "material", "hfield", "texture", "tendon", "tendon1", "tendon2", "actuator", "camera"),
        *("target", "objname", "refname", "objtype", "reftype", "plugin", "instance", "key", "value"),
        *("data", "flex"),
    )
)
"""Attributes of an MJCF that are names, although they may look like numbers."""

_INFINITE_ENDINGS = ("range", "limit", "lower", "upper", "effort", "velocity")
"""Ends of the names of attributes that may be infinite."""


def findings(document: ModelDocument) -> Iterator[Finding]:
    """Yields findings on numbers that are malformed, infinite or missing, and on wrong counts."""
    for element in document.elements():
        if document.language == "urdf":
            yield from _urdf_findings(document, element)
        else:
            yield from _mjcf_findings(document, element)


def _urdf_findings(document: ModelDocument, element: Element) -> Iterator[Finding]:
    """Yields the flaws of an element whose parent is that of a URDF."""
    tag_name = tag(element)
    counts = URDF_COUNTS.get(tag_name, {})
    parent = element.getparent()
    if parent is None or tag(parent) not in _PARENTS.get(tag_name, (tag(parent),)):
        return
    for name in REQUIRED_ATTRIBUTES.get(tag_name, ()):
        if not element.get(name, "").strip():
            yield document.finding(element, name, f'<{tag_name}> needs {name}="..."')
    for name, expected in counts.items():
        words = element.get(name, "").replace(",", " ").split()
        if words:
            yield from _number_findings(document, element, name, words, expected)


_PARENTS = {"limit": ("joint",), "mass": ("inertial",), "axis": ("joint",), "mesh": ("geometry",)}
"""Tag → parents that it has in a URDF, for tags with other meanings elsewhere."""


def _mjcf_findings(document: ModelDocument, element: Element) -> Iterator[Finding]:
    in_bodies = any(ancestor.tag in ("worldbody", "actuator") for ancestor in element.iterancestors())
    for name, text in element.attrib.items():
        if name in NAME_ATTRIBUTES:
            continue
        words = text.split()
        # Elsewhere, attributes of these names may have other counts.
        expected = MJCF_COUNTS.get(name) if in_bodies and element.tag != "composite" else None
        if expected is None and not any(value is not None for value in map(_parsed_number, words)):
            continue
        yield from _number_findings(document, element, name, words, expected)


def _number_findings(
    document: ModelDocument, element: Element, name: str, words: list[str], expected: int | None
) -> Iterator[Finding]:
    """Yields the first flaw of an attribute that must have numbers. `words`: its value, split at white space;
    `expected`: the expected count of numbers, None for any."""
    values = [_parsed_number(word) for word in words]
    may_be_infinite = name.endswith(_INFINITE_ENDINGS)
    for word, value in zip(words, values, strict=True):
        if value is None:
            yield document.finding(element, name, f'"{word}" is not a number')
            return
        if math.isnan(value) or (math.isinf(value) and not may_be_infinite):
            yield document.finding(element, name, f'"{word}" is not a finite number')
            return
    if expected is not None and len(words) != expected:
        yield document.finding(element, name, f"expected {expected} numbers, got {len(words)}")


def _parsed_number(word: str) -> float | None:
    """Returns the number that a word is; None for any other word."""
    # Python reads 1_000 as a number, but no reader of models does.
    if "_" in word:
        return None
    try:
        return float(word)
    except ValueError:
        return None
