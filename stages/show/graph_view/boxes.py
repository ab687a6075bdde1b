"""Lays out the boxes of the picture: the lines of a link and of the joint to its parent, and their size."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from linkwright.stages.robot.model.robot import Joint, Link, Loop, Robot
from linkwright.stages.robot.text.plural import count
from linkwright.stages.show.graph_view.canvas import fitted, text_width
from linkwright.stages.show.graph_view.labels import (
    frames_on,
    is_origin,
    kilograms,
    motions,
    part_names,
    rules,
)

ROOM = 190.0  # largest width of a name [px]
ROW, PAD, MARK = 14.0, 7.0, 14.0  # height of a row, space around the rows, width of a row's mark [px]
LABEL, LINE = 18.0, 13.0  # heights of a joint's name above its edge, and of each line below [px]
MAX_SHOWN = 3  # largest number of rows for parts, and for frames, in a box

Kind = Literal["name", "plain", "part", "frame", "loop"]


@dataclass(frozen=True, slots=True)
class BoxRow:
    """A line of a box."""

    kind: Kind
    text: str
    full: str = ""
    """The tooltip."""

    loop: int = 0
    """The index of the loop that a row of the kind `loop` marks."""

    @property
    def width(self) -> float:
        mark = MARK if self.kind in ("frame", "loop") else 0.0
        return mark + text_width(self.text, SIZES[self.kind], bold=self.kind == "name")


SIZES: Mapping[Kind, float] = {"name": 12.0, "plain": 10.0, "part": 9.5, "frame": 10.0, "loop": 10.0}


@dataclass(frozen=True, slots=True)
class Line:
    """A line below a joint's edge: the range of `dof`, or, if `follows`, the rule by which it follows its
    driver."""

    dof: str
    text: str
    follows: bool


@dataclass(frozen=True, slots=True)
class Box:
    """The box of a link and the label of the joint to its parent. Lengths in px; (x, y) is the middle of the
    box's left side."""

    link: Link
    joint: Joint | None
    rows: tuple[BoxRow, ...]
    lines: tuple[Line, ...]
    x: float = 0.0
    y: float = 0.0
    width: float = 0.0
    label_x: float = 0.0

    @property
    def height(self) -> float:
        return 2 * PAD + ROW * len(self.rows)

    @property
    def band(self) -> float:
        """The height of the box or of the label, whichever is larger."""
        return max(self.height, 2 * LABEL + 4, 2 * (LINE * len(self.lines) + 6))

    @property
    def right(self) -> float:
        return self.x + self.width

    @property
    def label_width(self) -> float:
        if self.joint is None:
            return 0.0
        name = 18 + text_width(fitted(self.joint.name, 11, ROOM, bold=True), 11, bold=True)
        return max(name, *(text_width(line.text, 10) for line in self.lines), 0.0)

    def row_y(self, row: BoxRow) -> float:
        return self.y - self.height / 2 + PAD + (self.rows.index(row) + 0.5) * ROW

    def line_y(self, line: Line) -> float:
        return self.y + 4 + (self.lines.index(line) + 0.5) * LINE


def boxes_of(robot: Robot) -> dict[str, Box]:
    """Returns the box of each link by its name, not yet placed."""
    parent_joints = {joint.child: joint for joint in robot.joints}
    rule_of_dof = rules(robot, room=24)
    frames = frames_on(robot)
    loops_at_link: dict[str, list[int]] = {}
    for index, loop in enumerate(robot.loops):
        for name in dict.fromkeys((loop.link_a, loop.link_b)):
            loops_at_link.setdefault(name, []).append(index)
    boxes = {}
    for link in robot.links:
        joint = parent_joints.get(link.name)
        rows = [*_rows(link, robot), *_name_rows("frame", frames.get(link.name, ()))]
        rows += [_loop_row(robot.loops[index], index) for index in loops_at_link.get(link.name, ())]
        lines = () if joint is None else tuple(_lines(joint, rule_of_dof))
        boxes[link.name] = Box(link, joint, tuple(rows), lines)
    return boxes


def _lines(joint: Joint, rule_of_dof: Mapping[str, str]) -> Iterator[Line]:
    for dof, words in motions(joint):
        yield Line(dof.name, words, False)
        if dof.name in rule_of_dof:
            yield Line(dof.name, f"= {rule_of_dof[dof.name]}", True)


def _loop_row(loop: Loop, index: int) -> BoxRow:
    return BoxRow("loop", fitted(loop.mate.name or loop.name, 10, ROOM), caption(loop), index)


def _rows(link: Link, robot: Robot) -> Iterator[BoxRow]:
    yield BoxRow("name", fitted(link.name, SIZES["name"], ROOM, bold=True), link.name)
    if is_origin(robot, link):
        yield BoxRow("plain", "the assembly's origin")
    else:
        source_note = " (given)" if link.given else ""
        counts = [count(len(link.parts), "part")] if link.parts else []
        counts += [count(len(link.shapes), "shape")] if link.shapes else []
        yield BoxRow("plain", ", ".join([kilograms(link.inertial.mass) + source_note, *counts]))
    if len(link.parts) > 1:
        yield from _name_rows("part", part_names(link))


def _name_rows(kind: Kind, names: Sequence[str]) -> Iterator[BoxRow]:
    """Yields a row for each name; for many names only the first ones, and a row with the number of the
    rest."""
    shown = names if len(names) <= MAX_SHOWN else names[: MAX_SHOWN - 1]
    for name in shown:
        yield BoxRow(kind, fitted(name, SIZES[kind], ROOM), name)
    if len(shown) < len(names):
        rest = names[len(shown) :]
        yield BoxRow(kind, f"and {len(rest)} more", "\n".join(rest))


def caption(loop: Loop) -> str:
    ends = f"{loop.link_a} to {loop.link_b}"
    return f"loop {loop.name}: {loop.type}, mate {loop.mate.name}\n{ends}\nresidual {loop.residual:.2g}"
