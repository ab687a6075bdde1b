"""Wraps the lines of messages to the width of a terminal. Imports nothing heavy.

Wrapped text can still be pasted: no word is broken, YAML in braces may have several lines, and a command is
continued after a backslash.
"""

import re
from collections.abc import Iterator

from linkwright.stages.robot.text.printable import columns

_COMMAND = re.compile(r"(?:^|(?<=[→:] ))linkwright(?: (?:'[^']*'|\"[^\"]*\"|[^\s'\"])+)+$")
"""A possible command, at the end of a line."""

_WORD = re.compile(r"(?:'[^']*'|\"[^\"]*\"|[^\s'\"])+")
"""A word of a command, with the quotes of a shell."""

_NON_WORD = re.compile(r"[^\w]")
"""Characters of a command's words, which a sentence's words lack, except those after `linkwright`."""


def wrapped(text: str, width: int) -> str:
    """Wraps `text` into lines of at most `width` columns; longer words are not broken."""
    return "\n".join(part for line in text.split("\n") for part in _parts(line, width))


def _parts(line: str, width: int) -> Iterator[str]:
    """Yields the parts of a wrapped line; all but the first are indented by two more columns."""
    if columns(line) <= width:
        yield line
        return
    start = len(line) - len(line.lstrip(" "))
    indent = " " * (start + 2)
    command = _command(line)
    prose = line[: len(line) - len(command)].rstrip(" ") if command else line
    lines = list(_fill_lines(prose[start:].split(" "), " " * start, indent, "", width))
    if command:
        words = _WORD.findall(command)
        first = indent
        if prose.strip() in ("", "→"):
            lines, first = [], prose + " " * bool(prose.strip())
        lines += _fill_lines(words, first, indent, " \\", width)
    yield from lines


def _command(line: str) -> str:
    """Returns the command at the end of a line; "" without a command."""
    match = _COMMAND.search(line)
    words = _WORD.findall(match[0])[2:] if match else []
    return match[0] if match and all(map(_NON_WORD.search, words)) else ""


def _fill_lines(words: list[str], first: str, indent: str, joint: str, width: int) -> Iterator[str]:
    """Yields lines of words after an indent; each but the last ends in `joint`."""
    line, empty = first, True
    for number, word in enumerate(words):
        room = width - (len(joint) if number < len(words) - 1 else 0)
        if empty or columns(line) + 1 + columns(word) <= room:
            line += word if empty else f" {word}"
            empty = False
        else:
            yield line + joint
            line = indent + word
    yield line
