"""The facts of CMake, command by command, and of any other text, line by line."""

import re
from collections import Counter
from collections.abc import Iterator

from linkwright.stages.validate.rewritten.facts import Place, Unparsable, Value, words

_COMMAND = re.compile(r"(\w+)\s*\(([^()]*)\)")
_COMMENT = re.compile(r"#[^\n]*")


def cmake_facts(data: bytes) -> Iterator[tuple[Place, Value]]:
    """Each word of each command; the order of words is not a fact."""
    text = _COMMENT.sub("", _decoded(data))
    rest = _COMMAND.sub("", text).split()
    if rest:
        raise Unparsable(f"has what is not a command: {' '.join(rest)[:60]}")
    seen: Counter[str] = Counter()
    for command, inside in _COMMAND.findall(text):
        arguments = tuple(word.strip('"') for word in inside.split())
        name = f"{command.lower()} {arguments[0]}" if len(arguments) > 1 else command.lower()
        seen[name] += 1
        path = (name, str(seen[name]))
        yield Place((*path, ""), name, ""), True
        for number, word in enumerate(arguments):
            # The first says what a command is about: the name of a project, what is installed.
            key = word if number else "first"
            yield Place((*path, key), name, word if number else ""), word if not number else True


def text_facts(data: bytes) -> Iterator[tuple[Place, Value]]:
    """Each line that is neither empty nor a comment, as texts and numbers."""
    lines = [line.split() for line in _decoded(data).splitlines()]
    kept = [line for line in lines if line and not line[0].startswith("#")]
    for number, line in enumerate(kept, 1):
        yield Place((str(number),), f"line {number}", ""), tuple(map(_word, line))


def _word(word: str) -> Value:
    # Whole numbers and real ones are one kind here.
    value = words(word)
    return value[0] if isinstance(value, tuple) else value


def _decoded(data: bytes) -> str:
    try:
        return data.decode()
    except UnicodeDecodeError:
        raise Unparsable("is not text") from None
