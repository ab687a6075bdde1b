"""Reads JSON replies piece by piece: never more than a small part is in memory as Python objects.

A list of Python objects takes ten to twenty times the bytes of its JSON. So the text is first indexed (the
beginnings and ends of its outer objects and arrays, in a few vectorised passes over blocks), and then parsed
in runs of whole elements. Small values are parsed at once. A text that would take many times its own size in
memory (almost only brackets, or a huge value that must be read at once) is refused.
"""

import re
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
import orjson

_BLOCK = 1 << 19
"""Size of the blocks that are indexed one after the other [bytes]."""

_RUN_SIZE = 1 << 17
"""Size of the text whose elements are parsed together [bytes]."""

_MAX_PARSED = 1 << 23
"""Length up to which a value is parsed at once [bytes]; facets, and bodies without their lists, are
shorter."""

_MAX_DEPTH = 7
"""Depth of the innermost containers that are indexed."""

_MIN_MEAN_BYTES = 6
"""Smallest mean length [bytes] of the arrays and objects of a large text."""

_FREE_CONTAINERS = 1 << 16
"""Number of containers that any text may have, however short."""

_ESCAPE = re.compile(rb"\\.", re.DOTALL)
_CUT_KEY = "\0cut"  # no key of a reply: it marks where a large array was cut out
_SPACE = b" \t\r\n"
_QUOTE, _OPEN, _CLOSE = 0x22, 0x7B, 0x7D
_FOLD_BIT = 0x20  # turns [ and ] into { and }

_Index = npt.NDArray[np.uint32]


class MalformedError(ValueError):
    """The error that a text is not JSON, was cut short, or cannot be read in pieces."""


class Pieces:
    """A large array, parsed as it is iterated: (document, depth, begin, end) of its text."""

    def __init__(self, document: "Document", depth: int, begin: int, end: int) -> None:
        self._document, self._depth, self._begin, self._end = document, depth, begin, end

    def __iter__(self) -> Iterator[Any]:
        """Yields the elements one by one; large objects among them as `Document.value` returns them."""
        for run in self.runs():
            yield from run

    def runs(self) -> Iterator[list[Any]]:
        """Yields the elements in lists, each from at most about 128 kB of text."""
        return self._document.runs(self._depth, self._begin, self._end)


class Document:
    """A JSON text. It raises MalformedError, at once or while it is read, if it is not JSON."""

    def __init__(self, text: bytes) -> None:
        if len(text) >= 1 << 32:
            msg = "it is too long"
            raise MalformedError(msg)
        self._text = text
        self._begins, self._ends = _containers(text)

    def root(self) -> Any:
        """Returns the value of the whole text, see `value`."""
        begin = len(self._text) - len(self._text.lstrip(_SPACE))
        return self.value(1, begin, len(self._text.rstrip(_SPACE)))

    def value(self, depth: int, begin: int, end: int) -> Any:
        """Returns the value of text[begin:end], which is `depth` containers deep.

        Small values are plain data; a large array is `Pieces`, and so are the large arrays in a large object.
        """
        text = self._text
        if end - begin <= _RUN_SIZE or depth >= _MAX_DEPTH:
            return _parse(text[begin:end])
        if text[begin : begin + 1] == b"[":
            return Pieces(self, depth, begin, end)
        skeleton: list[bytes] = []
        large_values: list[Any] = []
        copied = begin
        for first, last in self._within(depth + 1, begin, end):
            if last - first > _RUN_SIZE:
                skeleton += [text[copied:first], b'{"\\u0000cut":%d}' % len(large_values)]
                large_values.append(self.value(depth + 1, first, last))
                copied = last
        record = _parse(b"".join([*skeleton, text[copied:end]]))
        if not isinstance(record, dict):
            return record
        for key, value in record.items():
            cut = value.get(_CUT_KEY) if isinstance(value, dict) else None
            if isinstance(cut, int) and 0 <= cut < len(large_values):
                record[key] = large_values[cut]
        return record

    def runs(self, depth: int, begin: int, end: int) -> Iterator[list[Any]]:
        """Yields the elements of the array text[begin:end] in lists.

        Only runs of objects and arrays are distinguished: MalformedError is raised if other values are among
        them.
        """
        if next(self._within(depth + 1, begin, end), None) is None:
            yield _parse(self._text[begin:end])
            return
        first_element = begin + 1
        group = first_element
        last = first_element
        for first, close in self._within(depth + 1, begin, end):
            separator = self._text[last:first].strip(_SPACE)
            if separator != (b"" if last == first_element else b","):
                msg = "an array has something else between its elements than a comma"
                raise MalformedError(msg)
            if close - first > _RUN_SIZE:
                if last > group:
                    yield self._run(group, last)
                yield [self.value(depth + 1, first, close)]
                group = close
            elif close - group > _RUN_SIZE and last > group:
                yield self._run(group, last)
                group = last
            last = close
        if last > group:
            yield self._run(group, last)
        if self._text[last : end - 1].strip(_SPACE) or self._text[end - 1 : end] != b"]":
            msg = "an array does not end after its last element"
            raise MalformedError(msg)

    def _run(self, begin: int, end: int) -> list[Any]:
        run: list[Any] = _parse(b"[" + self._text[begin:end].strip(_SPACE + b",") + b"]")
        return run

    def _within(self, depth: int, begin: int, end: int) -> Iterator[tuple[int, int]]:
        """Yields begin and end of the containers at `depth` inside of text[begin:end], a few at a time."""
        begins, ends = self._begins[depth], self._ends[depth]
        first, last = np.searchsorted(begins, np.array((begin, end), dtype=np.uint32))
        for start in range(int(first), int(last), 4096):
            stop = min(start + 4096, int(last))
            yield from zip(begins[start:stop].tolist(), ends[start:stop].tolist(), strict=True)


def elements(value: Any) -> Iterable[Any]:
    """Returns the elements of an array, large or small; empty for anything else."""
    return value if isinstance(value, list | Pieces) else ()


def runs(value: Any) -> Iterable[list[Any]]:
    """Returns the elements of an array in lists; empty for anything else."""
    if isinstance(value, Pieces):
        return value.runs()
    return [value] if isinstance(value, list) and value else []


def _parse(text: bytes) -> Any:
    if len(text) > _MAX_PARSED:
        msg = f"a value of {len(text)} bytes is not made of lists"
        raise MalformedError(msg)
    try:
        return orjson.loads(text)
    except orjson.JSONDecodeError as error:
        raise MalformedError(str(error)) from None


def _containers(text: bytes) -> tuple[list[_Index], list[_Index]]:
    """Returns the begins of the outer containers by depth, and the positions after their ends, both
    ascending."""
    begins: list[list[_Index]] = [[] for _ in range(_MAX_DEPTH + 1)]
    ends: list[list[_Index]] = [[] for _ in range(_MAX_DEPTH + 1)]
    depth, quoted = 0, False
    position = container_count = 0
    while position < len(text):
        block = text[position : position + _BLOCK]
        if b"\\" in block:
            # An escape that the block's end would cut in two is taken whole.
            trailing = len(block) - len(block.rstrip(b"\\"))
            block = text[position : position + _BLOCK + trailing % 2]
            block = _ESCAPE.sub(b"__", block)
        depth, quoted = _scan(block, position, depth, quoted, begins, ends)
        position += len(block)
        container_count += sum(len(pieces[-1]) for pieces in begins[1:])
        if container_count > max(_FREE_CONTAINERS, len(text) // _MIN_MEAN_BYTES):
            msg = "it is made of brackets, with next to nothing in them"
            raise MalformedError(msg)
    if depth or quoted:
        msg = "the text ends in the midst of a value"
        raise MalformedError(msg)
    return [_joined(pieces) for pieces in begins], [_joined(pieces) for pieces in ends]


def _scan(
    block: bytes,
    offset: int,
    depth: int,
    quoted: bool,
    begins: list[list[_Index]],
    ends: list[list[_Index]],
) -> tuple[int, bool]:
    """Adds the containers of a block of the text; returns the depth after it, and whether it ends inside a
    text."""
    codes = np.frombuffer(block, dtype=np.uint8)
    folded = codes | _FOLD_BIT
    opens = folded == _OPEN
    marks = np.flatnonzero(opens | (folded == _CLOSE))
    # A mark after an odd number of quotes is inside a text.
    quotes = np.flatnonzero(codes == _QUOTE)
    is_quoted = (np.searchsorted(quotes, marks) + int(quoted)) & 1
    marks = marks[is_quoted == 0]
    opening = opens[marks]
    depth_after = depth + np.cumsum(np.where(opening, 1, -1))
    if len(depth_after):
        if depth_after.min() < 0:
            msg = "more brackets are closed than were opened"
            raise MalformedError(msg)
        depth = int(depth_after[-1])
    for level in range(1, _MAX_DEPTH + 1):
        begins[level].append((offset + marks[opening & (depth_after == level)]).astype(np.uint32))
        ends[level].append((offset + 1 + marks[~opening & (depth_after == level - 1)]).astype(np.uint32))
    return depth, bool((len(quotes) + int(quoted)) & 1)


def _joined(pieces: list[_Index]) -> _Index:
    return np.concatenate(pieces) if pieces else np.empty(0, dtype=np.uint32)
