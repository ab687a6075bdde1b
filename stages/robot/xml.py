"""XML in and out: one place that parses and writes, with entities and the network off."""

from typing import Any, TypeAlias

from lxml import etree

Element: TypeAlias = Any
"""An lxml element; lxml ships no types of its own."""


def element(parent: Element | None, tag: str, **attributes: str | None) -> Element:
    """A new element, under `parent` unless that is None; None attributes are left out.

    Attribute names may end in "_" where the plain name is a Python keyword (class_).
    """
    given = {key.rstrip("_"): value for key, value in attributes.items() if value is not None}
    if parent is None:
        return etree.Element(tag, given)
    return etree.SubElement(parent, tag, given)


def to_bytes(root: Element) -> bytes:
    """The document as UTF-8 with two spaces a level and a newline at the end."""
    etree.indent(root, space="  ")
    text: bytes = etree.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def parse(data: bytes) -> Element:
    """The root element; no entity is expanded and nothing is fetched."""
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False)
    return etree.fromstring(data, parser)
