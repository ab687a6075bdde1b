"""Checks that every name that an element refers to exists: links, joints, classes, materials, meshes,
bodies."""

from collections.abc import Iterator
from difflib import get_close_matches

from linkwright.stages.formats.own_xml import named_elements, section_of
from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.check import CheckLevel, Finding
from linkwright.stages.validate.files.names import ASSETS
from linkwright.stages.validate.reading.documents import MAKERS, ModelDocument, stem

URDF_REFERENCES = {
    ("parent", "link"): "link",
    ("child", "link"): "link",
    ("mimic", "joint"): "joint",
}
"""Element and attribute of a URDF → kind of thing that they name."""

MJCF_REFERENCES = {
    **dict.fromkeys(("class", "childclass"), "default"),
    **{
        name: name
        for name in ("mesh", "material", "hfield", "texture", "tendon", "geom", "camera", "actuator")
    },
    **dict.fromkeys(("joint", "joint1", "joint2", "jointinparent"), "joint"),
    **dict.fromkeys(("site", "site1", "site2", "cranksite", "slidersite", "refsite", "sidesite"), "site"),
    **dict.fromkeys(("geom1", "geom2"), "geom"),
    **dict.fromkeys(("body", "body1", "body2", "subtree1", "subtree2", "target"), "body"),
    **dict.fromkeys(("tendon1", "tendon2"), "tendon"),
}
"""Attribute of an MJCF → kind of thing that it names."""

MJCF_SECTIONS = frozenset(
    (
        *("asset", "worldbody", "contact", "equality", "tendon", "actuator", "sensor", "default"),
        *("deformable", "custom"),
    )
)
"""Sections of an MJCF in which these attributes are names."""

_KIND_OF_OBJECT = {"xbody": "body"}
"""Type of a sensor's object → kind of thing, where the two differ."""


def level(document: ModelDocument) -> CheckLevel:
    """Returns the level of the findings: a warning if another program's URDF lacks only a colour, or the
    joint of a transmission, which readers accept."""
    tolerated = document.foreign and document.language == "urdf"
    return "warning" if tolerated and not any(_joint_findings(document)) else "error"


def findings(document: ModelDocument) -> Iterator[Finding]:
    """Yields findings on references to missing things, with the nearest name of the same kind."""
    if document.language == "urdf":
        yield from _joint_findings(document)
        yield from _colour_and_transmission_findings(document)
    else:
        yield from _mjcf_findings(document)


def _urdf_names(document: ModelDocument, kind: str) -> set[str]:
    return {name for other, name, _ in named_elements(document.root, True) if other == kind}


def _joint_findings(document: ModelDocument) -> Iterator[Finding]:
    names_of_kind = {kind: _urdf_names(document, kind) for kind in ("link", "joint")}
    for joint in document.root.iterfind("joint"):
        for role in ("parent", "child"):
            ends = joint.findall(role)
            if not ends or not ends[0].get("link", "").strip():
                yield document.finding(joint, role, f'it needs <{role} link="..."/>')
    for element in document.root.iterfind("joint/*"):
        for (name, attribute), kind in URDF_REFERENCES.items():
            if tag(element) == name and element.get(attribute, "").strip():
                yield from _finding_if_missing(
                    document, element, attribute, kind, element.get(attribute), names_of_kind[kind]
                )


def _colour_and_transmission_findings(document: ModelDocument) -> Iterator[Finding]:
    joints = _urdf_names(document, "joint")
    for element in document.root.iterfind("transmission/joint"):
        yield from _finding_if_missing(document, element, "name", "joint", element.get("name", ""), joints)
    materials = {
        node.get("name", "") for node in document.root.iter("material") if len(node) and node.get("name")
    }
    for element in document.root.iterfind("link/visual/material"):
        if not len(element) and element.get("name"):
            yield from _finding_if_missing(
                document, element, "name", "material", element.get("name"), materials
            )


def _mjcf_findings(document: ModelDocument) -> Iterator[Finding]:
    root = document.root
    names_by_kind = _names_by_kind(root)
    # Elements of these kinds may make things that the text does not name.
    has_makers = any(element.tag in MAKERS for element in root.iter())
    for element in document.elements():
        section = section_of(element)
        if section not in MJCF_SECTIONS or element.tag in MAKERS or element.tag == "bone":
            continue
        for attribute, text in element.attrib.items():
            kind = _kind(element, attribute, section)
            if kind and text.strip() and not (has_makers and kind not in ("default", "mesh", "material")):
                yield from _finding_if_missing(
                    document, element, attribute, kind, text, names_by_kind.get(kind, set())
                )


def _names_by_kind(root: Element) -> dict[str, set[str]]:
    """Returns the names of an MJCF by kind, with those that MuJoCo gives: `world`, `main`, and names of
    assets."""
    by_kind: dict[str, set[str]] = {"body": {"world"}, "default": {"main"}}
    for kind, name, _ in named_elements(root, False):
        by_kind.setdefault(kind, set()).add(name)
    for element in root.iterfind("asset/*"):
        if element.tag in ASSETS and not element.get("name"):
            by_kind.setdefault(str(element.tag), set()).add(stem(element))
    return by_kind


def _kind(element: Element, attribute: str, section: str) -> str:
    """Returns the kind of thing that an attribute names; "" if the attribute is not a reference."""
    if attribute in ("objname", "refname"):
        kind = str(element.get("objtype" if attribute == "objname" else "reftype", ""))
        return _KIND_OF_OBJECT.get(kind, kind)
    if element.tag == "default" or (attribute == "class" and section == "default"):
        return ""
    if attribute == "material" and element.tag == "mesh":
        return ""
    if attribute in ("camera", "actuator") and section != "sensor":
        return ""
    return MJCF_REFERENCES.get(attribute, "")


def _finding_if_missing(
    document: ModelDocument, element: Element, attribute: str, kind: str, name: str, existing: set[str]
) -> Iterator[Finding]:
    """Yields a finding if the `existing` names of a kind lack the name to which an attribute refers."""
    if name in existing:
        return
    nearest = get_close_matches(name, sorted(existing), 1)
    hint = f'; did you mean "{nearest[0]}"?' if nearest else ""
    word = "class" if kind == "default" else kind
    yield document.finding(element, attribute, f'there is no {word} "{name}"{hint}')
