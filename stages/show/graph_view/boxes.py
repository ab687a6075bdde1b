"""The boxes of the picture: the lines of a link and of the joint to its parent, and their size."""

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

ROOM = 190.0  # what a name may take
ROW, PAD, MARK = 14.0, 7.0, 14.0  # a row of a box, the space about the rows, what a row's mark takes
LABEL, LINE = 18.0, 13.0  # a joint's name above its edge, each line below
SHOWN = 3  # parts and frames that a box names

Kind = Literal["name", "plain", "part", "frame", "loop"]


@dataclass(frozen=True, slots=True)
class BoxRow:
    """A line of a box. `full`: its tooltip; `loop`: the loop that it marks."""

    kind: Kind
    text: str
    full: str = ""
    loop: int = 0

    @property
    def width(self) -> float:
        mark = MARK if self.kind in ("frame", "loop") else 0.0
        return mark + text_width(self.text, SIZES[self.kind], bold=self.kind == "name")


SIZES: Mapping[Kind, float] = {"name": 12.0, "plain": 10.0, "part": 9.5, "frame": 10.0, "loop": 10.0}


@dataclass(frozen=True, slots=True)
class Line:
    """A line below a joint's edge: the range of `dof`, or the rule by which it `follows`."""

    dof: str
    text: str
    follows: bool


@dataclass(frozen=True, slots=True)
class Box:
    """A link and the joint to its parent as they are drawn: (x, y) is the middle of the left side."""

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
    """The box of every link, not placed yet."""
    above = {joint.child: joint for joint in robot.joints}
    follows = rules(robot, room=24)
    frames = frames_on(robot)
    ends: dict[str, list[int]] = {}
    for index, loop in enumerate(robot.loops):
        for link in dict.fromkeys((loop.link_a, loop.link_b)):
            ends.setdefault(link, []).append(index)
    boxes = {}
    for one in robot.links:
        joint = above.get(one.name)
        rows = [*_rows(one, robot), *_few("frame", frames.get(one.name, ()))]
        rows += [_end(robot.loops[index], index) for index in ends.get(one.name, ())]
        lines = () if joint is None else tuple(_lines(joint, follows))
        boxes[one.name] = Box(one, joint, tuple(rows), lines)
    return boxes


def _lines(joint: Joint, follows: Mapping[str, str]) -> Iterator[Line]:
    for dof, words in motions(joint):
        yield Line(dof.name, words, False)
        if dof.name in follows:
            yield Line(dof.name, f"= {follows[dof.name]}", True)


def _end(loop: Loop, index: int) -> BoxRow:
    return BoxRow("loop", fitted(loop.mate.name or loop.name, 10, ROOM), caption(loop), index)


def _rows(link: Link, robot: Robot) -> Iterator[BoxRow]:
    yield BoxRow("name", fitted(link.name, SIZES["name"], ROOM, bold=True), link.name)
    if is_origin(robot, link):
        yield BoxRow("plain", "the assembly's origin")
    else:
        given = " (given)" if link.given else ""
        counts = [count(len(link.parts), "part")] if link.parts else []
        counts += [count(len(link.shapes), "shape")] if link.shapes else []
        yield BoxRow("plain", ", ".join([kilograms(link.inertial.mass) + given, *counts]))
    if len(link.parts) > 1:
        yield from _few("part", part_names(link))


def _few(kind: Kind, names: Sequence[str]) -> Iterator[BoxRow]:
    """A row for each name; of many names only the first ones."""
    shown = names if len(names) <= SHOWN else names[: SHOWN - 1]
    for name in shown:
        yield BoxRow(kind, fitted(name, SIZES[kind], ROOM), name)
    if len(shown) < len(names):
        rest = names[len(shown) :]
        yield BoxRow(kind, f"and {len(rest)} more", "\n".join(rest))


def caption(loop: Loop) -> str:
    ends = f"{loop.link_a} to {loop.link_b}"
    return f"loop {loop.name}: {loop.type}, mate {loop.mate.name}\n{ends}\nresidual {loop.residual:.2g}"
