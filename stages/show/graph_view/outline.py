"""The kinematic tree as text, a line for each link and further dof.

Names are never shortened: people type them into their YAML. They are wrapped where a line has a
width, as in a terminal, and no room for them.
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest

from linkwright.stages.robot.model.robot import Joint, Robot
from linkwright.stages.robot.text.plural import count
from linkwright.stages.robot.text.printable import columns, printable
from linkwright.stages.show.graph_view.labels import (
    frames_on,
    is_origin,
    mobility,
    motions,
    rules,
    standing,
    totals,
)

_WIDE = 100  # columns up to which the lines of the tree take three columns a level
_GAP = 2  # columns between the cells of a line
_HEADER = ("link", "kg", "parts", "joint", "type")

Cells = tuple[str, str, str, str, str]


@dataclass(frozen=True, slots=True)
class Columns:
    """The columns of an outline: of a line at most, of the lines before a name at most, and those that the
    names of a link and of a joint and the ranges keep, if they are so long. `parts`: whether there is room
    for their number."""

    width: float
    trunk: int
    link: int
    joint: int
    ranges: int
    parts: bool


WHOLE = Columns(math.inf, 22, 16, 14, 24, parts=True)
"""No name is wrapped."""

NARROW = Columns(80, 14, 12, 10, 18, parts=False)
"""For a terminal."""


@dataclass(frozen=True, slots=True)
class Row:
    """A link's lines. `lasts`: for it and the links above, the root aside and as far up as is drawn, whether
    it is the last child."""

    lasts: tuple[bool, ...]
    is_leaf: bool
    cells: Cells
    ranges: tuple[str, ...]


def outline(robot: Robot, room: Columns = WHOLE) -> str:
    """The tree with masses, joints and ranges; then loops, frames and mobility."""
    sections = [
        [f"{robot.name}: {totals(robot)}", standing(robot)],
        _loops(robot),
        _frames(robot),
        _mobility(robot),
    ]
    head, *rest = [[part for line in lines for part in _filled(line, room.width)] for lines in sections]
    parts = [head, list(_table(list(_rows(robot, room)), room)), *rest]
    return "\n\n".join("\n".join(part) for part in parts if part) + "\n"


def _rows(robot: Robot, room: Columns) -> Iterator[Row]:
    """A row for each link, every subtree together."""
    below: dict[str, list[Joint]] = {link.name: [] for link in robot.links}
    for joint in robot.joints:
        below[joint.parent].append(joint)
    follows = rules(robot)
    links = {link.name: link for link in robot.links}
    base = f"({'fixed' if robot.base.fixed else 'free'} base)"
    waiting: list[tuple[Joint | None, tuple[bool, ...]]] = [(None, ())]
    while waiting:
        above, lasts = waiting.pop()
        link = robot.root if above is None else links[above.child]
        children = below[link.name]
        waiting += [(child, (*lasts[-room.trunk :], child is children[-1])) for child in reversed(children)]
        mass = "" if is_origin(robot, link) else f"{link.inertial.mass:.3g}"
        name, kind = (base, "") if above is None else (above.name, above.type)
        ranges = () if above is None else tuple(_ranges(above, follows))
        parts = str(len(link.parts) or "") if room.parts else ""
        cells = (link.name, mass, parts, name, kind)
        yield Row(lasts, not children, cells, ranges)


def _ranges(joint: Joint, follows: Mapping[str, str]) -> Iterator[str]:
    """The range of each dof, and after it the rule that it follows."""
    for dof, words in motions(joint):
        yield words
        if dof.name in follows:
            yield f"= {follows[dof.name]}"


def _table(rows: Sequence[Row], room: Columns) -> Iterator[str]:
    step, widths = _widths(rows, room)
    yield _line(_header(room), widths, "range")
    for row in rows:
        trunk = _trunk(row.lasts, step, room.trunk)
        stem = _stem(row.lasts, step, room.trunk) + ("" if row.is_leaf else "│")
        below = f"{stem} ".ljust(len(trunk))
        fits = columns(trunk + row.cells[0]) <= widths[0]
        names = [row.cells[0]] if fits else _broken(row.cells[0], widths[0] - len(below))
        joints = _broken(row.cells[3], widths[3])
        ranges = _packed(row.ranges, room.width - sum(_with_gaps(widths)))
        first: Cells = (trunk + names[0], *row.cells[1:3], joints[0], row.cells[4])
        yield _line(first, widths, ranges[0] if ranges else "")
        for name, joint, more in zip_longest(names[1:], joints[1:], ranges[1:], fillvalue=""):
            yield _line((below + name if name else stem, "", "", joint, ""), widths, more)


def _widths(rows: Sequence[Row], room: Columns) -> tuple[int, list[int]]:
    """The columns of a level of the tree, and those of each cell but the ranges, by the room there is."""
    table = [_header(room), *(row.cells for row in rows)]
    widths = [max(columns(cells[column]) for cells in table) for column in range(5)]
    longest = max(map(columns, ["range", *(text for row in rows for text in row.ranges)]))
    others = sum(_with_gaps([0, *widths[1:3], 0, widths[4]])) + 2 * _GAP
    left = int(min(room.width, _WIDE)) - others - min(room.ranges, longest)
    for step in (3, 2):
        trunks = [len(_trunk(row.lasts, step, room.trunk)) for row in rows]
        widths[0] = max(4, *(trunk + columns(row.cells[0]) for trunk, row in zip(trunks, rows, strict=True)))
        if widths[0] + widths[3] <= left:
            return step, widths
    if math.isinf(room.width):
        return 2, widths
    step = max(1, min(2, room.trunk // max(1, *(len(row.lasts) for row in rows))))
    trunk = max(len(_trunk(row.lasts, step, room.trunk)) for row in rows)
    widths[3] = min(widths[3], max(left * 2 // 5, left - widths[0]))
    widths[0] = max(left - widths[3], trunk + room.link)
    widths[3] = min(widths[3], max(left - widths[0], room.joint))
    return step, widths


def _header(room: Columns) -> Cells:
    link, mass, parts, joint, kind = _HEADER
    return link, mass, parts if room.parts else "", joint, kind


def _with_gaps(widths: Sequence[int]) -> list[int]:
    """The widths of cells, each with the gap after it; no gap after a cell without a width."""
    return [width + _GAP if width else 0 for width in widths]


def _trunk(lasts: Sequence[bool], step: int, most: int) -> str:
    """The lines before a name."""
    if not lasts:
        return ""
    branch = ("└" if lasts[-1] else "├") + "─ "[3 - step :]
    return _stem(lasts[:-1], step, most) + branch


def _stem(lasts: Sequence[bool], step: int, most: int) -> str:
    """The lines below a name, in `most` columns; of a very deep tree only their end."""
    stem = "".join((" " if last else "│").ljust(step) for last in lasts[-most:])
    return stem if len(stem) < most else "…" + stem[len(stem) - most + 2 :]


def _packed(texts: Sequence[str], room: float) -> list[str]:
    """A line for each text, but what a dof follows ("= ...") beside its range where there is room."""
    lines: list[str] = []
    for text in texts:
        if text.startswith("= ") and lines and columns(lines[-1]) + 2 + columns(text) <= room:
            lines[-1] += f"  {text}"
        else:
            lines += _wrapped(text, room, "  ")
    return lines


def _broken(name: str, room: float) -> list[str]:
    """A name in pieces of at most `room` columns, which make it again as they stand, one below the other."""
    lines = [""]
    # After what joins words, and anywhere in a word that is longer than a line.
    for word in re.findall(r"[^_.\-/]*[_.\-/]|[^_.\-/]+", printable(name)) or [""]:
        pieces = [word] if columns(word) <= room else list(word)
        for piece in pieces:
            if columns(lines[-1] + piece) > room:
                lines.append("")
            lines[-1] += piece
    return lines


def _line(cells: Cells, widths: Sequence[int], ranges: str) -> str:
    name, mass, parts, joint, kind = cells
    right = mass.rjust(widths[1]), parts.rjust(widths[2])
    texts = _padded(name, widths[0]), *right, _padded(joint, widths[3]), kind.ljust(widths[4])
    shown = [text for text, width in zip(texts, widths, strict=True) if width]
    return (" " * _GAP).join([*shown, ranges]).rstrip()


def _padded(text: str, width: int) -> str:
    return text + " " * (width - columns(text))


def _loops(robot: Robot) -> list[str]:
    """The mates that close loops, the links that they join, and their closure errors."""
    lines = []
    for loop in robot.loops:
        head = f"loop {loop.name}: {loop.type}, mate {loop.mate.name}"
        ends = f"{loop.link_a} to {loop.link_b}"
        lines.append(f"{head}, {ends}, residual {loop.residual:.2g}")
    return lines


def _frames(robot: Robot) -> list[str]:
    lines: list[str] = []
    there = frames_on(robot)
    for link in robot.links:
        if link.name in there:
            names = there[link.name]
            lines.append(f"{count(len(names), 'frame')} on {link.name}: {', '.join(names)}")
    return lines


def _mobility(robot: Robot) -> list[str]:
    lines = [mobility(robot)]
    for name, number in robot.mobility.redundant:
        what = f"{count(number, 'condition')} of the loop {name}"
        lines.append(f"{what} {'are' if number > 1 else 'is'} redundant")
    return lines


def _filled(text: str, width: float) -> list[str]:
    return _wrapped(printable(text), width, "    ")


def _wrapped(text: str, room: float, indent: str) -> list[str]:
    """Lines of at most `room` columns, also where letters take two; all but the first are indented."""
    lines = [""]
    for word in text.split():
        joined = f"{lines[-1]} {word}" if lines[-1].strip() else lines[-1] + word
        if columns(joined) <= room:
            lines[-1] = joined
        else:
            lines += [indent + piece for piece in _broken(word, room - len(indent))]
    return lines if lines[0] else lines[1:]
