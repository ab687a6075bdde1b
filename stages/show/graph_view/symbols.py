"""Draws the symbols of the picture, one for each type of joint, and the legend that explains them."""

from collections.abc import Mapping

from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.show.graph_view.canvas import Canvas, TextStyle, text_width

INK, SOFT, EDGE = "#1b1f24", "#57606a", "#8b949e"
JOINT, RELATION, FRAME, LOOP = "#1d4ed8", "#0f766e", "#3f6212", "#b5179e"

JOINTS: Mapping[str, str] = {
    "fixed": "M-4-4L4 4M-4 4L4-4",
    "revolute": "M-1 5A5 5 0 1 1 3.5 3.5M3.5 3.5L4.2 0.4M3.5 3.5L0.6 2.4",
    "prismatic": "M-6 0H6M-6 0L-3-3M-6 0L-3 3M6 0L3-3M6 0L3 3",
    "cylindrical": "M-6 4H6M6 4L3.5 1.8M6 4L3.5 6M-6 4L-3.5 1.8M-6 4L-3.5 6"
    "M-3.5-0.5A3.6 3.6 0 1 1 3.4-0.5M3.4-0.5L4.4-2.8M3.4-0.5L1.2-1.6",
    "ball": "M-3.2 0A3.2 3.2 0 1 0 3.2 0A3.2 3.2 0 1 0-3.2 0"
    "M-5.6 2.4A6 6 0 0 1-3.6-4.8M5.6 2.4A6 6 0 0 0 3.6-4.8",
    "planar": "M-6 0H6M0-6V6M-6 0L-4-2M-6 0L-4 2M6 0L4-2M6 0L4 2M0-6L-2-4M0-6L2-4M0 6L-2 4M0 6L2 4",
    "pin_slot": "M-3.5-3.5H3.5A3.5 3.5 0 0 1 3.5 3.5H-3.5A3.5 3.5 0 0 1-3.5-3.5"
    "M-1.6 0A1.6 1.6 0 1 0 1.6 0A1.6 1.6 0 1 0-1.6 0",
    "parallel": "M-6-2.5H6M-6 2.5H6",
    "free": "M-5 0A5 5 0 0 1 5 0M-3.5 3.5A5 5 0 0 0 3.5 3.5",
    "compound": "M-6 3L-2-3L2 3L6-3",
}
"""Type of joint → a path around the origin, about 12 px wide."""

CROSS = "M-4 0H4M0-4V4M-2 0A2 2 0 1 0 2 0A2 2 0 1 0-2 0"
GROUND = "M0-16V16M0-14L-8-8M0-6L-8 0M0 2L-8 8M0 10L-8 16"
LOOSE = "M-6 0A6 6 0 1 0 6 0A6 6 0 1 0-6 0"

_ROW, _SIZE, _SIGN, _GAP = 20.0, 10.5, 26.0, 18.0
Place = tuple[float, float, str, str]
"""An entry of the legend: x and y [px], the kind of its symbol, and its text."""


def legend(robot: Robot, width: float) -> tuple[list[Place], float]:
    """Lays out the legend within `width`: returns its entries (x, y, kind, text), and its height [px]."""
    places: list[Place] = []
    x, y = 0.0, _ROW / 2
    for kind, words in _entries(robot):
        needed_width = _SIGN + text_width(words, _SIZE) + _GAP
        if x and x + needed_width > width:
            x, y = 0.0, y + _ROW
        places.append((x, y, kind, words))
        x += needed_width
    return places, y + _ROW / 2


def _entries(robot: Robot) -> list[tuple[str, str]]:
    """Returns the kind and the text of each entry of the legend that the picture needs."""
    types = {joint.type for joint in robot.joints}
    entries: list[tuple[str, str]] = [
        (kind, f"{kind.replace('_', ' ')} joint") for kind in JOINTS if kind in types
    ]
    if robot.relations:
        entries.append(("relation", "relation (to the follower)"))
    if robot.loops:
        entries.append(("loop", "mate that closes a loop"))
    if robot.frames:
        entries.append(("frame", "frame"))
    entries.append(("ground", "fixed base") if robot.base.fixed else ("loose", "free base"))
    return entries


def draw_legend(canvas: Canvas, places: list[Place], left: float, top: float) -> None:
    for x, y, kind, words in places:
        canvas.group()
        draw_symbol(canvas, kind, left + x + 9, top + y)
        canvas.text(left + x + _SIGN, top + y, words, TextStyle(_SIZE, SOFT))


def draw_symbol(canvas: Canvas, kind: str, x: float, y: float) -> None:
    """Draws the symbol of a type of joint, or another symbol of the legend, at (x, y)."""
    if kind == "relation":
        canvas.path("M-9 0H7", RELATION, dash="1 4", thick=1.6, at=(x, y))
        arrow(canvas, x + 9, y, RELATION)
    elif kind == "loop":
        canvas.path("M-9 0H9", LOOP, dash="6 4", thick=1.6, at=(x, y))
    elif kind == "frame":
        canvas.path(CROSS, FRAME, thick=1.1, at=(x, y))
    elif kind == "ground":
        canvas.path("M3-7V7M3-6L-3-1M3-1L-3 4M3 4L-1 7", INK, at=(x, y))
    elif kind == "loose":
        canvas.path(LOOSE, SOFT, dash="2 3", at=(x, y))
    else:
        canvas.path(JOINTS[kind], JOINT, at=(x, y))


def arrow(canvas: Canvas, x: float, y: float, colour: str) -> None:
    """Draws a small arrow head to the right, its tip at (x, y)."""
    canvas.path("M0 0L-5-3V3Z", colour, fill=colour, thick=0.5, at=(x, y))
