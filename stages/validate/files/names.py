"""Checks that every name is legal, and unique if the format requires it: a link and a joint may share a
name."""

from collections.abc import Iterator

from linkwright.stages.formats.own_xml import name_of, named_elements
from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.check import Finding
from linkwright.stages.validate.reading.documents import ModelDocument, stem, title_of

NAMED_ELEMENTS = ("link", "joint")
"""Elements of a URDF that are meaningless without a name."""

ASSETS = ("mesh", "hfield", "texture", "skin")
"""Assets of an MJCF that take the name of their file if they have no name."""


def findings(document: ModelDocument) -> Iterator[Finding]:
    """Yields findings on missing, unprintable and repeated names. Of two elements with the same name the
    second is reported."""
    urdf = document.language == "urdf"
    first_by_name: dict[tuple[str, str], Element] = {}
    for kind, name, element in _named_elements(document.root, urdf):
        first_element: Element = first_by_name.setdefault((kind, name), element)
        if element in document.included:
            continue
        flaw = _flaw_of_name(name)
        if flaw:
            yield document.finding(element, _naming_attribute(element), flaw)
        if first_element is not element:
            first_place = (
                f"line {first_element.sourceline}" if first_element.sourceline else title_of(first_element)
            )
            if first_element in document.included:
                first_place = f"{document.included[first_element].name}, {first_place}"
            yield document.finding(
                element,
                _naming_attribute(element),
                f'another {kind} is called "{name}" too, in {first_place}',
            )
    if urdf:
        for element in document.root:
            if tag(element) in NAMED_ELEMENTS and not (name_of(element) or "").strip():
                yield document.finding(element, "name", "it has no name")


def _named_elements(root: Element, urdf: bool) -> Iterator[tuple[str, str, Element]]:
    yield from named_elements(root, urdf)
    if not urdf:
        for element in root.iterfind("asset/*"):
            if element.tag in ASSETS and not element.get("name") and element.get("file"):
                yield str(element.tag), stem(element), element


def _naming_attribute(element: Element) -> str:
    if element.tag == "default":
        return "class"
    return "name" if element.get("name") else "file"


def _flaw_of_name(name: str) -> str:
    if name != name.strip():
        return f"the name {name!r} begins or ends with white space"
    if not name.isprintable():
        return f"the name {name!r} has letters that cannot be printed"
    return ""
