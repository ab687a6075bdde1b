"""Every element and attribute is one of the format's: readers skip a misspelled one, or refuse the file."""

from collections.abc import Iterator
from difflib import get_close_matches

from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.mujoco import mjcf_schema
from linkwright.stages.robot.check import CheckLevel, Finding
from linkwright.stages.validate.files import urdf_schema
from linkwright.stages.validate.reading.documents import ModelDocument


def level(document: ModelDocument) -> CheckLevel:
    """MuJoCo refuses an MJCF with an unknown element; readers of URDF leave it out."""
    return "error" if document.language == "mjcf" else "warning"


def findings(document: ModelDocument) -> Iterator[Finding]:
    """Unknown elements and attributes, with the nearest name that is known."""
    schema = urdf_schema if document.language == "urdf" else mjcf_schema
    for element in document.elements():
        way = [tag(one) for one in (*reversed(list(element.iterancestors())), element)]
        attributes, children = schema.known(tuple(way))
        if attributes is not None:
            for name in element.attrib:
                if ":" not in name and not name.startswith("{") and name not in attributes:
                    message = f"<{tag(element)}> has no such attribute{_near(name, attributes)}"
                    yield document.finding(element, name, message)
        if children is not None:
            yield from _unknown(document, element, children)


def _unknown(document: ModelDocument, element: Element, children: frozenset[str]) -> Iterator[Finding]:
    for child in element:
        name = tag(child)
        if child not in document.included and ":" not in name and name not in children:
            message = f"<{tag(element)}> has no such element{_near(name, children)}"
            yield document.finding(child, "", message)


def _near(name: str, known: frozenset[str]) -> str:
    near = get_close_matches(name, sorted(known), 1)
    return f"; did you mean {near[0]}?" if near else ""
