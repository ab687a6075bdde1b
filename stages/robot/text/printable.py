"""Makes text that a terminal, a log or an XML file can show. No other module replaces control characters."""

import re
import unicodedata
from typing import Any

_UNPRINTABLE = re.compile(
    "["
    "\x00-\x08\x0b-\x1f\x7f-\x9f"  # C0 except tab and line feed, DEL, C1: cursor, colour, OSC, CSI
    "\xad\u200b\u2060-\u2064\ufeff"  # no width, so that two names look alike
    "\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"  # change the direction of text
    "\u180e\u206a-\u206f\ufff9-\ufffb\U000e0000-\U000e007f"  # invisible formats and tags
    "\u2028\u2029"  # line ends for some readers only
    "\ud800-\udfff\ufffe\uffff"  # surrogates and non-characters, which XML forbids
    "]"
)
"""Invisible characters that a terminal or an XML reader interprets or refuses.

Joiners (U+200C, U+200D) stay: emoji, Persian and Indic words are made of them.
"""


def printable(text: str) -> str:
    """Returns `text` on a single line, with control characters as JSON writes them (`\\u001b`, `\\n`) and
    tabs as spaces."""
    return printable_lines(text).replace("\n", "\\n").replace("\t", " ")


def printable_lines(text: str) -> str:
    """Returns `text` with control characters as JSON writes them (`\\u001b`), except line feeds and tabs. A
    text that is JSON keeps its meaning."""
    return _UNPRINTABLE.sub(_escaped, text)


def sentence(text: str) -> str:
    """Returns a message on a single line: line breaks, as in messages of libraries, become spaces."""
    return printable(re.sub(r"[ \t]*\n[ \t\n]*", " ", text.rstrip(" \t\n")))


def columns(text: str) -> int:
    """Returns the number of columns that `text` takes in a terminal."""
    return sum(2 if unicodedata.east_asian_width(letter) in "WF" else 1 for letter in text)


def _escaped(match: re.Match[str]) -> str:
    """Returns a character as JSON writes it, one beyond U+FFFF as two surrogates."""
    code = match[0].encode("utf-16-be", "surrogatepass").hex()
    return "".join(f"\\u{code[start : start + 4]}" for start in range(0, len(code), 4))


def join_lines(value: Any) -> Any:
    """Returns a value of YAML in which texts with line breaks are on a single line: each run of white space
    is a space."""
    if isinstance(value, str):
        return " ".join(value.split()) if "\n" in value else value
    if isinstance(value, dict):
        return {join_lines(name): join_lines(inner) for name, inner in value.items()}
    return [join_lines(inner) for inner in value] if isinstance(value, list) else value
