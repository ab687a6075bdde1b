"""Draws the kinematic graph: links as boxes, joints as edges from left to right.

A link's loops and frames are rows of its box and a joint's relation is a row of its label, so that only lines
may cross; lines are below all boxes and words.
"""

from collections.abc import Mapping
from dataclasses import replace

from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.text.plural import count
from linkwright.stages.show.graph_view.boxes import (
    LABEL,
    MARK,
    PAD,
    ROOM,
    SIZES,
    Box,
    BoxRow,
    boxes_of,
    caption,
)
from linkwright.stages.show.graph_view.canvas import Canvas, TextStyle, fitted, text_width
from linkwright.stages.show.graph_view.labels import base_line, kilograms, mobility, rules, totals_line
from linkwright.stages.show.graph_view.layout import levels, tidy
from linkwright.stages.show.graph_view.symbols import (
    CROSS,
    EDGE,
    FRAME,
    GROUND,
    INK,
    LOOSE,
    RELATION,
    SOFT,
    arrow,
    draw_legend,
    draw_symbol,
    legend,
)

PAPER, FILL, ROOT_FILL = "#ffffff", "#f6f8fa", "#e6effb"
LOOP_COLOURS = ("#b5179e", "#c2410c", "#15803d", "#6d28d9", "#b91c1c", "#0e7490", "#a16207", "#475569")

HEAD_SIZE, HEAD_ROOM = 11.0, 700.0  # size and largest width of a line above the picture [px]
MARGIN, TOP, LEFT = 24.0, 98.0, 84.0  # around the picture, above the first box, left of the root [px]
GAP = 14.0  # between neighbours in a column [px]
BUS = 18.0  # from a column to the point where the edges of a parent part [px]
BUS_GAP, LABEL_GAP = 10.0, 14.0  # between that point and a label, and between a label and its box [px]
MARK_GAP = 3.0  # between the side of a box and its rows, beyond PAD [px]
BASE_GAP, LOOSE_WIDTH = (
    24.0,
    7.0,
)  # length of the root's edge to its base, width of the mark of a free base [px]


def draw(robot: Robot) -> bytes:
    """Draws the picture as SVG with its own background; the same robot always gives the same bytes."""
    boxes = _placed_boxes(robot, boxes_of(robot))
    curves = [_curve(robot, boxes, index) for index in range(len(robot.loops))]
    head_lines = (totals_line(robot), mobility(robot), base_line(robot))
    right = max(*(box.right for box in boxes.values()), *(reach for _, reach in curves), 0.0)
    head_width = max(text_width(fitted(text, HEAD_SIZE, HEAD_ROOM), HEAD_SIZE) for text in head_lines)
    right = max(right, MARGIN + head_width)
    bottom = max(box.y + box.band / 2 for box in boxes.values())
    entries, height = legend(robot, right - MARGIN)
    canvas = Canvas(
        right + MARGIN, bottom + 2 * MARGIN + height, PAPER, f"{robot.name}: {totals_line(robot)}"
    )
    canvas.text(MARGIN, 26, robot.name, TextStyle(16, INK, bold=True), room=right - MARGIN)
    for number, text in enumerate(head_lines):
        canvas.text(MARGIN, 45 + 15 * number, text, TextStyle(HEAD_SIZE, SOFT), room=HEAD_ROOM)
    for box in boxes.values():
        if box.joint is not None:
            _draw_edge(canvas, boxes[box.joint.parent], box)
    for index, (path_data, _) in enumerate(curves):
        canvas.group(caption(robot.loops[index]))
        canvas.path(path_data, _colour(index), thick=1.6, dash="6 4")
    _draw_relations(canvas, robot, boxes)
    for box in boxes.values():
        _draw_label(canvas, box)
        _draw_box(canvas, robot, box)
    _draw_base(canvas, robot, boxes[robot.root.name])
    draw_legend(canvas, entries, MARGIN, bottom + MARGIN)
    return canvas.to_bytes()


def _placed_boxes(robot: Robot, boxes: Mapping[str, Box]) -> dict[str, Box]:
    """Places the boxes in columns, one for each level of the tree. A column is as wide as its widest box and
    its widest label together."""
    parents = {joint.child: joint.parent for joint in robot.joints}
    order = list(boxes)
    level_of_link = levels(order, parents)
    centres = tidy(order, parents, {name: box.band for name, box in boxes.items()}, GAP)
    columns: list[list[Box]] = [[] for _ in range(max(level_of_link.values()) + 1)]
    for name, box in boxes.items():
        columns[level_of_link[name]].append(box)
    places, widths, x = [], [], LEFT
    for depth, column in enumerate(columns):
        label = max(box.label_width for box in column)
        x += BUS + BUS_GAP + label + LABEL_GAP if depth else 0.0
        places.append((x, x - label - LABEL_GAP))
        widths.append(max(row.width for box in column for row in box.rows) + 2 * (PAD + MARK_GAP))
        x += widths[-1]
    return {
        name: replace(
            box,
            x=places[level_of_link[name]][0],
            y=TOP + centres[name],
            width=widths[level_of_link[name]],
            label_x=places[level_of_link[name]][1],
        )
        for name, box in boxes.items()
    }


def _colour(index: int) -> str:
    return LOOP_COLOURS[index % len(LOOP_COLOURS)]


def _curve(robot: Robot, boxes: Mapping[str, Box], index: int) -> tuple[str, float]:
    """Returns the path of a loop's line, between the right sides of two boxes, and its reach to the right."""
    loop = robot.loops[index]
    ends = []
    for name in (loop.link_a, loop.link_b):
        box = boxes[name]
        row = next(row for row in box.rows if row.kind == "loop" and row.loop == index)
        ends.append((box.right, box.row_y(row)))
    (ax, ay), (bx, by) = ends
    # Long lines bend more; lines with other indices bend differently, so that they do not coincide.
    bend = 30 + min(120, 0.15 * abs(ay - by)) + 7 * (index % 5)
    path_data = f"M{ax:.1f} {ay:.1f}C{ax + bend:.1f} {ay:.1f} {bx + bend:.1f} {by:.1f} {bx:.1f} {by:.1f}"
    # A cubic whose handles are `bend` long reaches three quarters as far.
    return path_data, max(ax, bx) + 0.75 * bend


def _draw_edge(canvas: Canvas, parent: Box, box: Box) -> None:
    """Draws the edge of a joint from its parent's box to its child's."""
    canvas.group()
    bus = box.label_x - BUS_GAP
    dash = "3 3" if box.joint is not None and box.joint.type == "free" else None
    path_data = f"M{parent.right:.1f} {parent.y:.1f}H{bus:.1f}V{box.y:.1f}H{box.x:.1f}"
    canvas.path(path_data, EDGE, dash=dash)


def _draw_label(canvas: Canvas, box: Box) -> None:
    """Draws the name and symbol of a joint above its edge, and its lines below."""
    if box.joint is None:
        return
    joint = box.joint
    backwards = ", runs backwards (the second entity's link is the child)" if joint.backwards else ""
    mate = f"mate {joint.mate.name} ({joint.mate.type})" if joint.mate else "not in CAD"
    canvas.group(f"{joint.name}: {joint.type}{backwards}\n{joint.parent} to {joint.child}\n{mate}")
    label_y = box.y - LABEL / 2 - 1
    draw_symbol(canvas, joint.type, box.label_x + 7, label_y)
    canvas.text(box.label_x + 18, label_y, joint.name, TextStyle(11, INK, bold=True, halo=True), room=ROOM)
    for line in box.lines:
        colour = RELATION if line.follows else SOFT
        canvas.text(box.label_x, box.line_y(line), line.text, TextStyle(10, colour, halo=True))


def _draw_relations(canvas: Canvas, robot: Robot, boxes: Mapping[str, Box]) -> None:
    """Draws dotted lines from each driver's range to the rule of its follower."""
    places = {
        (line.dof, line.follows): (box.label_x - 2, box.line_y(line))
        for box in boxes.values()
        for line in box.lines
    }
    rule_of_dof = rules(robot)
    for relation in robot.relations:
        (ax, ay), (bx, by) = places[relation.driver, False], places[relation.follower, True]
        # To the left, where no box is in the way; the line ends at the tip of its arrow.
        bend = 16 + min(60, abs(ay - by) / 5)
        canvas.group(f"{relation.follower} = {rule_of_dof[relation.follower]}")
        handles = f"{ax - bend:.1f} {ay:.1f} {bx - bend:.1f} {by:.1f}"
        path_data = f"M{ax:.1f} {ay:.1f}C{handles} {bx - 3:.1f} {by:.1f}"
        canvas.path(path_data, RELATION, thick=1.4, dash="1 4")
        arrow(canvas, bx, by, RELATION)


def _draw_box(canvas: Canvas, robot: Robot, box: Box) -> None:
    """Draws the box of a link, and its rows with their marks."""
    is_root = box.link is robot.root
    parts = [part.name for part in box.link.parts]
    canvas.group(
        "\n".join(
            [box.link.name, f"{kilograms(box.link.inertial.mass)}, {count(len(parts), 'part')}", *parts]
        )
    )
    canvas.box(
        (box.x, box.y - box.height / 2),
        (box.width, box.height),
        ROOT_FILL if is_root else FILL,
        INK if is_root else EDGE,
        1.6 if is_root else 1.0,
    )
    for row in box.rows:
        y, left = box.row_y(row), box.x + PAD + MARK_GAP
        if row.full and row.kind != "name":
            canvas.group(row.full)
        if row.kind == "frame":
            canvas.path(CROSS, FRAME, thick=1.0, at=(left + 4, y))
        if row.kind == "loop":
            canvas.path("M0 0H9", _colour(row.loop), thick=1.8, dash="4 3", at=(left, y))
        left += MARK if row.kind in ("frame", "loop") else 0.0
        style = TextStyle(SIZES[row.kind], _colour_of_row(row), bold=row.kind == "name")
        canvas.text(left, y, row.text, style)


def _colour_of_row(row: BoxRow) -> str:
    if row.kind == "loop":
        return _colour(row.loop)
    return {"name": INK, "frame": FRAME}.get(row.kind, SOFT)


def _draw_base(canvas: Canvas, robot: Robot, box: Box) -> None:
    """Draws the base: on the ground, or free."""
    canvas.group(base_line(robot))
    fixed = robot.base.fixed
    canvas.path(
        f"M{box.x - BASE_GAP:.1f} {box.y:.1f}H{box.x:.1f}",
        INK if fixed else SOFT,
        dash=None if fixed else "3 3",
    )
    canvas.path(
        GROUND if fixed else LOOSE,
        INK if fixed else SOFT,
        thick=1.6,
        dash=None if fixed else "2 3",
        at=(box.x - BASE_GAP - (0 if fixed else LOOSE_WIDTH), box.y),
    )
    words = "fixed base" if fixed else "free base"
    canvas.text(box.x - 36, box.y + 26, words, TextStyle(10, SOFT, middle=True))
