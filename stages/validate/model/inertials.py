"""Whether the inertial of a body can be that of its shapes: what has other units is found.

A body whose mass lies within its shapes has a radius of gyration about each axis, √(I/m), that is no larger
than they reach from that axis, its center of mass within them, and a density that matter has.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from linkwright.stages.robot.check import Check, CheckLevel, Finding
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.model.body_shapes import BodyExtents, outside, reaches

CODE = "C-INERTIAL"

STAND_IN = 1e-6
"""A body of at most this mass [kg] stands in for a frame: its inertia is of no account."""

MARK = 0.02
"""Shapes below this size [m] that are no meshes may mark a link, and not be its form."""

LARGE, TOO_LARGE = 1.05, 5.0
"""The radius of gyration, as a share of the shapes' reach: more cannot be, and from the second on no part
that is not shown explains it. A thousand times the inertia makes it 32 times larger."""

SMALL = 0.05
"""A share that a body with its mass in one spot may have; a solid one has 0.3 to 0.7."""

TYPICAL = 0.5

OUT, FAR_OUT = 0.1, 2.0
"""How far outside the shapes the center of mass is, as a share of their size: an unseen part may pull it
a little way, but not away."""

MILLIMETRES = 30.0
"""From this share on a length in mm may have been read as one in m."""

DENSE, TOO_DENSE = 12_000.0, 60_000.0
"""Of the mass in a box around the shapes [kg/m³]: denser than lead, and far denser than any metal (osmium has
22,600)."""

THIN, TOO_THIN = 1.0, 0.05
"""The same [kg/m³]: an empty frame may have it; half of hydrogen's."""

GRAM = 1e-3
"""A lighter mass [kg] may be a marker that is only seen: its density is of no account."""

_LARGER = ((1e3, "g m² read as kg m²?"), (1e6, "kg mm² read as kg m²?"), (1e9, "g mm² read as kg m²?"))
_SMALLER = ((1e-3, "a mass in g read as kg?"), (1e-6, "an inertia of a shape in mm?"))

Quantity = Literal["inertia", "center", "mass", "shape"]


@dataclass(frozen=True, slots=True, eq=False)
class ShapedInertial:
    """A body's inertial and shapes, in its frame. `mass` [kg]; `com` (3,) [m]; `moments` (3,) [kg m²] about
    the columns of `axes` (3, 3). `moves`: the inertial of a body that cannot move has no effect: what would
    be wrong is odd, what would be odd is left alone. `places`: the element and the attribute by which the
    file gives each quantity."""

    mass: float
    com: Array
    moments: Array
    axes: Array
    shapes: BodyExtents
    moves: bool
    places: Mapping[Quantity, tuple[str, str]]


@dataclass(frozen=True, slots=True)
class _Judged:
    """What is found of a body's quantity: `wrong` where it cannot be, else it is only odd."""

    value: float
    wrong: bool = False
    finding: Finding | None = None


def checks(file: str, bodies: Iterable[ShapedInertial]) -> Iterator[Check]:
    """Up to three results; none where no body can be judged."""
    judged = [body for body in bodies if body.mass > STAND_IN and not _is_mark(body.shapes)]
    spread = [body for body in judged if body.moments.any()]
    thick = [body for body in judged if body.shapes.volume > (1e-3 * body.shapes.size) ** 3]
    number = count(len(judged), "body", "bodies")
    for name, results, limit, words in (
        (
            "inertia fits the shape",
            [_gyration(body) for body in spread],
            LARGE,
            "radius of gyration as a share of the shape's reach",
        ),
        (
            "centre of mass in the shape",
            [_center(body) for body in judged],
            OUT,
            "how far out as a share of the shape's size",
        ),
        (
            "density of matter",
            [_density(body) for body in thick],
            DENSE,
            "mass in a box around the shape [kg/m³]",
        ),
    ):
        if results:
            yield from _results(f"{file}: {name}", results, limit, f"{words}, of {number}")


def _is_mark(shapes: BodyExtents) -> bool:
    return shapes.size == 0.0 or (shapes.size < MARK and not shapes.meshes)


def _results(name: str, results: Sequence[_Judged], limit: float, words: str) -> Iterator[Check]:
    """What is wrong, an error; what is only odd, a warning; one result where there is neither."""
    wrong = [one for one in results if one.wrong]
    odd = [one for one in results if one.finding and not one.wrong]
    if wrong:
        yield _failed(name, wrong, limit, "error")
    if odd:
        yield _failed(f"{name}, doubtful" if wrong else name, odd, limit, "warning")
    if not wrong and not odd:
        value = max(one.value for one in results)
        yield Check(name, True, f"{words}: at most {value:.3g}", value, limit, CODE)


def _failed(name: str, judged: Sequence[_Judged], limit: float, level: CheckLevel) -> Check:
    findings = tuple(one.finding for one in judged if one.finding)
    detail = "; ".join(f"{finding.element}: {finding.message}" for finding in findings[:3])
    return Check(name, False, detail, judged[0].value, limit, CODE, level, findings)


def _judged(body: ShapedInertial, value: float, wrong: bool, quantity: Quantity, words: str) -> _Judged:
    if not body.moves and not wrong:
        return _Judged(value)
    return _Judged(value, wrong and body.moves, Finding(*body.places[quantity], words))


def _gyration(body: ShapedInertial) -> _Judged:
    reach = reaches(body.shapes, body.com, body.axes)
    shares = np.sqrt(np.maximum(body.moments, 0.0) / body.mass) / np.maximum(reach, 1e-6 * body.shapes.size)
    worst = int(shares.argmax())
    share = float(shares[worst])
    if SMALL <= share <= LARGE:
        return _Judged(share)
    radius = 1e3 * math.sqrt(max(0.0, body.moments[worst]) / body.mass)
    words = f"its radius of gyration is {radius:.3g} mm, but its shape reaches {1e3 * reach[worst]:.3g} mm"
    words += f" from that axis{_guess((share / TYPICAL) ** 2)}"
    return _judged(body, share, share > TOO_LARGE, "inertia", words)


def _guess(factor: float) -> str:
    """The mistake of units that makes an inertia this many times what it should be."""
    for of_units, words in (*_LARGER, *_SMALLER):
        if abs(math.log10(max(factor, 1e-300) / of_units)) < 0.5:
            return f": about {of_units:,.6g} times what it could be, {words}"
    return ""


def _center(body: ShapedInertial) -> _Judged:
    size = body.shapes.size
    share = outside(body.shapes, body.com) / size
    if share <= OUT:
        return _Judged(share)
    inside = outside(body.shapes, 1e-3 * body.com) <= OUT * size
    guess = ": mm read as m?" if share > MILLIMETRES and inside else ""
    words = f"its centre of mass is {1e3 * share * size:.3g} mm outside its shape{guess}"
    return _judged(body, share, share > FAR_OUT, "center", words)


def _density(body: ShapedInertial) -> _Judged:
    volume = body.shapes.volume
    density = body.mass / volume
    if THIN <= density <= DENSE or body.mass < GRAM:
        return _Judged(density)
    words = f"{body.mass:.3g} kg within {1e6 * volume:.3g} cm³ is {density:.3g} kg/m³"
    if density > DENSE:
        guess = ": g read as kg, or a shape in m read as mm?" if density > 1e5 else ""
        return _judged(body, density, density > TOO_DENSE, "mass", f"{words}, denser than lead{guess}")
    guess = ": a shape in mm read as m?" if density < TOO_THIN else ""
    return _judged(body, density, density < TOO_THIN, "shape", f"{words}, next to nothing{guess}")
