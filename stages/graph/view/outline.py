"""The kinematic tree as text, a line for each link and further dof, no wider than 100 columns."""

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from stages.graph.view.labels import (
    columns,
    counted,
    frames_on,
    is_origin,
    mobility,
    motions,
    rules,
    shortened,
    standing,
    totals,
)
from stages.robot.model import Joint, Robot
from stages.robot.printable import printable

WIDTH = 100
_RANGES = 24  # columns that the ranges keep, if they are so long
_GAPS = 10  # columns between the six cells of a line
_TRUNK = 24  # columns that the lines before a name take at most
_HEADER = ("link", "kg", "parts", "joint", "type")


@dataclass(frozen=True, slots=True)
class Row:
    """A link's line. `lasts`: for it and each link above, the root aside, whether it is the last child."""

    lasts: tuple[bool, ...]
    is_leaf: bool
    cells: tuple[str, str, str, str, str]
    ranges: tuple[str, ...]


def outline(robot: Robot) -> str:
    """The tree with masses, joints and ranges; then loops, frames and mobility."""
    sections = [
        [f"{shortened(robot.name, 24)}: {totals(robot)}", *_filled(standing(robot))],
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
    follows = rules(robot, room=20)
    links = {link.name: link for link in robot.links}
    base = f"({'fixed' if robot.base.fixed else 'free'} base)"
    waiting: list[tuple[Joint | None, tuple[bool, ...]]] = [(None, ())]
    while waiting:
        above, lasts = waiting.pop()
        link = robot.root if above is None else links[above.child]
        children = below[link.name]
        waiting += [(child, (*lasts, child is children[-1])) for child in reversed(children)]
        mass = "" if is_origin(robot, link) else f"{link.inertial.mass:.3g}"
        name, kind = (base, "") if above is None else (above.name, above.type)
        ranges = () if above is None else tuple(_ranges(above, follows))
        cells = (link.name, mass, str(len(link.parts) or ""), name, kind)
        yield Row(lasts, not children, cells, ranges)


def _ranges(joint: Joint, follows: Mapping[str, str]) -> Iterator[str]:
    """What each dof may do, and after it what it follows."""
    for dof, words in motions(joint):
        yield words
        if dof.name in follows:
            yield f"= {follows[dof.name]}"


def _table(rows: Sequence[Row]) -> Iterator[str]:
    step, widths = _widths(rows)
    yield _line(_HEADER, widths, "range")
    for row in rows:
        trunk = _trunk(row.lasts, step)
        name = trunk + shortened(row.cells[0], widths[0] - len(trunk))
        lines = _packed(row.ranges, WIDTH - _GAPS - sum(widths))
        yield _line((name, *row.cells[1:]), widths, lines[0] if lines else "")
        stem = _stem(row.lasts, step) + ("" if row.is_leaf else "│")
        for more in lines[1:]:
            yield _line((stem, "", "", "", ""), widths, more)


def _widths(rows: Sequence[Row]) -> tuple[int, list[int]]:
    """Columns of a level of the tree, and of each cell but the ranges: as much as there is room for."""
    table = [_HEADER, *(row.cells for row in rows)]
    widths = [max(len(cells[column]) for cells in table) for column in range(5)]
    ranges = min(_RANGES, max((len(text) for row in rows for text in row.ranges), default=0))
    room = WIDTH - ranges - _GAPS - widths[1] - widths[2] - widths[4]
    for step in (3, 2):
        widths[0] = max(4, *(len(_trunk(row.lasts, step)) + len(row.cells[0]) for row in rows))
        if widths[0] + widths[3] <= room:
            return step, widths
    step = max(1, min(2, _TRUNK // max(1, *(len(row.lasts) for row in rows))))
    widths[3] = min(widths[3], max(room * 2 // 5, room - widths[0]))
    widths[0] = room - widths[3]
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
        if text.startswith("= ") and lines and len(lines[-1]) + 2 + len(text) <= room:
            lines[-1] += f"  {text}"
        else:
            lines += textwrap.wrap(text, room, subsequent_indent="  ")
    return lines


def _line(cells: Sequence[str], widths: Sequence[int], ranges: str) -> str:
    name, mass, parts, joint, kind = cells
    line = (
        f"{name:<{widths[0]}}  {mass:>{widths[1]}}  {parts:>{widths[2]}}"
        f"  {shortened(joint, widths[3]):<{widths[3]}}  {kind:<{widths[4]}}  {ranges}"
    )
    return line.rstrip()


def _loops(robot: Robot) -> list[str]:
    """The mates that close loops, which links they join and how far they are from met."""
    lines = []
    for loop in robot.loops:
        head = f"loop {shortened(loop.name, 36)}: {loop.type}, mate {shortened(loop.mate.name, 32)}"
        ends = f"{shortened(loop.link_a, 28)} to {shortened(loop.link_b, 28)}"
        lines += _filled(f"{head}, {ends}, residual {loop.residual:.2g}")
    return lines


def _frames(robot: Robot) -> list[str]:
    lines: list[str] = []
    there = frames_on(robot)
    for link in robot.links:
        if link.name in there:
            names = [shortened(name, 40) for name in there[link.name]]
            head = f"{counted(len(names), 'frame')} on {shortened(link.name, 40)}"
            lines += _filled(f"{head}: {', '.join(names)}")
    return lines


def _mobility(robot: Robot) -> list[str]:
    lines = _filled(mobility(robot))
    for name, number in robot.mobility.redundant:
        what = f"{counted(number, 'condition')} of the loop {shortened(name, 40)}"
        lines += _filled(f"{what} {'say' if number > 1 else 'says'} nothing new (redundant)")
    return lines


def _filled(text: str) -> list[str]:
    """Lines of at most `WIDTH` columns, also where letters take two."""
    text = printable(text)
    return textwrap.wrap(text, WIDTH + len(text) - columns(text), subsequent_indent="    ")
