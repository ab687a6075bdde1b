"""JSON replies read piece by piece: never more than a small part of one as Python objects.

A list of Python objects takes ten to twenty times the bytes of its JSON. So the text is first
indexed (where its outer objects and arrays begin and end: a few vectorised passes over blocks),
and then parsed in runs of whole elements. What is small is parsed at once. A text that would take
many times its own size in memory (almost only brackets, or a huge value that
must be read at once) is refused.
"""

import re
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
import orjson

_BLOCK = 1 << 19
_RUN = 1 << 17
_AT_ONCE = 1 << 23
"""Longer values are parsed in pieces; facets, and bodies without their lists, are shorter."""

_DEEPEST = 7
_BYTES_EACH = 6
"""Text that an array or object takes at least, on the average of a large text."""

_FEW = 1 << 16
_ESCAPE = re.compile(rb"\\.", re.DOTALL)
_CUT = "\0cut"  # no key of a reply: it marks where a large array was cut out
_SPACE = b" \t\r\n"
_QUOTE, _OPEN, _CLOSE = 0x22, 0x7B, 0x7D
_CASE = 0x20  # turns [ and ] into { and }

_Index = npt.NDArray[np.uint32]


class MalformedError(ValueError):
    """The text is not JSON, was cut short, or cannot be read in pieces."""


class Pieces:
    """A large array, parsed as it is iterated: (document, depth, begin, end) of its text."""

    def __init__(self, document: "Document", depth: int, begin: int, end: int) -> None:
        self._document, self._depth, self._begin, self._end = document, depth, begin, end

    def __iter__(self) -> Iterator[Any]:
        """The elements one by one; large objects among them as `Document.value` gives them."""
        for run in self.runs():
            yield from run

    def runs(self) -> Iterator[list[Any]]:
        """The elements in lists, each out of at most about 128 kB of text."""
        return self._document.runs(self._depth, self._begin, self._end)


class Document:
    """A JSON text. MalformedError, at once or while it is read, where it is not JSON."""

    def __init__(self, text: bytes) -> None:
        if len(text) >= 1 << 32:
            msg = "it is too long"
            raise MalformedError(msg)
        self._text = text
        self._begins, self._ends = _containers(text)

    def root(self) -> Any:
        """The value of the whole text, see `value`."""
        begin = len(self._text) - len(self._text.lstrip(_SPACE))
        return self.value(1, begin, len(self._text.rstrip(_SPACE)))

    def value(self, depth: int, begin: int, end: int) -> Any:
        """The value of text[begin:end], which lies `depth` containers deep.

        Small ones are plain data; a large array is `Pieces`, and so are those in a large object.
        """
        text = self._text
        if end - begin <= _RUN or depth >= _DEEPEST:
            return _parsed(text[begin:end])
        if text[begin : begin + 1] == b"[":
            return Pieces(self, depth, begin, end)
        skeleton: list[bytes] = []
        large: list[Any] = []
        copied = begin
        for first, last in self._within(depth + 1, begin, end):
            if last - first > _RUN:
                skeleton += [text[copied:first], b'{"\\u0000cut":%d}' % len(large)]
                large.append(self.value(depth + 1, first, last))
                copied = last
        record = _parsed(b"".join([*skeleton, text[copied:end]]))
        if not isinstance(record, dict):
            return record
        for key, value in record.items():
            cut = value.get(_CUT) if isinstance(value, dict) else None
            if isinstance(cut, int) and 0 <= cut < len(large):
                record[key] = large[cut]
        return record

    def runs(self, depth: int, begin: int, end: int) -> Iterator[list[Any]]:
        """The elements of the array text[begin:end] in lists of some.

        Only runs of objects and arrays are distinguished: MalformedError where others are among them.
        """
        if next(self._within(depth + 1, begin, end), None) is None:
            yield _parsed(self._text[begin:end])
            return
        inside = begin + 1
        group = inside
        last = inside
        for first, close in self._within(depth + 1, begin, end):
            between = self._text[last:first].strip(_SPACE)
            if between != (b"" if last == inside else b","):
                msg = "an array has something else between its elements than a comma"
                raise MalformedError(msg)
            if close - first > _RUN:
                if last > group:
                    yield self._run(group, last)
                yield [self.value(depth + 1, first, close)]
                group = close
            elif close - group > _RUN and last > group:
                yield self._run(group, last)
                group = last
            last = close
        if last > group:
            yield self._run(group, last)
        if self._text[last : end - 1].strip(_SPACE) or self._text[end - 1 : end] != b"]":
            msg = "an array does not end after its last element"
            raise MalformedError(msg)

    def _run(self, begin: int, end: int) -> list[Any]:
        run: list[Any] = _parsed(b"[" + self._text[begin:end].strip(_SPACE + b",") + b"]")
        return run

    def _within(self, depth: int, begin: int, end: int) -> Iterator[tuple[int, int]]:
        """Begin and end of the containers at `depth` inside of text[begin:end], a few at a time."""
        begins, ends = self._begins[depth], self._ends[depth]
        first, last = np.searchsorted(begins, np.array((begin, end), dtype=np.uint32))
        for start in range(int(first), int(last), 4096):
            stop = min(start + 4096, int(last))
            yield from zip(begins[start:stop].tolist(), ends[start:stop].tolist(), strict=True)


def elements(value: Any) -> Iterable[Any]:
    """The elements of an array, large or small; none of anything else."""
    return value if isinstance(value, list | Pieces) else ()


def runs(value: Any) -> Iterable[list[Any]]:
    """The elements of an array in lists; none of anything else."""
    if isinstance(value, Pieces):
        return value.runs()
    return [value] if isinstance(value, list) and value else []


def _parsed(text: bytes) -> Any:
    if len(text) > _AT_ONCE:
        msg = f"a value of {len(text)} bytes is not made of lists"
        raise MalformedError(msg)
    try:
        return orjson.loads(text)
    except orjson.JSONDecodeError as error:
        raise MalformedError(str(error)) from None


def _containers(text: bytes) -> tuple[list[_Index], list[_Index]]:
    """By depth: where the outer containers begin, and one past where they end, both ascending."""
    begins: list[list[_Index]] = [[] for _ in range(_DEEPEST + 1)]
    ends: list[list[_Index]] = [[] for _ in range(_DEEPEST + 1)]
    depth, quoted = 0, False
    at = counted = 0
    while at < len(text):
        block = text[at : at + _BLOCK]
        if b"\\" in block:
            # An escape that the block's end would cut in two is taken whole.
            trailing = len(block) - len(block.rstrip(b"\\"))
            block = text[at : at + _BLOCK + trailing % 2]
            block = _ESCAPE.sub(b"__", block)
        depth, quoted = _scan(block, at, depth, quoted, begins, ends)
        at += len(block)
        counted += sum(len(found[-1]) for found in begins[1:])
        if counted > max(_FEW, len(text) // _BYTES_EACH):
            msg = "it is made of brackets, with next to nothing in them"
            raise MalformedError(msg)
    if depth or quoted:
        msg = "the text ends in the midst of a value"
        raise MalformedError(msg)
    return [_joined(found) for found in begins], [_joined(found) for found in ends]


def _scan(
    block: bytes,
    at: int,
    depth: int,
    quoted: bool,
    begins: list[list[_Index]],
    ends: list[list[_Index]],
) -> tuple[int, bool]:
    """Adds what one block of the text holds; depth and whether inside of a text, after it."""
    codes = np.frombuffer(block, dtype=np.uint8)
    folded = codes | _CASE
    opens = folded == _OPEN
    marks = np.flatnonzero(opens | (folded == _CLOSE))
    quotes = np.flatnonzero(codes == _QUOTE)
    inside = (np.searchsorted(quotes, marks) + int(quoted)) & 1
    marks = marks[inside == 0]
    opening = opens[marks]
    after = depth + np.cumsum(np.where(opening, 1, -1))
    if len(after):
        if after.min() < 0:
            msg = "more brackets are closed than were opened"
            raise MalformedError(msg)
        depth = int(after[-1])
    for level in range(1, _DEEPEST + 1):
        begins[level].append((at + marks[opening & (after == level)]).astype(np.uint32))
        ends[level].append((at + 1 + marks[~opening & (after == level - 1)]).astype(np.uint32))
    return depth, bool((len(quotes) + int(quoted)) & 1)


def _joined(found: list[_Index]) -> _Index:
    return np.concatenate(found) if found else np.empty(0, dtype=np.uint32)
