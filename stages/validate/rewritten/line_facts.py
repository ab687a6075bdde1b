"""Reads the facts of CMake, command by command, and of any other text, line by line."""

import re
from collections import Counter
from collections.abc import Iterator

from linkwright.stages.validate.rewritten.facts import Place, Unparsable, Value, words

_COMMAND = re.compile(r"(\w+)\s*\(([^()]*)\)")
_COMMENT = re.compile(r"#[^\n]*")


def cmake_facts(data: bytes) -> Iterator[tuple[Place, Value]]:
    """Yields each word of each command. The order of words is not a fact."""
    text = _COMMENT.sub("", _decoded(data))
    text_outside_commands = _COMMAND.sub("", text).split()
    if text_outside_commands:
        raise Unparsable(f"has what is not a command: {' '.join(text_outside_commands)[:60]}")
    command_counts: Counter[str] = Counter()
    for command, arguments_text in _COMMAND.findall(text):
        arguments = tuple(word.strip('"') for word in arguments_text.split())
        name = f"{command.lower()} {arguments[0]}" if len(arguments) > 1 else command.lower()
        command_counts[name] += 1
        path = (name, str(command_counts[name]))
        yield Place((*path, ""), name, ""), True
        for number, word in enumerate(arguments):
            # The first word is the subject of a command, such as the name of a project or the kind of target
            # to install.
            key = word if number else "first"
            yield Place((*path, key), name, word if number else ""), word if not number else True


def text_facts(data: bytes) -> Iterator[tuple[Place, Value]]:
    """Yields each line that is neither empty nor a comment, as texts and numbers."""
    lines = [line.split() for line in _decoded(data).splitlines()]
    fact_lines = [line for line in lines if line and not line[0].startswith("#")]
    for number, line in enumerate(fact_lines, 1):
        yield Place((str(number),), f"line {number}", ""), tuple(map(_word, line))


def _word(word: str) -> Value:
    # Integers and real numbers are not told apart here.
    value = words(word)
    return value[0] if isinstance(value, tuple) else value


def _decoded(data: bytes) -> str:
    try:
        return data.decode()
    except UnicodeDecodeError:
        raise Unparsable("is not text") from None
