"""Checks that elements and attributes are the format's: readers skip misspelled names, or refuse the file."""

from collections.abc import Iterator
from difflib import get_close_matches

from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.mujoco import mjcf_schema
from linkwright.stages.robot.check import CheckLevel, Finding
from linkwright.stages.validate.files import urdf_schema
from linkwright.stages.validate.reading.documents import ModelDocument


def level(document: ModelDocument) -> CheckLevel:
    """Returns the level of the findings: an error for MJCF, since MuJoCo refuses unknown elements, and a
    warning for URDF, whose readers skip them."""
    return "error" if document.language == "mjcf" else "warning"


def findings(document: ModelDocument) -> Iterator[Finding]:
    """Yields findings on unknown elements and attributes, with the nearest known name."""
    schema = urdf_schema if document.language == "urdf" else mjcf_schema
    for element in document.elements():
        path = [tag(node) for node in (*reversed(list(element.iterancestors())), element)]
        attributes, children = schema.allowed(tuple(path))
        if attributes is not None:
            # A name with a namespace is another program's.
            for name in element.attrib:
                if ":" not in name and not name.startswith("{") and name not in attributes:
                    message = f"<{tag(element)}> has no such attribute{_suggestion(name, attributes)}"
                    yield document.finding(element, name, message)
        if children is not None:
            yield from _unknown_children(document, element, children)


def _unknown_children(
    document: ModelDocument, element: Element, children: frozenset[str]
) -> Iterator[Finding]:
    for child in element:
        name = tag(child)
        if child not in document.included and ":" not in name and name not in children:
            message = f"<{tag(element)}> has no such element{_suggestion(name, children)}"
            yield document.finding(child, "", message)


def _suggestion(name: str, names: frozenset[str]) -> str:
    matches = get_close_matches(name, sorted(names), 1)
    return f"; did you mean {matches[0]}?" if matches else ""
