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

REQUIRED = {
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

_MAY_BE_INFINITE = ("range", "limit", "lower", "upper", "effort", "velocity")


def findings(document: ModelDocument) -> Iterator[Finding]:
    """Yields findings on numbers that are malformed, infinite or missing, and on wrong counts."""
    for element in document.elements():
        if document.language == "urdf":
            yield from _of_urdf(document, element)
        else:
            yield from _of_mjcf(document, element)


def _of_urdf(document: ModelDocument, element: Element) -> Iterator[Finding]:
    name_of_tag = tag(element)
    counts = URDF_COUNTS.get(name_of_tag, {})
    above = element.getparent()
    if above is None or tag(above) not in _PARENTS.get(name_of_tag, (tag(above),)):
        return
    for name in REQUIRED.get(name_of_tag, ()):
        if not element.get(name, "").strip():
            yield document.finding(element, name, f'<{name_of_tag}> needs {name}="..."')
    for name, expected in counts.items():
        words = element.get(name, "").replace(",", " ").split()
        if words:
            yield from _wrong(document, element, name, words, expected)


_PARENTS = {"limit": ("joint",), "mass": ("inertial",), "axis": ("joint",), "mesh": ("geometry",)}
"""Tag → parents that it has in a URDF, for tags with other meanings elsewhere."""


def _of_mjcf(document: ModelDocument, element: Element) -> Iterator[Finding]:
    in_bodies = any(ancestor.tag in ("worldbody", "actuator") for ancestor in element.iterancestors())
    for name, text in element.attrib.items():
        if name in NAME_ATTRIBUTES:
            continue
        words = text.split()
        expected = MJCF_COUNTS.get(name) if in_bodies and element.tag != "composite" else None
        if expected is None and not any(value is not None for value in map(_value, words)):
            continue
        yield from _wrong(document, element, name, words, expected)


def _wrong(
    document: ModelDocument, element: Element, name: str, words: list[str], expected: int | None
) -> Iterator[Finding]:
    values = [_value(word) for word in words]
    infinite = name.endswith(_MAY_BE_INFINITE)
    for word, value in zip(words, values, strict=True):
        if value is None:
            yield document.finding(element, name, f'"{word}" is not a number')
            return
        if math.isnan(value) or (math.isinf(value) and not infinite):
            yield document.finding(element, name, f'"{word}" is not a finite number')
            return
    if expected is not None and len(words) != expected:
        yield document.finding(element, name, f"expected {expected} numbers, got {len(words)}")


def _value(word: str) -> float | None:
    if "_" in word:
        return None
    try:
        return float(word)
    except ValueError:
        return None
