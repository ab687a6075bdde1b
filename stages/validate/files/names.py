"""Every name is legal, and unique where the format asks: a link and a joint may share one."""

from collections.abc import Iterator

from linkwright.stages.formats.own_xml import name_of, names
from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.check import Finding
from linkwright.stages.validate.reading.documents import ModelDocument, called, stem

NEEDED = ("link", "joint")
"""Elements of a URDF that have no meaning without a name."""

ASSETS = ("mesh", "hfield", "texture", "skin")
"""Assets of an MJCF that have the name of their file where they have none."""


def findings(document: ModelDocument) -> Iterator[Finding]:
    """Missing, unprintable and repeated names. Of two elements with one name the second is named."""
    urdf = document.language == "urdf"
    first: dict[tuple[str, str], Element] = {}
    for kind, name, element in _named(document.root, urdf):
        other: Element = first.setdefault((kind, name), element)
        if element in document.included:
            continue
        wrong = _illegal(name)
        if wrong:
            yield document.finding(element, _attribute(element), wrong)
        if other is not element:
            where = f"line {other.sourceline}" if other.sourceline else called(other)
            if other in document.included:
                where = f"{document.included[other].name}, {where}"
            yield document.finding(
                element, _attribute(element), f'another {kind} is called "{name}" too, in {where}'
            )
    if urdf:
        for element in document.root:
            if tag(element) in NEEDED and not (name_of(element) or "").strip():
                yield document.finding(element, "name", "it has no name")


def _named(root: Element, urdf: bool) -> Iterator[tuple[str, str, Element]]:
    yield from names(root, urdf)
    if not urdf:
        for element in root.iterfind("asset/*"):
            if element.tag in ASSETS and not element.get("name") and element.get("file"):
                yield str(element.tag), stem(element), element


def _attribute(element: Element) -> str:
    if element.tag == "default":
        return "class"
    return "name" if element.get("name") else "file"


def _illegal(name: str) -> str:
    if name != name.strip():
        return f"the name {name!r} begins or ends with white space"
    if not name.isprintable():
        return f"the name {name!r} has letters that cannot be printed"
    return ""
