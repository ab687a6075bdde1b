"""A plot as SVG that is part of a page: dots, joined in series, between two axes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from linkwright.pipeline.page.html.template import rendered, shortened
from linkwright.pipeline.page.sweep.axis import Axis

WIDTH, HEIGHT = 360, 230
"""Of the drawing, in its own units, which are pixels where there is room."""

_LETTER = 6.1
"""The width of a letter of an axis, in these units."""

_TOP, _RIGHT, _BOTTOM = 12.0, 14.0, 40.0
_MARKS = ("circle", "square", "triangle", "diamond", "cross")

_CORNERS = {
    "triangle": ((0, -4.4), (4.2, 3.2), (-4.2, 3.2)),
    "diamond": ((0, -4.8), (4.4, 0), (0, 4.8), (-4.4, 0)),
    "cross": ((-3.4, -3.4), (3.4, 3.4), (0, 0), (-3.4, 3.4), (3.4, -3.4), (0, 0)),
}
"""The corners of a mark, from its middle."""

SERIES = len(_MARKS)
"""So many series can be told apart, by the form of their dots."""


@dataclass(frozen=True, slots=True)
class Dot:
    """A value `y` at `x`, said in `words`; `series`: which it belongs to."""

    x: float
    y: float
    words: str
    series: int = 0


def plot(words: str, x: Axis, y: Axis, dots: Sequence[Dot], *, joined: bool) -> str:
    """The drawing; `words` for those who do not see it. `joined`: those of a series have a line."""
    left = 8.0 + _LETTER * max((len(name) for _, name in y.ticks), default=0)
    place = _Place(x, y, left)
    series = [
        sorted((dot for dot in dots if dot.series == number), key=lambda dot: (dot.x, dot.y))
        for number in sorted({dot.series for dot in dots})
    ]
    room = (WIDTH - _RIGHT - left) / max(1, len(x.ticks))
    return rendered(
        "plot",
        words=words,
        width=WIDTH,
        height=HEIGHT,
        left=left,
        right=WIDTH - _RIGHT,
        base=HEIGHT - _BOTTOM,
        levels=[(place.down(value), name) for value, name in y.ticks],
        columns=[
            (place.across(value), _fitting(name, max(3, int(room / _LETTER)))) for value, name in x.ticks
        ],
        middle=(left + WIDTH - _RIGHT) / 2,
        title=_fitting(x.title, int((WIDTH - left) / _LETTER)),
        lines=[_line(place, some) for some in series if len(some) > 1] if joined else [],
        marks=[
            _form(dot.series, place.across(dot.x), place.down(dot.y), dot.words)
            for some in series
            for dot in some
        ],
    )


def mark(series: int) -> str:
    """The form of the dots of a series, for a legend."""
    return rendered("mark", form=_form(series, 7.0, 7.0))


@dataclass(frozen=True, slots=True)
class _Place:
    """Where values of the axes are drawn; `left`: where the plot begins."""

    x: Axis
    y: Axis
    left: float

    def across(self, value: float) -> float:
        return self.left + self.x.share(value) * (WIDTH - _RIGHT - self.left)

    def down(self, value: float) -> float:
        return HEIGHT - _BOTTOM - self.y.share(value) * (HEIGHT - _BOTTOM - _TOP)


def _fitting(words: str, letters: int) -> str:
    if len(words) <= letters:
        return words
    cut = shortened(words, letters)
    return cut if len(cut) > letters // 2 else words[: letters - 1] + "…"


def _line(place: _Place, dots: Sequence[Dot]) -> tuple[int, str]:
    """The series of a line, and its points."""
    return dots[0].series, " ".join(f"{place.across(dot.x):.1f},{place.down(dot.y):.1f}" for dot in dots)


def _form(series: int, x: float, y: float, words: str = "") -> dict[str, Any]:
    """A mark around a point, with the words that it says."""
    number = series % SERIES
    points = " ".join(f"{x + dx:.1f},{y + dy:.1f}" for dx, dy in _CORNERS.get(_MARKS[number], ()))
    return {"kind": _MARKS[number], "number": number, "x": x, "y": y, "points": points, "words": words}
