"""Draws text, boxes and lines in SVG, on a sheet with a background."""

import math
import unicodedata
from dataclasses import dataclass

from linkwright.stages.formats import xml
from linkwright.stages.robot.text.printable import printable, printable_lines
from linkwright.stages.show.graph_view.labels import shortened

FONT = "system-ui, 'Segoe UI', 'Helvetica Neue', Arial, 'DejaVu Sans', sans-serif"
_NARROW, _BROAD = frozenset(" ijlft.,:;'|()[]!I-"), frozenset("mwMW@%—…+=×±≤≥<>~")


def text_width(text: str, size: float, *, bold: bool = False) -> float:
    """Returns an upper bound of the width of `text` [px] in the usual fonts, without reading a font."""
    em = 0.0
    for letter in text:
        if unicodedata.east_asian_width(letter) in "WF":
            em += 1.1
        elif letter in _NARROW:
            em += 0.45
        elif letter in _BROAD:
            em += 1.0
        else:
            em += 0.76 if letter.isupper() else 0.64
    return em * size * (1.1 if bold else 1.0)


def px(value: float) -> str:
    """Formats a length [px] with one decimal."""
    return f"{round(value, 1) + 0.0:g}" if abs(value) < 1e5 else f"{value:.0f}"


@dataclass(frozen=True, slots=True)
class TextStyle:
    """A style of text."""

    size: float
    colour: str
    bold: bool = False
    middle: bool = False
    """Whether the text is centred, instead of left-aligned."""

    halo: bool = False
    """Whether a patch in the colour of the paper hides the drawing below the text."""


class Canvas:
    """A sheet of `width` x `height` [px], on which later shapes cover earlier ones."""

    def __init__(self, width: float, height: float, paper: str, title: str) -> None:
        width, height = math.ceil(width), math.ceil(height)
        self._root = xml.element(
            None,
            "svg",
            xmlns="http://www.w3.org/2000/svg",
            width=str(width),
            height=str(height),
            viewBox=f"0 0 {width} {height}",
            role="img",
            **{"font-family": FONT},
        )
        self._paper = paper
        self._add(self._root, "title").text = printable(title)
        self._add(self._root, "rect", width=str(width), height=str(height), fill=paper)
        self._parent = self._root

    def group(self, title: str = "") -> None:
        """Groups the shapes that are drawn next; the lines of `title` are their tooltip."""
        self._parent = self._add(self._root, "g")
        if title:
            self._add(self._parent, "title").text = printable_lines(title)

    def text(self, x: float, y: float, text: str, style: TextStyle, room: float = math.inf) -> float:
        """Draws a line of text, vertically centred on `y`, and returns an upper bound of its width. Text
        wider than `room` is shortened, with the full text as its tooltip."""
        size, bold = style.size, style.bold
        shown = fitted(text, size, room, bold=bold)
        width = text_width(shown, size, bold=bold)
        parent = self._parent
        if shown != printable(text):
            parent = self._add(parent, "g")
            self._add(parent, "title").text = printable(text)
        if style.halo:
            left = x - width / 2 if style.middle else x
            background = {
                "x": px(left - 1),
                "y": px(y - size * 0.6),
                "width": px(width + 2),
                "height": px(size * 1.2),
            }
            self._add(parent, "rect", **background, fill=self._paper, fill_opacity="0.85")
        self._add(
            parent,
            "text",
            x=px(x),
            y=px(y + 0.35 * size),
            font_size=px(size),
            font_weight="600" if bold else None,
            text_anchor="middle" if style.middle else None,
            fill=style.colour,
        ).text = shown
        return width

    def box(
        self, corner: tuple[float, float], size: tuple[float, float], fill: str, stroke: str, thick: float
    ) -> None:
        """Draws a rectangle with round corners. `corner`: the upper left; `size`: width and height."""
        names = zip(("x", "y", "width", "height"), (*corner, *size), strict=True)
        place = {name: px(value) for name, value in names}
        self._add(self._parent, "rect", **place, rx="6", fill=fill, stroke=stroke, stroke_width=px(thick))

    def path(
        self,
        steps: str,
        stroke: str,
        *,
        thick: float = 1.2,
        dash: str | None = None,
        fill: str = "none",
        at: tuple[float, float] | None = None,
    ) -> None:
        """Draws a path in SVG's syntax, moved to `at`."""
        self._add(
            self._parent,
            "path",
            d=steps,
            fill=fill,
            stroke=stroke,
            stroke_width=px(thick),
            stroke_dasharray=dash,
            stroke_linecap="round",
            stroke_linejoin="round",
            transform=None if at is None else f"translate({px(at[0])} {px(at[1])})",
        )

    def to_bytes(self) -> bytes:
        return xml.to_bytes(self._root)

    def _add(self, parent: xml.Element, tag: str, **attributes: str | None) -> xml.Element:
        plain = {name.replace("_", "-"): value for name, value in attributes.items()}
        return xml.element(parent, tag, **plain)


def fitted(text: str, size: float, room: float, *, bold: bool = False) -> str:
    """Returns `text`, shortened in its middle if it is wider than `room` [px]."""
    return shortened(text, room, lambda part: text_width(part, size, bold=bold))
