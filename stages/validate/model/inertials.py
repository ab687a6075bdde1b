"""Judges whether a body's inertial fits its shapes, to find mixed-up units.

A body whose mass is within its shapes has a radius of gyration about each axis, √(I/m), of at most their
reach from that axis, its centre of mass within them, and the density of a material.
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
"""Largest mass [kg] of a body that only represents a frame. Its inertial is not judged."""

MAX_MARKER_SIZE = 0.02
"""Size [m] below which shapes without a mesh may only mark a link, and not show its form."""

LARGE, TOO_LARGE = 1.05, 5.0
"""Limits of the radius of gyration, as a share of the shapes' reach: above the first, mass within the shapes
cannot explain it; above the second, no unseen part can either. An inertia that is 1000 times too large makes
it √1000 ≈ 32 times too large."""

MIN_GYRATION = 0.05
"""Smallest radius of gyration, as a share of the reach: solid bodies have 0.3 to 0.7, and a body with its
mass in one spot has almost 0."""

TYPICAL_SHARE = 0.5
"""Radius of gyration of a solid body, as a share of the reach: guesses at confused units start from it."""

OUT, FAR_OUT = 0.1, 2.0
"""Distances of the centre of mass outside the shapes, as a share of their size, above which it is doubtful,
and above which it is impossible: an unseen part may pull it out a little, but not far."""

MILLIMETRES = 30.0
"""Distance of the centre of mass outside the shapes, as a share of their size, above which it may be in mm
and was read in metres."""

DENSE, TOO_DENSE = 12_000.0, 60_000.0
"""Limits of the density in a box around the shapes [kg/m³]: denser than lead, and far denser than any metal
(osmium has 22,600)."""

THIN, TOO_THIN = 1.0, 0.05
"""Lower limits of that density [kg/m³]: that of an empty frame, and half of hydrogen's."""

MIN_JUDGED_MASS = 1e-3
"""Mass [kg] below which a body may be only a visual marker, so that its density does not matter."""

_LARGER = ((1e3, "g m² read as kg m²?"), (1e6, "kg mm² read as kg m²?"), (1e9, "g mm² read as kg m²?"))
"""(factor, text): the factor by which a mistake of units makes an inertia too large."""

_SMALLER = ((1e-3, "a mass in g read as kg?"), (1e-6, "an inertia of a shape in mm?"))
"""(factor, text): the factor by which a mistake of units makes an inertia too small."""

Quantity = Literal["inertia", "center", "mass", "shape"]


@dataclass(frozen=True, slots=True, eq=False)
class ShapedInertial:
    """A body's inertial and shapes, in its frame."""

    mass: float
    """Mass [kg]."""

    com: Array
    """Centre of mass (3,) [m]."""

    moments: Array
    """Principal moments (3,) [kg m²] about the columns of `axes`."""

    axes: Array
    """Principal axes (3, 3), as columns."""

    shapes: BodyExtents
    moves: bool
    """Whether the body can move. The inertial of a fixed body has no effect, so that impossible values only
    count as doubtful, and doubtful values are ignored."""

    places: Mapping[Quantity, tuple[str, str]]
    """The element and the attribute by which the file gives each quantity."""


@dataclass(frozen=True, slots=True)
class _Judgement:
    """The judgement of a quantity of a body."""

    value: float
    wrong: bool = False
    """Whether the value is impossible; otherwise a finding is only a doubt."""

    finding: Finding | None = None


def checks(file: str, bodies: Iterable[ShapedInertial]) -> Iterator[Check]:
    """Yields up to three results, or nothing if no body can be judged."""
    judged_bodies = [body for body in bodies if body.mass > STAND_IN and not _is_mark(body.shapes)]
    spread = [body for body in judged_bodies if body.moments.any()]
    # Flat shapes have no volume, and so no density.
    thick = [body for body in judged_bodies if body.shapes.volume > (1e-3 * body.shapes.size) ** 3]
    number = count(len(judged_bodies), "body", "bodies")
    for name, results, limit, words in (
        (
            "inertia fits the shape",
            [_gyration(body) for body in spread],
            LARGE,
            "radius of gyration as a share of the shape's reach",
        ),
        (
            "centre of mass in the shape",
            [_center(body) for body in judged_bodies],
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
    return shapes.size == 0.0 or (shapes.size < MAX_MARKER_SIZE and not shapes.meshes)


def _results(name: str, results: Sequence[_Judgement], limit: float, words: str) -> Iterator[Check]:
    """Yields an error for impossible values and a warning for doubtful values, or else a passed result."""
    wrong = [result for result in results if result.wrong]
    doubtful = [result for result in results if result.finding and not result.wrong]
    if wrong:
        yield _failed_check(name, wrong, limit, "error")
    if doubtful:
        yield _failed_check(f"{name}, doubtful" if wrong else name, doubtful, limit, "warning")
    if not wrong and not doubtful:
        value = max(result.value for result in results)
        yield Check(name, True, f"{words}: at most {value:.3g}", value, limit, CODE)


def _failed_check(name: str, judgements: Sequence[_Judgement], limit: float, level: CheckLevel) -> Check:
    findings = tuple(judgement.finding for judgement in judgements if judgement.finding)
    detail = "; ".join(f"{finding.element}: {finding.message}" for finding in findings[:3])
    return Check(name, False, detail, judgements[0].value, limit, CODE, level, findings)


def _judgement(body: ShapedInertial, value: float, wrong: bool, quantity: Quantity, words: str) -> _Judgement:
    if not body.moves and not wrong:
        return _Judgement(value)
    return _Judgement(value, wrong and body.moves, Finding(*body.places[quantity], words))


def _gyration(body: ShapedInertial) -> _Judgement:
    reach = reaches(body.shapes, body.com, body.axes)
    # The lower bound of the reach keeps the share finite for shapes on the axis.
    shares = np.sqrt(np.maximum(body.moments, 0.0) / body.mass) / np.maximum(reach, 1e-6 * body.shapes.size)
    worst = int(shares.argmax())
    share = float(shares[worst])
    if MIN_GYRATION <= share <= LARGE:
        return _Judgement(share)
    radius = 1e3 * math.sqrt(max(0.0, body.moments[worst]) / body.mass)
    message = f"its radius of gyration is {radius:.3g} mm, but its shape reaches {1e3 * reach[worst]:.3g} mm"
    message += f" from that axis{_guess((share / TYPICAL_SHARE) ** 2)}"
    return _judgement(body, share, share > TOO_LARGE, "inertia", message)


def _guess(factor: float) -> str:
    """Returns a text on the mistake of units that multiplies an inertia by about `factor`; "" if no known
    mistake does."""
    for of_units, words in (*_LARGER, *_SMALLER):
        # Within half an order of magnitude: mistakes of units are three orders apart.
        if abs(math.log10(max(factor, 1e-300) / of_units)) < 0.5:
            return f": about {of_units:,.6g} times what it could be, {words}"
    return ""


def _center(body: ShapedInertial) -> _Judgement:
    size = body.shapes.size
    share = outside(body.shapes, body.com) / size
    if share <= OUT:
        return _Judgement(share)
    inside = outside(body.shapes, 1e-3 * body.com) <= OUT * size
    guess = ": mm read as m?" if share > MILLIMETRES and inside else ""
    message = f"its centre of mass is {1e3 * share * size:.3g} mm outside its shape{guess}"
    return _judgement(body, share, share > FAR_OUT, "center", message)


def _density(body: ShapedInertial) -> _Judgement:
    volume = body.shapes.volume
    density = body.mass / volume
    if THIN <= density <= DENSE or body.mass < MIN_JUDGED_MASS:
        return _Judgement(density)
    message = f"{body.mass:.3g} kg within {1e6 * volume:.3g} cm³ is {density:.3g} kg/m³"
    if density > DENSE:
        guess = ": g read as kg, or a shape in m read as mm?" if density > 1e5 else ""
        return _judgement(body, density, density > TOO_DENSE, "mass", f"{message}, denser than lead{guess}")
    guess = ": a shape in mm read as m?" if density < TOO_THIN else ""
    return _judgement(body, density, density < TOO_THIN, "shape", f"{message}, next to nothing{guess}")
