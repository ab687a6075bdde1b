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

MAX_DUMMY_MASS = 1e-6
"""Largest mass [kg] of a body that only represents a frame. Its inertial is not judged."""

MAX_MARKER_SIZE = 0.02
"""Size [m] below which shapes without a mesh may only mark a link, and not show its form."""

DOUBTFUL_GYRATION, IMPOSSIBLE_GYRATION = 1.05, 5.0
"""Limits of the radius of gyration, as a share of the shapes' reach: above the first, mass within the shapes
cannot explain it; above the second, no unseen part can either. An inertia that is 1000 times too large makes
it √1000 ≈ 32 times too large."""

MIN_GYRATION = 0.05
"""Smallest radius of gyration, as a share of the reach: solid bodies have 0.3 to 0.7, and a body with its
mass in one spot has almost 0."""

TYPICAL_GYRATION = 0.5
"""Radius of gyration of a solid body, as a share of the reach: guesses at confused units start from it."""

DOUBTFUL_OFFSET, IMPOSSIBLE_OFFSET = 0.1, 2.0
"""Distances of the centre of mass outside the shapes, as a share of their size, above which it is doubtful,
and above which it is impossible: an unseen part may pull it out a little, but not far."""

MIN_MILLIMETRE_OFFSET = 30.0
"""Distance of the centre of mass outside the shapes, as a share of their size, above which it may be in mm
and was read in metres."""

DOUBTFUL_DENSITY, IMPOSSIBLE_DENSITY = 12_000.0, 60_000.0
"""Limits of the density in a box around the shapes [kg/m³]: denser than lead, and far denser than any metal
(osmium has 22,600)."""

DOUBTFUL_LOW_DENSITY, IMPOSSIBLE_LOW_DENSITY = 1.0, 0.05
"""Lower limits of that density [kg/m³]: that of an empty frame, and half of hydrogen's."""

MIN_JUDGED_MASS = 1e-3
"""Mass [kg] below which a body may be only a visual marker, so that its density does not matter."""

_LARGER = ((1e3, "g m² read as kg m²?"), (1e6, "kg mm² read as kg m²?"), (1e9, "g mm² read as kg m²?"))
"""(factor, text): the factor by which a mistake of units makes an inertia too large."""

_SMALLER = ((1e-3, "a mass in g read as kg?"), (1e-6, "an inertia of a shape in mm?"))
"""(factor, text): the factor by which a mistake of units makes an inertia too small."""

Quantity = Literal["inertia", "centre", "mass", "shape"]


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
    is_impossible: bool = False
    """Whether the value is impossible; otherwise a finding is only a doubt."""

    finding: Finding | None = None


def checks(file: str, bodies: Iterable[ShapedInertial]) -> Iterator[Check]:
    """Yields up to three results, or nothing if no body can be judged."""
    judged_bodies = [body for body in bodies if body.mass > MAX_DUMMY_MASS and not _is_marker(body.shapes)]
    with_inertia = [body for body in judged_bodies if body.moments.any()]
    # Flat shapes have no volume, and so no density.
    with_volume = [body for body in judged_bodies if body.shapes.volume > (1e-3 * body.shapes.size) ** 3]
    body_count = count(len(judged_bodies), "body", "bodies")
    gyrations = [_gyration(body) for body in with_inertia]
    centres = [_centre(body) for body in judged_bodies]
    densities = [_density(body) for body in with_volume]
    gyration_words = "radius of gyration as a share of the shape's reach"
    centre_words = "how far out as a share of the shape's size"
    density_words = "mass in a box around the shape [kg/m³]"
    for title, judgements, limit, words in (
        ("inertia fits the shape", gyrations, DOUBTFUL_GYRATION, gyration_words),
        ("centre of mass in the shape", centres, DOUBTFUL_OFFSET, centre_words),
        ("density of matter", densities, DOUBTFUL_DENSITY, density_words),
    ):
        if judgements:
            yield from _results(f"{file}: {title}", judgements, limit, f"{words}, of {body_count}")


def _is_marker(shapes: BodyExtents) -> bool:
    return shapes.size == 0.0 or (shapes.size < MAX_MARKER_SIZE and not shapes.has_mesh)


def _results(name: str, judgements: Sequence[_Judgement], limit: float, words: str) -> Iterator[Check]:
    """Yields an error for impossible values and a warning for doubtful values, or else a passed result."""
    impossible = [judgement for judgement in judgements if judgement.is_impossible]
    doubtful = [judgement for judgement in judgements if judgement.finding and not judgement.is_impossible]
    if impossible:
        yield _failed_check(name, impossible, limit, "error")
    if doubtful:
        yield _failed_check(f"{name}, doubtful" if impossible else name, doubtful, limit, "warning")
    if not impossible and not doubtful:
        value = max(judgement.value for judgement in judgements)
        yield Check(name, True, f"{words}: at most {value:.3g}", value, limit, CODE)


def _failed_check(name: str, judgements: Sequence[_Judgement], limit: float, level: CheckLevel) -> Check:
    findings = tuple(judgement.finding for judgement in judgements if judgement.finding)
    detail = "; ".join(f"{finding.element}: {finding.message}" for finding in findings[:3])
    return Check(name, False, detail, judgements[0].value, limit, CODE, level, findings)


def _judgement(
    body: ShapedInertial, value: float, is_impossible: bool, quantity: Quantity, message: str
) -> _Judgement:
    """Returns the judgement of a value with a finding; without one if the value is only doubtful and the body
    is fixed."""
    if not body.moves and not is_impossible:
        return _Judgement(value)
    return _Judgement(value, is_impossible and body.moves, Finding(*body.places[quantity], message))


def _gyration(body: ShapedInertial) -> _Judgement:
    reach = reaches(body.shapes, body.com, body.axes)
    # The lower bound of the reach keeps the share finite for shapes on the axis.
    shares = np.sqrt(np.maximum(body.moments, 0.0) / body.mass) / np.maximum(reach, 1e-6 * body.shapes.size)
    worst = int(shares.argmax())
    share = float(shares[worst])
    if MIN_GYRATION <= share <= DOUBTFUL_GYRATION:
        return _Judgement(share)
    radius = 1e3 * math.sqrt(max(0.0, body.moments[worst]) / body.mass)
    message = f"its radius of gyration is {radius:.3g} mm, but its shape reaches {1e3 * reach[worst]:.3g} mm"
    message += f" from that axis{_guess((share / TYPICAL_GYRATION) ** 2)}"
    # NaN is impossible too.
    return _judgement(body, share, not share <= IMPOSSIBLE_GYRATION, "inertia", message)


def _guess(factor: float) -> str:
    """Returns a text on the mistake of units that multiplies an inertia by about `factor`; "" if no known
    mistake does."""
    for unit_factor, words in (*_LARGER, *_SMALLER):
        # Within half an order of magnitude: mistakes of units are three orders apart.
        if abs(math.log10(max(factor, 1e-300) / unit_factor)) < 0.5:
            return f": about {unit_factor:,.6g} times a plausible value, {words}"
    return ""


def _centre(body: ShapedInertial) -> _Judgement:
    size = body.shapes.size
    share = outside(body.shapes, body.com) / size
    if share <= DOUBTFUL_OFFSET:
        return _Judgement(share)
    inside = outside(body.shapes, 1e-3 * body.com) <= DOUBTFUL_OFFSET * size
    guess = ": mm read as m?" if share > MIN_MILLIMETRE_OFFSET and inside else ""
    message = f"its centre of mass is {1e3 * share * size:.3g} mm outside its shape{guess}"
    return _judgement(body, share, share > IMPOSSIBLE_OFFSET, "centre", message)


def _density(body: ShapedInertial) -> _Judgement:
    volume = body.shapes.volume
    density = body.mass / volume
    if DOUBTFUL_LOW_DENSITY <= density <= DOUBTFUL_DENSITY or body.mass < MIN_JUDGED_MASS:
        return _Judgement(density)
    message = f"{body.mass:.3g} kg within {1e6 * volume:.3g} cm³ is {density:.3g} kg/m³"
    if density > DOUBTFUL_DENSITY:
        guess = ": g read as kg, or a shape in m read as mm?" if density > 1e5 else ""
        message += f", denser than lead{guess}"
        return _judgement(body, density, density > IMPOSSIBLE_DENSITY, "mass", message)
    guess = ": a shape in mm read as m?" if density < IMPOSSIBLE_LOW_DENSITY else ""
    message += f", too light for any structure{guess}"
    return _judgement(body, density, density < IMPOSSIBLE_LOW_DENSITY, "shape", message)
