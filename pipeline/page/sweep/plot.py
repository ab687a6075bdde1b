"""Draws a plot as SVG within a page: dots, joined in series, between two axes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from linkwright.pipeline.page.html.template import rendered, shortened
from linkwright.pipeline.page.sweep.axis import Axis

WIDTH, HEIGHT = 360, 230
"""Size of the drawing in its own units, which are pixels where there is room."""

_LETTER_WIDTH = 6.1
"""Width of a letter at an axis, in units of the drawing."""

_TOP, _RIGHT, _BOTTOM = 12.0, 14.0, 40.0
"""Margins around the plot, in units of the drawing."""

_MARKS = ("circle", "square", "triangle", "diamond", "cross")

_CORNERS = {
    "triangle": ((0, -4.4), (4.2, 3.2), (-4.2, 3.2)),
    "diamond": ((0, -4.8), (4.4, 0), (0, 4.8), (-4.4, 0)),
    "cross": ((-3.4, -3.4), (3.4, 3.4), (0, 0), (-3.4, 3.4), (3.4, -3.4), (0, 0)),
}
"""The corners of a mark, from its middle."""

MAX_SERIES = len(_MARKS)
"""Largest number of series that the form of their dots can tell apart."""


@dataclass(frozen=True, slots=True)
class Dot:
    """A value `y` of a job at `x`; `words`: both as text; `series`: the index of its series."""

    x: float
    y: float
    words: str
    series: int = 0
    job: int | None = None


def plot(words: str, x: Axis, y: Axis, dots: Sequence[Dot], *, joined: bool) -> str:
    """Draws a plot. `words`: its text for readers who do not see it; `joined`: whether a line joins the dots
    of a series."""
    left = 8.0 + _LETTER_WIDTH * max((len(name) for _, name in y.ticks), default=0)
    scale = _Scale(x, y, left)
    series = [
        sorted((dot for dot in dots if dot.series == number), key=lambda dot: (dot.x, dot.y))
        for number in sorted({dot.series for dot in dots})
    ]
    column_width = (WIDTH - _RIGHT - left) / max(1, len(x.ticks))
    return rendered(
        "plot",
        words=words,
        width=WIDTH,
        height=HEIGHT,
        left=left,
        right=WIDTH - _RIGHT,
        base=HEIGHT - _BOTTOM,
        levels=[(scale.down(value), name) for value, name in y.ticks],
        columns=[
            (scale.across(value), _fit_words(name, max(3, int(column_width / _LETTER_WIDTH))))
            for value, name in x.ticks
        ],
        middle=(left + WIDTH - _RIGHT) / 2,
        title=_fit_words(x.title, int((WIDTH - left) / _LETTER_WIDTH)),
        lines=[_line(scale, series_dots) for series_dots in series if len(series_dots) > 1] if joined else [],
        marks=[
            _form(dot.series, scale.across(dot.x), scale.down(dot.y)) | {"words": dot.words, "job": dot.job}
            for series_dots in series
            for dot in series_dots
        ],
    )


def mark(series: int) -> str:
    """Draws the mark of a series for a legend."""
    return rendered("mark", form=_form(series, 7.0, 7.0))


@dataclass(frozen=True, slots=True)
class _Scale:
    """Converts values of the axes to positions in the drawing; `left`: the left edge of the plot."""

    x: Axis
    y: Axis
    left: float

    def across(self, value: float) -> float:
        return self.left + self.x.share(value) * (WIDTH - _RIGHT - self.left)

    def down(self, value: float) -> float:
        return HEIGHT - _BOTTOM - self.y.share(value) * (HEIGHT - _BOTTOM - _TOP)


def _fit_words(words: str, letters: int) -> str:
    if len(words) <= letters:
        return words
    short_words = shortened(words, letters)
    return short_words if len(short_words) > letters // 2 else words[: letters - 1] + "…"


def _line(scale: _Scale, dots: Sequence[Dot]) -> tuple[int, str]:
    """Returns the series of a line, and its points."""
    return dots[0].series, " ".join(f"{scale.across(dot.x):.1f},{scale.down(dot.y):.1f}" for dot in dots)


def _form(series: int, x: float, y: float) -> dict[str, Any]:
    """Returns a mark around a point, without words."""
    number = series % MAX_SERIES
    points = " ".join(f"{x + dx:.1f},{y + dy:.1f}" for dx, dy in _CORNERS.get(_MARKS[number], ()))
    return {
        "kind": _MARKS[number],
        "number": number,
        "x": x,
        "y": y,
        "points": points,
        "words": "",
        "job": None,
    }
