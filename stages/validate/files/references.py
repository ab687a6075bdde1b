"""Every name that an element refers to is there: links, joints, classes, materials, meshes, sites, bodies."""

from collections.abc import Iterator
from difflib import get_close_matches

from linkwright.stages.formats.own_xml import names, section_of
from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.check import CheckLevel, Finding
from linkwright.stages.validate.files.names import ASSETS
from linkwright.stages.validate.reading.documents import MAKERS, ModelDocument, stem

URDF = {
    ("parent", "link"): "link",
    ("child", "link"): "link",
    ("mimic", "joint"): "joint",
}
"""Element and attribute of a URDF, and what they name."""

KINDS = {
    **dict.fromkeys(("class", "childclass"), "default"),
    **{one: one for one in ("mesh", "material", "hfield", "texture", "tendon", "geom", "camera", "actuator")},
    **dict.fromkeys(("joint", "joint1", "joint2", "jointinparent"), "joint"),
    **dict.fromkeys(("site", "site1", "site2", "cranksite", "slidersite", "refsite"), "site"),
    **dict.fromkeys(("geom1", "geom2", "sidesite"), "geom"),
    **dict.fromkeys(("body", "body1", "body2", "subtree1", "subtree2", "target"), "body"),
    **dict.fromkeys(("tendon1", "tendon2"), "tendon"),
    "sidesite": "site",
}
"""Attribute of an MJCF, and what it names."""

SECTIONS = frozenset(
    (
        *("asset", "worldbody", "contact", "equality", "tendon", "actuator", "sensor", "default"),
        *("deformable", "custom"),
    )
)
"""Sections of an MJCF in which these attributes are names."""

_OBJECTS = {"xbody": "body"}


def level(document: ModelDocument) -> CheckLevel:
    """Readers of a URDF bear it where only a colour is missing, or the joint of a transmission."""
    bears = document.foreign and document.language == "urdf"
    return "warning" if bears and not any(_of_joints(document)) else "error"


def findings(document: ModelDocument) -> Iterator[Finding]:
    """References to what is not there, with the nearest name of the kind."""
    if document.language == "urdf":
        yield from _of_joints(document)
        yield from _of_colours_and_transmissions(document)
    else:
        yield from _of_mjcf(document)


def _urdf_names(document: ModelDocument, kind: str) -> set[str]:
    return {name for other, name, _ in names(document.root, True) if other == kind}


def _of_joints(document: ModelDocument) -> Iterator[Finding]:
    known = {kind: _urdf_names(document, kind) for kind in ("link", "joint")}
    for joint in document.root.iterfind("joint"):
        for role in ("parent", "child"):
            ends = joint.findall(role)
            if not ends or not ends[0].get("link", "").strip():
                yield document.finding(joint, role, f'it needs <{role} link="..."/>')
    for element in document.root.iterfind("joint/*"):
        for (own, attribute), kind in URDF.items():
            if tag(element) == own and element.get(attribute, "").strip():
                yield from _missing(document, element, attribute, kind, element.get(attribute), known[kind])


def _of_colours_and_transmissions(document: ModelDocument) -> Iterator[Finding]:
    joints = _urdf_names(document, "joint")
    for element in document.root.iterfind("transmission/joint"):
        yield from _missing(document, element, "name", "joint", element.get("name", ""), joints)
    materials = {
        one.get("name", "") for one in document.root.iter("material") if len(one) and one.get("name")
    }
    for element in document.root.iterfind("link/visual/material"):
        if not len(element) and element.get("name"):
            yield from _missing(document, element, "name", "material", element.get("name"), materials)


def _of_mjcf(document: ModelDocument) -> Iterator[Finding]:
    root = document.root
    known = _known(root)
    made = any(element.tag in MAKERS for element in root.iter())
    for element in document.elements():
        section = section_of(element)
        if section not in SECTIONS or element.tag in MAKERS or element.tag == "bone":
            continue
        for attribute, text in element.attrib.items():
            kind = _kind(element, attribute, section)
            if kind and text.strip() and not (made and kind not in ("default", "mesh", "material")):
                yield from _missing(document, element, attribute, kind, text, known.get(kind, set()))


def _known(root: Element) -> dict[str, set[str]]:
    known: dict[str, set[str]] = {"body": {"world"}, "default": {"main"}}
    for kind, name, _ in names(root, False):
        known.setdefault(kind, set()).add(name)
    for element in root.iterfind("asset/*"):
        if element.tag in ASSETS and not element.get("name"):
            known.setdefault(str(element.tag), set()).add(stem(element))
    return known


def _kind(element: Element, attribute: str, section: str) -> str:
    """What an attribute names; "" where it is no reference."""
    if attribute in ("objname", "refname"):
        kind = str(element.get("objtype" if attribute == "objname" else "reftype", ""))
        return _OBJECTS.get(kind, kind)
    if element.tag == "default" or (attribute == "class" and section == "default"):
        return ""
    if attribute == "material" and element.tag == "mesh":
        return ""
    if attribute in ("camera", "actuator") and section != "sensor":
        return ""
    return KINDS.get(attribute, "")


def _missing(
    document: ModelDocument, element: Element, attribute: str, kind: str, name: str, known: set[str]
) -> Iterator[Finding]:
    if name in known:
        return
    near = get_close_matches(name, sorted(known), 1)
    hint = f'; did you mean "{near[0]}"?' if near else ""
    what = "class" if kind == "default" else kind
    yield document.finding(element, attribute, f'there is no {what} "{name}"{hint}')
