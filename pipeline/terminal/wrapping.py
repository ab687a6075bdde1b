"""Wraps the lines of messages to the width of a terminal. Imports nothing heavy.

What is to be pasted can still be pasted: no word is broken, YAML in braces may have several lines, and a
command goes on after a backslash.
"""

import re
from collections.abc import Iterator

from linkwright.stages.robot.text.printable import columns

_COMMAND = re.compile(r"(?:^|(?<=[→:] ))linkwright(?: (?:'[^']*'|\"[^\"]*\"|[^\s'\"])+)+$")
"""What may be a command, at the end of a line."""

_WORD = re.compile(r"(?:'[^']*'|\"[^\"]*\"|[^\s'\"])+")
"""A word of a command, with the quotes of a shell."""

_TYPED = re.compile(r"[^\w]")
"""What a word of a command has, and one of a sentence has not, but for those after `linkwright`."""


def wrapped(text: str, width: int) -> str:
    """`text` with lines of at most `width` columns, but for words that are longer."""
    return "\n".join(part for line in text.split("\n") for part in _parts(line, width))


def _parts(line: str, width: int) -> Iterator[str]:
    """A line in parts; all but the first are indented by two more columns."""
    if columns(line) <= width:
        yield line
        return
    start = len(line) - len(line.lstrip(" "))
    indent = " " * (start + 2)
    command = _command(line)
    prose = line[: len(line) - len(command)].rstrip(" ") if command else line
    lines = list(_filled(prose[start:].split(" "), " " * start, indent, "", width))
    if command:
        words = _WORD.findall(command)
        first = indent
        if prose.strip() in ("", "→"):
            lines, first = [], prose + " " * bool(prose.strip())
        lines += _filled(words, first, indent, " \\", width)
    yield from lines


def _command(line: str) -> str:
    """The command at the end of a line; "" for none."""
    found = _COMMAND.search(line)
    words = _WORD.findall(found[0])[2:] if found else []
    return found[0] if found and all(map(_TYPED.search, words)) else ""


def _filled(words: list[str], first: str, indent: str, joint: str, width: int) -> Iterator[str]:
    """Lines of words after an indent; each but the last ends in `joint`."""
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
