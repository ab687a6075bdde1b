"""Every number is one, finite, and there are as many as the attribute has."""

import math
from collections.abc import Iterator

from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.check import Finding
from linkwright.stages.validate.reading.documents import ModelDocument

URDF: dict[str, dict[str, int]] = {
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
"""How many numbers the attributes of a URDF have."""

NEEDED = {
    "mass": ("value",),
    "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
}
"""Numbers of a URDF without which an element has no meaning."""

MJCF = {
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
"""How many numbers attributes of an MJCF have."""

WORDS = frozenset(
    (
        *("name", "class", "childclass", "file", "model", "prefix", "meshdir", "texturedir", "assetdir"),
        *("joint", "joint1", "joint2", "jointinparent", "site", "site1", "site2", "cranksite", "slidersite"),
        *("refsite", "sidesite", "geom", "geom1", "geom2", "body", "body1", "body2", "subtree1", "subtree2"),
        *("mesh", "material", "hfield", "texture", "tendon", "tendon1", "tendon2", "actuator", "camera"),
        *("target", "objname", "refname", "objtype", "reftype", "plugin", "instance", "key", "value"),
        *("data", "flex"),
    )
)
"""Attributes of an MJCF that are names, and may look like numbers."""

_MAY_BE_INFINITE = ("range", "limit", "lower", "upper", "effort", "velocity")


def findings(document: ModelDocument) -> Iterator[Finding]:
    """Numbers that are none, not finite, missing, or too many."""
    for element in document.elements():
        if document.language == "urdf":
            yield from _of_urdf(document, element)
        else:
            yield from _of_mjcf(document, element)


def _of_urdf(document: ModelDocument, element: Element) -> Iterator[Finding]:
    own = tag(element)
    known = URDF.get(own, {})
    above = element.getparent()
    if above is None or tag(above) not in _ABOVE.get(own, (tag(above),)):
        return
    for name in NEEDED.get(own, ()):
        if not element.get(name, "").strip():
            yield document.finding(element, name, f'<{own}> needs {name}="..."')
    for name, wanted in known.items():
        words = element.get(name, "").replace(",", " ").split()
        if words:
            yield from _wrong(document, element, name, words, wanted)


_ABOVE = {"limit": ("joint",), "mass": ("inertial",), "axis": ("joint",), "mesh": ("geometry",)}
"""What an element is in, where its tag is also that of others."""


def _of_mjcf(document: ModelDocument, element: Element) -> Iterator[Finding]:
    in_bodies = any(one.tag in ("worldbody", "actuator") for one in element.iterancestors())
    for name, text in element.attrib.items():
        if name in WORDS:
            continue
        words = text.split()
        wanted = MJCF.get(name) if in_bodies and element.tag != "composite" else None
        if wanted is None and not any(value is not None for value in map(_value, words)):
            continue
        yield from _wrong(document, element, name, words, wanted)


def _wrong(
    document: ModelDocument, element: Element, name: str, words: list[str], wanted: int | None
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
    if wanted is not None and len(words) != wanted:
        yield document.finding(element, name, f"expected {wanted} numbers, got {len(words)}")


def _value(word: str) -> float | None:
    if "_" in word:
        return None
    try:
        return float(word)
    except ValueError:
        return None
