"""Writes the kinematic tree as text, with a line for each link and each further dof.

Names are never shortened, since people type them into their YAML. They are wrapped if a line has a limited
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
    base_line,
    frames_on,
    is_origin,
    mobility,
    motions,
    rules,
    totals_line,
)

_WIDE = 100  # columns; an outline within them has three columns for each level of the tree
_GAP = 2  # columns between the cells of a line
_HEADER = ("link", "kg", "parts", "joint", "type")

Cells = tuple[str, str, str, str, str]


@dataclass(frozen=True, slots=True)
class Columns:
    """The widths in an outline, in columns."""

    width: float
    """The largest width of a line."""

    trunk: int
    """The largest width of the tree's lines before a name."""

    link: int
    """The least width for the names of links, unless all are shorter."""

    joint: int
    """The least width for the names of joints, unless all are shorter."""

    ranges: int
    """The least width for ranges, unless all are shorter."""

    parts: bool
    """Whether there is room for the numbers of parts."""


WHOLE = Columns(math.inf, 22, 16, 14, 24, parts=True)
"""Columns of an outline without a largest width: no name is wrapped."""

NARROW = Columns(80, 14, 12, 10, 18, parts=False)
"""Columns of an outline for a terminal."""


@dataclass(frozen=True, slots=True)
class Row:
    """The content of a link's lines."""

    lasts: tuple[bool, ...]
    """For the link and its drawn ancestors, without the root, whether each is the last child of its
    parent."""

    is_leaf: bool
    cells: Cells
    ranges: tuple[str, ...]


def outline(robot: Robot, room: Columns = WHOLE) -> str:
    """Returns the tree with masses, joints and ranges; then loops, frames and mobility."""
    sections = [
        [f"{robot.name}: {totals_line(robot)}", base_line(robot)],
        _loops(robot),
        _frames(robot),
        _mobility(robot),
    ]
    head, *other_sections = [
        [part for line in lines for part in _indented(line, room.width)] for lines in sections
    ]
    parts = [head, list(_table(list(_rows(robot, room)), room)), *other_sections]
    return "\n\n".join("\n".join(part) for part in parts if part) + "\n"


def _rows(robot: Robot, room: Columns) -> Iterator[Row]:
    """Yields a row for each link, every subtree together."""
    joints_below: dict[str, list[Joint]] = {link.name: [] for link in robot.links}
    for joint in robot.joints:
        joints_below[joint.parent].append(joint)
    rule_of_dof = rules(robot)
    links = {link.name: link for link in robot.links}
    base = f"({'fixed' if robot.base.fixed else 'free'} base)"
    stack: list[tuple[Joint | None, tuple[bool, ...]]] = [(None, ())]
    while stack:
        joint_above, lasts = stack.pop()
        link = robot.root if joint_above is None else links[joint_above.child]
        children = joints_below[link.name]
        stack += [(child, (*lasts[-room.trunk :], child is children[-1])) for child in reversed(children)]
        mass = "" if is_origin(robot, link) else f"{link.inertial.mass:.3g}"
        name, kind = (base, "") if joint_above is None else (joint_above.name, joint_above.type)
        ranges = () if joint_above is None else tuple(_ranges(joint_above, rule_of_dof))
        parts = str(len(link.parts) or "") if room.parts else ""
        cells = (link.name, mass, parts, name, kind)
        yield Row(lasts, not children, cells, ranges)


def _ranges(joint: Joint, rule_of_dof: Mapping[str, str]) -> Iterator[str]:
    """Yields the range of each dof, followed by the rule that it follows."""
    for dof, words in motions(joint):
        yield words
        if dof.name in rule_of_dof:
            yield f"= {rule_of_dof[dof.name]}"


def _table(rows: Sequence[Row], room: Columns) -> Iterator[str]:
    step, widths = _widths(rows, room)
    yield _line(_header(room), widths, "range")
    for row in rows:
        trunk = _trunk(row.lasts, step, room.trunk)
        stem = _stem(row.lasts, step, room.trunk) + ("" if row.is_leaf else "│")
        indent = f"{stem} ".ljust(len(trunk))
        fits = columns(trunk + row.cells[0]) <= widths[0]
        names = [row.cells[0]] if fits else _pieces(row.cells[0], widths[0] - len(indent))
        joints = _pieces(row.cells[3], widths[3])
        ranges = _range_lines(row.ranges, room.width - sum(_with_gaps(widths)))
        first: Cells = (trunk + names[0], *row.cells[1:3], joints[0], row.cells[4])
        yield _line(first, widths, ranges[0] if ranges else "")
        for name, joint_piece, range_text in zip_longest(names[1:], joints[1:], ranges[1:], fillvalue=""):
            yield _line((indent + name if name else stem, "", "", joint_piece, ""), widths, range_text)


def _widths(rows: Sequence[Row], room: Columns) -> tuple[int, list[int]]:
    """Chooses the width of a level of the tree, and the width of each cell except the ranges, for the
    available room."""
    table = [_header(room), *(row.cells for row in rows)]
    widths = [max(columns(cells[column]) for cells in table) for column in range(5)]
    longest = max(map(columns, ["range", *(text for row in rows for text in row.ranges)]))
    other_widths = sum(_with_gaps([0, *widths[1:3], 0, widths[4]])) + 2 * _GAP
    available = int(min(room.width, _WIDE)) - other_widths - min(room.ranges, longest)
    for step in (3, 2):
        trunks = [len(_trunk(row.lasts, step, room.trunk)) for row in rows]
        widths[0] = max(4, *(trunk + columns(row.cells[0]) for trunk, row in zip(trunks, rows, strict=True)))
        if widths[0] + widths[3] <= available:
            return step, widths
    if math.isinf(room.width):
        return 2, widths
    step = max(1, min(2, room.trunk // max(1, *(len(row.lasts) for row in rows))))
    trunk = max(len(_trunk(row.lasts, step, room.trunk)) for row in rows)
    widths[3] = min(widths[3], max(available * 2 // 5, available - widths[0]))
    widths[0] = max(available - widths[3], trunk + room.link)
    widths[3] = min(widths[3], max(available - widths[0], room.joint))
    return step, widths


def _header(room: Columns) -> Cells:
    link, mass, parts, joint, kind = _HEADER
    return link, mass, parts if room.parts else "", joint, kind


def _with_gaps(widths: Sequence[int]) -> list[int]:
    """Returns the widths of cells with the gaps after them; empty cells have no gap."""
    return [width + _GAP if width else 0 for width in widths]


def _trunk(lasts: Sequence[bool], step: int, max_columns: int) -> str:
    """Returns the tree's lines before a name."""
    if not lasts:
        return ""
    branch = ("└" if lasts[-1] else "├") + "─ "[3 - step :]
    return _stem(lasts[:-1], step, max_columns) + branch


def _stem(lasts: Sequence[bool], step: int, max_columns: int) -> str:
    """Returns the tree's lines below a name, in at most `max_columns` columns; for a very deep tree only
    their end."""
    stem = "".join((" " if last else "│").ljust(step) for last in lasts[-max_columns:])
    return stem if len(stem) < max_columns else "…" + stem[len(stem) - max_columns + 2 :]


def _range_lines(texts: Sequence[str], room: float) -> list[str]:
    """Returns a line for each text; a rule ("= ...") follows its range in the same line if there is room."""
    lines: list[str] = []
    for text in texts:
        if text.startswith("= ") and lines and columns(lines[-1]) + 2 + columns(text) <= room:
            lines[-1] += f"  {text}"
        else:
            lines += _wrapped(text, room, "  ")
    return lines


def _pieces(name: str, room: float) -> list[str]:
    """Breaks a name into pieces of at most `room` columns, to be written below each other."""
    lines = [""]
    # It breaks after characters that join words, and anywhere in a word that is longer than a line.
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
    cells_with_width = [text for text, width in zip(texts, widths, strict=True) if width]
    return (" " * _GAP).join([*cells_with_width, ranges]).rstrip()


def _padded(text: str, width: int) -> str:
    return text + " " * (width - columns(text))


def _loops(robot: Robot) -> list[str]:
    """Returns a line for each loop: its mate, the links that it joins, and its closure error."""
    lines = []
    for loop in robot.loops:
        head = f"loop {loop.name}: {loop.type}, mate {loop.mate.name}"
        ends = f"{loop.link_a} to {loop.link_b}"
        lines.append(f"{head}, {ends}, residual {loop.residual:.2g}")
    return lines


def _frames(robot: Robot) -> list[str]:
    lines: list[str] = []
    by_link = frames_on(robot)
    for link in robot.links:
        if link.name in by_link:
            names = by_link[link.name]
            lines.append(f"{count(len(names), 'frame')} on {link.name}: {', '.join(names)}")
    return lines


def _mobility(robot: Robot) -> list[str]:
    lines = [mobility(robot)]
    for name, number in robot.mobility.redundant:
        conditions = f"{count(number, 'condition')} of the loop {name}"
        lines.append(f"{conditions} {'are' if number > 1 else 'is'} redundant")
    return lines


def _indented(text: str, width: float) -> list[str]:
    return _wrapped(printable(text), width, "    ")


def _wrapped(text: str, room: float, indent: str) -> list[str]:
    """Wraps a text into lines of at most `room` columns, also for letters of two columns; all lines but the
    first are indented."""
    lines = [""]
    for word in text.split():
        joined = f"{lines[-1]} {word}" if lines[-1].strip() else lines[-1] + word
        if columns(joined) <= room:
            lines[-1] = joined
        else:
            lines += [indent + piece for piece in _pieces(word, room - len(indent))]
    return lines if lines[0] else lines[1:]
