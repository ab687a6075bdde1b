"""XML in and out: one place that parses and writes, with entities and the network off."""

import re
from collections.abc import Mapping
from copy import deepcopy
from typing import Any, TypeAlias

from lxml import etree

Element: TypeAlias = Any
"""An lxml element; lxml ships no types of its own."""


_MOST_LEVELS = 100


class Malformed(ValueError):
    """The text is not XML, or uses entities, or exceeds the limits of nesting or length. `line`, `column`:
    where, from 1, as far as that is known; `what` is wrong there, without a word of the text, which may be
    that of any file; `quoted`: the same with its words, for a text that stands in a robot's own file."""

    def __init__(
        self, what: str, line: int | None = None, column: int | None = None, quoted: str | None = None
    ) -> None:
        super().__init__(what if line is None else f"line {line}: {what}")
        self.what, self.line, self.column = what, line, column
        self.quoted = what if quoted is None else quoted

    @property
    def place(self) -> str:
        """The message with line and column."""
        return self._at(self.what)

    @property
    def quoted_place(self) -> str:
        """The message with line and column, and with words of the text."""
        return self._at(self.quoted)

    def _at(self, what: str) -> str:
        column = "" if self.column is None else f", column {self.column}"
        return what if self.line is None else f"line {self.line}{column}: {what}"


def element(parent: Element | None, tag: str, **attributes: str | None) -> Element:
    """A new element, under `parent` unless that is None; None attributes are left out.

    Attribute names may end in "_" where the plain name is a Python keyword (class_).
    """
    given = {
        key[:-1] if key[-1] == "_" else key: value for key, value in attributes.items() if value is not None
    }
    if parent is None:
        return etree.Element(tag, given)
    return etree.SubElement(parent, tag, given)


def rooted(tag: str, namespaces: Mapping[str, str], **attributes: str) -> Element:
    """A root element that declares namespaces: prefix → name. Tags in one of these are "{name}tag"."""
    return etree.Element(tag, attributes, nsmap=dict(namespaces))


def comment(parent: Element, text: str) -> None:
    """A comment at the end of an element."""
    parent.append(etree.Comment(f" {text} "))


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
            raise _why(error, found) from None
        root = etree.fromstring(data, _parser(large, recover=True))
    dtd = root.getroottree().docinfo.internalDTD
    if dtd is not None and next(dtd.iterentities(), None) is not None:
        msg = "it declares entities, which are not read"
        raise Malformed(msg)
    return root


def fragment(text: str) -> list[Element]:
    """The elements of a text that has one or several of them, and comments, which are left out. Malformed as
    `parse`, and where there is no element, or text outside of one."""
    begin, end = f"<{_AROUND}>", f"</{_AROUND}>"
    bare = _DECLARATION.sub(lambda found: re.sub(r"\S", " ", found.group()), text.removeprefix("\ufeff"))
    try:
        root = parse(f"{begin}{bare}{end}".encode())
    except Malformed as error:
        column = error.column
        if error.line is not None and column is not None:
            # What is wrong at the end is found in what is around the text.
            shift = len(begin) if error.line == 1 else 0
            column = min(max(1, column - shift), len(bare.splitlines()[error.line - 1]) + 1 if bare else 1)
        unclosed = _MISMATCH.match(error.quoted)
        what, quoted = error.what, error.quoted
        if unclosed is not None:
            tag, line, other = unclosed.groups()
            what = f"an end tag does not close the element of line {line}"
            quoted = f"</{other}> does not close <{tag}> of line {line}"
            if other == _AROUND:
                end = f"of line {line} is not closed"
                what, quoted = f"an element {end}", f"<{tag}> {end}"
            elif tag == _AROUND:
                what, quoted = "an end tag closes nothing", f"</{other}> closes nothing"
        raise Malformed(what, error.line, column, quoted.replace(_AROUND, "text")) from None
    for words, line in ((root.text, 1), *((one.tail, one.sourceline) for one in root)):
        if words is not None and words.strip():
            what = "text outside of an element"
            raise Malformed(what, line, quoted=f"{what}: {words.strip()[:40]!r}")
    if not len(root):
        raise Malformed("there is no element")
    found = list(root)
    for one in found:
        root.remove(one)
        one.tail = None
    return found


_AROUND = "linkwright.fragment"

_DECLARATION = re.compile(r"\A\s*<\?xml[^>]*\?>")

_MISMATCH = re.compile(r"Opening and ending tag mismatch: (\S+) line (\d+) and (\S+)")


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


def _why(error: Any, found: list[Any]) -> Malformed:
    """The first thing that is wrong, with its line."""
    if not found:
        return Malformed("it is not XML", quoted=str(error.msg))
    first = next((one for one in found if one.domain != etree.ErrorDomains.NAMESPACE), found[0])
    text = " ".join(first.message.split())[:200]
    own = next((ours for theirs, ours in _LIMITS.items() if theirs in text), None)
    if own is not None:
        return Malformed(own, first.line, first.column)
    unclosed = _MISMATCH.match(text)
    what = f"an end tag does not close the element of line {unclosed[2]}" if unclosed else ""
    return Malformed(what or _unquoted(first, text), first.line, first.column, text)


def _unquoted(first: Any, text: str) -> str:
    """The parser's message as far as it is the same for each text, else the name of its error."""
    known = next((words for words in _WORDS if text.startswith(words)), None)
    name = first.type_name.removeprefix("ERR_").replace("_", " ").lower()
    return known or _MEANINGS.get(first.type_name) or f"it is not XML ({name})"


_WORDS = (
    "Start tag expected, '<' not found",
    "StartTag: invalid element name",
    "EndTag: '</' not found",
    "Extra content at the end of the document",
    "Document is empty",
    "AttValue: \" or ' expected",
    "Unescaped '<' not allowed in attributes values",
    "attributes construct error",
    "Comment not terminated",
    "CData section not finished",
    "Comment must not contain '--' (double-hyphen)",
    "Input is not proper UTF-8, indicate encoding !",
    "xmlParseEntityRef: no name",
    "EntityRef: expecting ';'",
    "internal error",
)
"""The beginnings of the parser's messages that hold nothing of the text."""

_MEANINGS = {
    "ERR_TAG_NOT_FINISHED": "an element is not closed",
    "ERR_GT_REQUIRED": "a tag does not end in >",
    "ERR_ATTRIBUTE_REDEFINED": "an attribute stands twice in an element",
    "ERR_ATTRIBUTE_WITHOUT_VALUE": "an attribute has no value",
    "ERR_UNDECLARED_ENTITY": "an entity is not defined",
    "WAR_UNDECLARED_ENTITY": "an entity is not defined",
    "ERR_UNSUPPORTED_ENCODING": "its encoding is not supported",
    "ERR_INVALID_CHAR": "it has a control character",
}
"""The parser's name of an error, whose message quotes the text → our message."""


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
