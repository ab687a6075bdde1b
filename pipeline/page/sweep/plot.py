"""A plot as SVG that is part of a page: dots, joined in series, between two axes."""

from collections.abc import Sequence
from dataclasses import dataclass

from linkwright.pipeline.page.html.markup import shortened, text
from linkwright.pipeline.page.sweep.axis import Axis

WIDTH, HEIGHT = 360, 230
"""Of the drawing, in its own units, which are pixels where there is room."""

_LETTER = 6.1
"""The width of a letter of an axis, in these units."""

_TOP, _RIGHT, _BOTTOM = 12.0, 14.0, 40.0
_MARKS = ("circle", "square", "triangle", "diamond", "cross")

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
    lines = [_line(place, some) for some in series if len(some) > 1] if joined else []
    marks = [_dot(place, dot) for some in series for dot in some]
    return "\n".join(
        [
            f'<svg class="plot" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{text(words)}">',
            *_levels(place),
            *_columns(place),
            *lines,
            *marks,
            "</svg>",
        ]
    )


def mark(series: int) -> str:
    """The form of the dots of a series, for a legend."""
    inner = _form(series, 7.0, 7.0)
    return (
        f'<svg class="plot mark" viewBox="0 0 14 14" width="14" height="14" aria-hidden="true">{inner}</svg>'
    )


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


def _levels(place: _Place) -> list[str]:
    """The y axis: a line for each named value."""
    found = []
    for value, name in place.y.ticks:
        at = place.down(value)
        found.append(
            f'<line class="grid" x1="{place.left:.1f}" y1="{at:.1f}" x2="{WIDTH - _RIGHT}" y2="{at:.1f}"/>'
        )
        found.append(
            f'<text x="{place.left - 6:.1f}" y="{at + 3.5:.1f}" text-anchor="end">{text(name)}</text>'
        )
    return found


def _columns(place: _Place) -> list[str]:
    """The x axis: its line, its named values, its title."""
    base = HEIGHT - _BOTTOM
    room = (WIDTH - _RIGHT - place.left) / max(1, len(place.x.ticks))
    letters = max(3, int(room / _LETTER))
    found = [f'<line class="axis" x1="{place.left:.1f}" y1="{base}" x2="{WIDTH - _RIGHT}" y2="{base}"/>']
    for value, name in place.x.ticks:
        at = place.across(value)
        found.append(f'<line class="axis" x1="{at:.1f}" y1="{base}" x2="{at:.1f}" y2="{base + 4}"/>')
        found.append(
            f'<text x="{at:.1f}" y="{base + 16}" text-anchor="middle">{text(_fitting(name, letters))}</text>'
        )
    middle = (place.left + WIDTH - _RIGHT) / 2
    title = _fitting(place.x.title, int((WIDTH - place.left) / _LETTER))
    found.append(
        f'<text class="title" x="{middle:.1f}" y="{HEIGHT - 6}" text-anchor="middle">{text(title)}</text>'
    )
    return found


def _fitting(words: str, letters: int) -> str:
    if len(words) <= letters:
        return words
    cut = shortened(words, letters)
    return cut if len(cut) > letters // 2 else words[: letters - 1] + "…"


def _line(place: _Place, dots: Sequence[Dot]) -> str:
    points = " ".join(f"{place.across(dot.x):.1f},{place.down(dot.y):.1f}" for dot in dots)
    return f'<polyline class="line{dots[0].series}" points="{points}"/>'


def _dot(place: _Place, dot: Dot) -> str:
    form = _form(dot.series, place.across(dot.x), place.down(dot.y))
    return form.replace("/>", f"><title>{text(dot.words)}</title></{form[1 : form.index(' ')]}>")


def _form(series: int, x: float, y: float) -> str:
    """A mark around a point."""
    kind = _MARKS[series % SERIES]
    style = f'class="dot{series % SERIES}"'
    if kind == "circle":
        return f'<circle {style} cx="{x:.1f}" cy="{y:.1f}" r="3.6"/>'
    if kind == "square":
        return f'<rect {style} x="{x - 3.2:.1f}" y="{y - 3.2:.1f}" width="6.4" height="6.4"/>'
    corners = {
        "triangle": ((0, -4.4), (4.2, 3.2), (-4.2, 3.2)),
        "diamond": ((0, -4.8), (4.4, 0), (0, 4.8), (-4.4, 0)),
        "cross": ((-3.4, -3.4), (3.4, 3.4), (0, 0), (-3.4, 3.4), (3.4, -3.4), (0, 0)),
    }[kind]
    points = " ".join(f"{x + dx:.1f},{y + dy:.1f}" for dx, dy in corners)
    return f'<polygon {style} points="{points}"/>'
