"""Parses and writes XML, with entities and the network off: no other module does."""

import re
from collections.abc import Mapping
from copy import deepcopy
from typing import Any, TypeAlias

from lxml import etree

Element: TypeAlias = Any
"""An lxml element; lxml ships no types of its own."""


_MAX_INDENTED_LEVELS = 100
"""Number of levels beyond which the indentation does not grow."""


class Malformed(ValueError):
    """The error that a text is not XML, or uses entities, or exceeds the limits of nesting or length.

    `line`, `column`: the place, from 1, if it is known; `problem`: the error, without a word of the text,
    which may be that of any file; `quoted`: the same with words of the text, for a text in a robot's own
    file.
    """

    def __init__(
        self, problem: str, line: int | None = None, column: int | None = None, quoted: str | None = None
    ) -> None:
        super().__init__(problem if line is None else f"line {line}: {problem}")
        self.problem, self.line, self.column = problem, line, column
        self.quoted = problem if quoted is None else quoted

    @property
    def place(self) -> str:
        """The message, with line and column as far as they are known."""
        return self._at(self.problem)

    @property
    def quoted_place(self) -> str:
        """The message with words of the text, with line and column as far as they are known."""
        return self._at(self.quoted)

    def _at(self, problem: str) -> str:
        column = "" if self.column is None else f", column {self.column}"
        return problem if self.line is None else f"line {self.line}{column}: {problem}"


def element(parent: Element | None, tag: str, **attributes: str | None) -> Element:
    """Makes an element, under `parent` unless that is None; None attributes are left out.

    Attribute names may end in "_" if the plain name is a Python keyword (class_).
    """
    present = {
        key[:-1] if key[-1] == "_" else key: value for key, value in attributes.items() if value is not None
    }
    if parent is None:
        return etree.Element(tag, present)
    return etree.SubElement(parent, tag, present)


def rooted(tag: str, namespaces: Mapping[str, str], **attributes: str) -> Element:
    """Makes a root element that declares namespaces: prefix → name. Tags in a namespace are "{name}tag"."""
    return etree.Element(tag, attributes, nsmap=dict(namespaces))


def comment(parent: Element, text: str) -> None:
    """Adds a comment at the end of an element."""
    parent.append(etree.Comment(f" {text} "))


def to_bytes(root: Element) -> bytes:
    """Returns the document as UTF-8, indented by two spaces a level for the first hundred levels, with a
    newline at the end."""
    _indent(root)
    text: bytes = etree.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def to_text(node: Element) -> str:
    """Returns an element with its whole content as text, with only those namespaces that it uses."""
    copied = deepcopy(node)
    etree.cleanup_namespaces(copied)
    text: str = etree.tostring(copied, encoding="unicode", with_tail=False)
    return text


def _indent(root: Element) -> None:
    """Puts every element on its own line, except those next to text that is not blank.

    Without a limit of levels, the white space of a deep tree would grow with the square of its depth.
    """
    # lxml searches everything above an element when it frees the element, unless its parent is in use.
    everything = list(root.iter())
    waiting = [(everything[0], 0)]
    while waiting:
        parent, level = waiting.pop()
        before_child = "\n" + "  " * min(level + 1, _MAX_INDENTED_LEVELS)
        last = None
        for child in parent:
            if last is None:
                parent.text = _indented(parent.text, before_child)
            else:
                last.tail = _indented(last.tail, before_child)
            last = child
            if len(child):
                waiting.append((child, level + 1))
        if last is not None:
            last.tail = _indented(last.tail, "\n" + "  " * min(level, _MAX_INDENTED_LEVELS))


def _indented(text: str | None, space: str) -> str:
    """Returns `space` in place of a blank text; other texts stay."""
    return space if text is None or not text.strip() else text


def parse(data: bytes, *, large: bool = False) -> Element:
    """Returns the root element, without comments. Raises Malformed for malformed text.

    `large`: texts may be longer than 10 MB, as the arrays of a mesh are, and elements may be nested 2048
    levels deep instead of 256. No entity is expanded and nothing is fetched: a text that declares entities is
    refused. A prefix without a declared namespace is accepted, as most readers know no namespaces.
    """
    parser = _parser(large)
    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        # The error's own log holds the errors of earlier texts too.
        errors = list(parser.error_log)
        if not errors or any(entry.domain != etree.ErrorDomains.NAMESPACE for entry in errors):
            raise _malformed(error, errors) from None
        root = etree.fromstring(data, _parser(large, recover=True))
    dtd = root.getroottree().docinfo.internalDTD
    if dtd is not None and next(dtd.iterentities(), None) is not None:
        msg = "it declares entities, which are not read"
        raise Malformed(msg)
    return root


def fragment(text: str) -> list[Element]:
    """Returns the elements of a text of one element or several, without comments.

    Raises Malformed as `parse`, and if there is no element, or text outside of an element.
    """
    start_tag, end_tag = f"<{_WRAPPER}>", f"</{_WRAPPER}>"
    # Blanks in place of the declaration, so that lines and columns stay.
    bare = _DECLARATION.sub(lambda match: re.sub(r"\S", " ", match.group()), text.removeprefix("\ufeff"))
    try:
        root = parse(f"{start_tag}{bare}{end_tag}".encode())
    except Malformed as error:
        column = error.column
        if error.line is not None and column is not None:
            # An error at the end of the text is found in the end tag of the wrapper.
            lines = bare.split("\n")
            length = len(lines[error.line - 1]) if error.line <= len(lines) else 0
            shift = len(start_tag) if error.line == 1 else 0
            column = min(max(1, column - shift), length + 1)
        mismatch = _MISMATCH.match(error.quoted)
        problem, quoted = error.problem, error.quoted
        if mismatch is not None:
            opened_tag, line, closing_tag = mismatch.groups()
            problem = f"an end tag does not close the element of line {line}"
            quoted = f"</{closing_tag}> does not close <{opened_tag}> of line {line}"
            if closing_tag == _WRAPPER:
                fault = f"of line {line} is not closed"
                problem, quoted = f"an element {fault}", f"<{opened_tag}> {fault}"
            elif opened_tag == _WRAPPER:
                problem, quoted = "an end tag closes nothing", f"</{closing_tag}> closes nothing"
        raise Malformed(problem, error.line, column, quoted.replace(_WRAPPER, "text")) from None
    for words, line in ((root.text, 1), *((node.tail, node.sourceline) for node in root)):
        if words is not None and words.strip():
            problem = "text outside of an element"
            raise Malformed(problem, line, quoted=f"{problem}: {words.strip()[:40]!r}")
    if not len(root):
        raise Malformed("there is no element")
    nodes = list(root)
    for node in nodes:
        root.remove(node)
        node.tail = None
    return nodes


_WRAPPER = "linkwright.fragment"
"""The element around a text of several elements while it is parsed."""

_DECLARATION = re.compile(r"\A\s*<\?xml[^>]*\?>")
"""An XML declaration, which only the beginning of a document may have."""

_MISMATCH = re.compile(r"Opening and ending tag mismatch: (\S+) line (\d+) and (\S+)")
"""The parser's message of an end tag of another element: the open element, its line, and the end tag."""


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


def _malformed(error: Any, errors: list[Any]) -> Malformed:
    """Returns our error for a parser's error: by the first of its `errors` that is not about namespaces."""
    if not errors:
        return Malformed("it is not XML", quoted=str(error.msg))
    first = next((entry for entry in errors if entry.domain != etree.ErrorDomains.NAMESPACE), errors[0])
    text = " ".join(first.message.split())[:200]
    limit = next((message for pattern, message in _LIMITS.items() if pattern in text), None)
    if limit is not None:
        return Malformed(limit, first.line, first.column)
    mismatch = _MISMATCH.match(text)
    problem = f"an end tag does not close the element of line {mismatch[2]}" if mismatch else ""
    return Malformed(problem or _unquoted(first, text), first.line, first.column, text)


def _unquoted(first: Any, text: str) -> str:
    """Returns the parser's message if it is the same for each text, or else the name of its error."""
    message = next((words for words in _SAFE_MESSAGES if text.startswith(words)), None)
    name = first.type_name.removeprefix("ERR_").replace("_", " ").lower()
    return message or _MEANINGS.get(first.type_name) or f"it is not XML ({name})"


_SAFE_MESSAGES = (
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
    "ERR_ATTRIBUTE_REDEFINED": "an element has an attribute twice",
    "ERR_ATTRIBUTE_WITHOUT_VALUE": "an attribute has no value",
    "ERR_UNDECLARED_ENTITY": "an entity is not defined",
    "WAR_UNDECLARED_ENTITY": "an entity is not defined",
    "ERR_UNSUPPORTED_ENCODING": "its encoding is not supported",
    "ERR_INVALID_CHAR": "it has a control character",
}
"""The parser's name of an error whose message quotes the text → our message."""


_LIMITS = {
    "Excessive depth": "elements are nested too deeply",
    "Resource limit": "a text or a value is longer than 10 MB",
    "amplification": "its entities expand beyond the limit",
}
"""The parser's messages for its limits (they name the parser's own options) → our messages."""


def tag(element: Element) -> str:
    """Returns an element's name, with its prefix, if any."""
    name = str(element.tag).rpartition("}")[2]
    return f"{element.prefix}:{name}" if element.prefix else name
