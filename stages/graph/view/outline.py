"""The kinematic tree as text, a line for each link and further dof, no wider than 100 columns.

Names are wrapped where there is no room, never shortened: people type them into their YAML.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest

from stages.graph.view.labels import (
    columns,
    frames_on,
    is_origin,
    mobility,
    motions,
    rules,
    standing,
    totals,
)
from stages.robot.model import Joint, Robot
from stages.robot.plural import count
from stages.robot.printable import printable

WIDTH = 100
_RANGES = 24  # columns that the ranges keep, if they are so long
_GAPS = 10  # columns between the six cells of a line
_TRUNK = 22  # columns that the lines before a name take at most
_NAME, _JOINT = 16, 14  # columns that the names of a link and of a joint keep
_HEADER = ("link", "kg", "parts", "joint", "type")

Cells = tuple[str, str, str, str, str]


@dataclass(frozen=True, slots=True)
class Row:
    """A link's lines. `lasts`: for it and the links above, the root aside and as far up as is drawn, whether
    it is the last child."""

    lasts: tuple[bool, ...]
    is_leaf: bool
    cells: Cells
    ranges: tuple[str, ...]


def outline(robot: Robot) -> str:
    """The tree with masses, joints and ranges; then loops, frames and mobility."""
    sections = [
        _filled(f"{robot.name}: {totals(robot)}") + _filled(standing(robot)),
        list(_table(list(_rows(robot)))),
        _loops(robot),
        _frames(robot),
        _mobility(robot),
    ]
    return "\n\n".join("\n".join(section) for section in sections if section) + "\n"


def _rows(robot: Robot) -> Iterator[Row]:
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
        waiting += [(child, (*lasts[-_TRUNK:], child is children[-1])) for child in reversed(children)]
        mass = "" if is_origin(robot, link) else f"{link.inertial.mass:.3g}"
        name, kind = (base, "") if above is None else (above.name, above.type)
        ranges = () if above is None else tuple(_ranges(above, follows))
        cells = (link.name, mass, str(len(link.parts) or ""), name, kind)
        yield Row(lasts, not children, cells, ranges)


def _ranges(joint: Joint, follows: Mapping[str, str]) -> Iterator[str]:
    """The range of each dof, and after it the rule that it follows."""
    for dof, words in motions(joint):
        yield words
        if dof.name in follows:
            yield f"= {follows[dof.name]}"


def _table(rows: Sequence[Row]) -> Iterator[str]:
    step, widths = _widths(rows)
    yield _line(_HEADER, widths, "range")
    for row in rows:
        trunk = _trunk(row.lasts, step)
        stem = _stem(row.lasts, step) + ("" if row.is_leaf else "│")
        below = f"{stem} ".ljust(len(trunk))
        fits = columns(trunk + row.cells[0]) <= widths[0]
        names = [row.cells[0]] if fits else _broken(row.cells[0], widths[0] - len(below))
        joints = _broken(row.cells[3], widths[3])
        ranges = _packed(row.ranges, WIDTH - _GAPS - sum(widths))
        first: Cells = (trunk + names[0], *row.cells[1:3], joints[0], row.cells[4])
        yield _line(first, widths, ranges[0] if ranges else "")
        for name, joint, more in zip_longest(names[1:], joints[1:], ranges[1:], fillvalue=""):
            yield _line((below + name if name else stem, "", "", joint, ""), widths, more)


def _widths(rows: Sequence[Row]) -> tuple[int, list[int]]:
    """The columns of a level of the tree, and those of each cell but the ranges, by the room there is."""
    table = [_HEADER, *(row.cells for row in rows)]
    widths = [max(columns(cells[column]) for cells in table) for column in range(5)]
    ranges = min(_RANGES, max(map(columns, ["range", *(text for row in rows for text in row.ranges)])))
    room = WIDTH - ranges - _GAPS - widths[1] - widths[2] - widths[4]
    for step in (3, 2):
        widths[0] = max(4, *(len(_trunk(row.lasts, step)) + columns(row.cells[0]) for row in rows))
        if widths[0] + widths[3] <= room:
            return step, widths
    step = max(1, min(2, _TRUNK // max(1, *(len(row.lasts) for row in rows))))
    trunk = max(len(_trunk(row.lasts, step)) for row in rows)
    widths[3] = min(widths[3], max(room * 2 // 5, room - widths[0]))
    widths[0] = max(room - widths[3], trunk + _NAME)
    widths[3] = min(widths[3], max(room - widths[0], _JOINT))
    return step, widths


def _trunk(lasts: Sequence[bool], step: int) -> str:
    """The lines before a name."""
    if not lasts:
        return ""
    branch = ("└" if lasts[-1] else "├") + "─ "[3 - step :]
    return _stem(lasts[:-1], step) + branch


def _stem(lasts: Sequence[bool], step: int) -> str:
    """The lines below a name; of a very deep tree only their end."""
    stem = "".join((" " if last else "│").ljust(step) for last in lasts[-_TRUNK:])
    return stem if len(stem) < _TRUNK else "…" + stem[len(stem) - _TRUNK + 2 :]


def _packed(texts: Sequence[str], room: int) -> list[str]:
    """A line for each text, but what a dof follows ("= ...") beside its range where there is room."""
    lines: list[str] = []
    for text in texts:
        if text.startswith("= ") and lines and columns(lines[-1]) + 2 + columns(text) <= room:
            lines[-1] += f"  {text}"
        else:
            lines += _wrapped(text, room, "  ")
    return lines


def _broken(name: str, room: int) -> list[str]:
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
    line = (
        f"{_padded(name, widths[0])}  {mass:>{widths[1]}}  {parts:>{widths[2]}}"
        f"  {_padded(joint, widths[3])}  {kind:<{widths[4]}}  {ranges}"
    )
    return line.rstrip()


def _padded(text: str, width: int) -> str:
    return text + " " * (width - columns(text))


def _loops(robot: Robot) -> list[str]:
    """The mates that close loops, the links that they join, and their closure errors."""
    lines = []
    for loop in robot.loops:
        head = f"loop {loop.name}: {loop.type}, mate {loop.mate.name}"
        ends = f"{loop.link_a} to {loop.link_b}"
        lines += _filled(f"{head}, {ends}, residual {loop.residual:.2g}")
    return lines


def _frames(robot: Robot) -> list[str]:
    lines: list[str] = []
    there = frames_on(robot)
    for link in robot.links:
        if link.name in there:
            names = there[link.name]
            lines += _filled(f"{count(len(names), 'frame')} on {link.name}: {', '.join(names)}")
    return lines


def _mobility(robot: Robot) -> list[str]:
    lines = _filled(mobility(robot))
    for name, number in robot.mobility.redundant:
        what = f"{count(number, 'condition')} of the loop {name}"
        lines += _filled(f"{what} {'are' if number > 1 else 'is'} redundant")
    return lines


def _filled(text: str) -> list[str]:
    return _wrapped(printable(text), WIDTH, "    ")


def _wrapped(text: str, room: int, indent: str) -> list[str]:
    """Lines of at most `room` columns, also where letters take two; all but the first are indented."""
    lines = [""]
    for word in text.split():
        joined = f"{lines[-1]} {word}" if lines[-1].strip() else lines[-1] + word
        if columns(joined) <= room:
            lines[-1] = joined
        else:
            lines += [indent + piece for piece in _broken(word, room - len(indent))]
    return lines if lines[0] else lines[1:]
