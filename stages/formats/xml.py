"""XML in and out: one place that parses and writes, with entities and the network off."""

from copy import deepcopy
from typing import Any, TypeAlias

from lxml import etree

Element: TypeAlias = Any
"""An lxml element; lxml ships no types of its own."""


_MOST_LEVELS = 100


class Malformed(ValueError):
    """The text is not XML, or uses entities, or exceeds the limits of nesting or length."""


def element(parent: Element | None, tag: str, **attributes: str | None) -> Element:
    """A new element, under `parent` unless that is None; None attributes are left out.

    Attribute names may end in "_" where the plain name is a Python keyword (class_).
    """
    given = {key.rstrip("_"): value for key, value in attributes.items() if value is not None}
    if parent is None:
        return etree.Element(tag, given)
    return etree.SubElement(parent, tag, given)


def to_bytes(root: Element) -> bytes:
    """The document as UTF-8 with two spaces a level, of the first hundred, and a newline at the end."""
    _indent(root)
    text: bytes = etree.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def to_text(node: Element) -> str:
    """An element with all that is in it, as text, and of namespaces only those that are used in it."""
    own = deepcopy(node)
    etree.cleanup_namespaces(own)
    text: str = etree.tostring(own, encoding="unicode", with_tail=False)
    return text


def _indent(root: Element) -> None:
    """Puts every element on its own line, except those beside text that is not blank.

    The white space of a deep tree grows with its square where every level has more.
    """
    # lxml looks through all that is above an element when it lets go of it, unless its parent is in use.
    everything = list(root.iter())
    waiting = [(everything[0], 0)]
    while waiting:
        parent, level = waiting.pop()
        inner = "\n" + "  " * min(level + 1, _MOST_LEVELS)
        last = None
        for child in parent:
            if last is None:
                parent.text = _spaced(parent.text, inner)
            else:
                last.tail = _spaced(last.tail, inner)
            last = child
            if len(child):
                waiting.append((child, level + 1))
        if last is not None:
            last.tail = _spaced(last.tail, "\n" + "  " * min(level, _MOST_LEVELS))


def _spaced(text: str | None, space: str) -> str:
    return space if text is None or not text.strip() else text


def parse(data: bytes, *, large: bool = False) -> Element:
    """The root element, without comments; Malformed without one. `large`: texts may be longer
    than 10 MB, as the arrays of a mesh are.

    No entity is expanded and nothing is fetched: a text that declares entities is refused. A prefix
    that no namespace is declared for is let through, as most readers know of no namespaces.
    """
    parser = _parser(large)
    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        # The error's own log holds those of earlier texts too.
        found = list(parser.error_log)
        if not found or any(one.domain != etree.ErrorDomains.NAMESPACE for one in found):
            raise Malformed(_why(error, found)) from None
        root = etree.fromstring(data, _parser(large, recover=True))
    dtd = root.getroottree().docinfo.internalDTD
    if dtd is not None and next(dtd.iterentities(), None) is not None:
        msg = "it declares entities, which are not read"
        raise Malformed(msg)
    return root


def _parser(large: bool, *, recover: bool = False) -> Any:
    return etree.XMLParser(
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=large,
        remove_comments=True,
        remove_pis=True,
        recover=recover,
    )


def _why(error: Any, found: list[Any]) -> str:
    """The first thing that is wrong, with its line."""
    if not found:
        return str(error.msg)
    first = next((one for one in found if one.domain != etree.ErrorDomains.NAMESPACE), found[0])
    text = " ".join(first.message.split())[:200]
    own = next((ours for theirs, ours in _LIMITS.items() if theirs in text), text)
    return f"line {first.line}: {own}"


_LIMITS = {
    "Excessive depth": "elements are nested more than 256 deep",
    "Resource limit": "a text or a value is longer than 10 MB",
    "amplification": "its entities expand beyond the limit",
}
"""The parser's messages for its limits (they name the parser's own options) → our messages."""


def tag(element: Element) -> str:
    """An element's name, with its prefix where it has one."""
    name = str(element.tag).rpartition("}")[2]
    return f"{element.prefix}:{name}" if element.prefix else name
