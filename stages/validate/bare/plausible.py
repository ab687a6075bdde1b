"""Whether masses, inertias and shapes are of one size: a unit that was mixed up is off by a thousand."""

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from stages.robot.check import Finding
from stages.robot.model import Array
from stages.validate.bare.figures import ShapeFigures, WeighedBody, reach
from stages.validate.bare.findings import Coded
from stages.validate.bare.judged import STAND_IN

FAR, FAR_OUT = 5.0, 2.0
"""A radius of gyration of this many times the body's reach, or a center of mass this many times its size
outside of it, is that of another unit, as in a build's C-INERTIAL (kg·mm² for kg·m² makes the radius a
thousand times larger)."""

WIDE = 1.5
"""Above this ratio of the two the mass would lie outside of the shapes."""

NARROW = 0.02
"""Below this ratio all mass would be in one point."""

DENSEST = 25_000.0
"""Above this density [kg/m³] nothing is: osmium has 22,600."""

GRAMS = 60_000.0
"""Above this one the mass is in grams, as in a build's C-INERTIAL."""

LARGE = 30.0
"""A mesh of so many times the robot's reach is in millimetres."""

RATIO = 1000.0
"""Masses of neighbours above this ratio are hard to solve for."""


def look(bodies: Sequence[WeighedBody]) -> Iterator[Coded]:
    """Units that were mixed up, and what is implausible of masses and shapes."""
    robot = reach(bodies)
    sizes = [_size(one) for one in bodies if one.shapes]
    typical = float(np.median(sizes)) if sizes else 0.0
    said: set[str] = set()
    for body in bodies:
        for shape in body.shapes:
            if shape.mesh and shape.element not in said:
                for code, finding in _mesh(shape, body.name, robot, typical):
                    said.add(shape.element)
                    yield code, finding
        yield from _weighed(body)
        yield from _apart(body)
    yield from _neighbours(bodies)


def _size(body: WeighedBody) -> float:
    box = body.box()
    return 0.0 if box is None else float(np.linalg.norm(box[1] - box[0]))


def _mesh(shape: ShapeFigures, name: str, robot: float, typical: float) -> Iterator[Coded]:
    """A mesh that is far larger than the robot, and fits if its numbers are millimetres."""
    if robot < 1e-3 or shape.extent < LARGE * robot or shape.extent < 2.0:
        return
    message = (
        f'{shape.extent:.3g} m wide, on "{name}" of a robot whose joints span {robot:.2g} m: '
        "is it in millimetres? (scale 0.001 0.001 0.001)"
    )
    yield "C-UNITS", Finding(shape.element, shape.attribute, message)


def _weighed(body: WeighedBody) -> Iterator[Coded]:
    box = body.box()
    if box is None or body.marked or not body.mass > STAND_IN or not np.isfinite(body.com).all():
        return
    low, high = box
    size = float(np.linalg.norm(high - low))
    if size <= 0.0:
        return
    found = (*_centre(body, low, high, size), *_spread(body, low, high, size), *_dense(body, high - low))
    # What cannot be read may explain what is only odd.
    yield from (one for one in found if body.whole or one[0] == "C-UNITS")


def _centre(body: WeighedBody, low: Array, high: Array, size: float) -> Iterator[Coded]:
    off = float(np.linalg.norm(np.maximum(0.0, np.maximum(low - body.com, body.com - high))))
    if off > FAR_OUT * size:
        message = (
            f"the center of mass is {off:.3g} m from the shapes, {size:.2g} m wide: is it in millimetres?"
        )
        yield "C-UNITS", Finding(*body.com_at, message)
    elif off > 0.5 * size:
        message = f"the center of mass is {off:.3g} m outside of the shapes, which are {size:.2g} m wide"
        yield "C-PLAUSIBLE", Finding(*body.com_at, message)


def _spread(body: WeighedBody, low: Array, high: Array, size: float) -> Iterator[Coded]:
    largest = float(np.linalg.eigvalsh(body.inertia)[2])
    if not largest > 0.0 or not math.isfinite(largest):
        return
    radius = math.sqrt(largest / body.mass)
    farthest = float(np.linalg.norm(np.maximum(np.abs(low - body.com), np.abs(high - body.com))))
    shown = f"the radius of gyration {radius:.3g} m"
    if radius > FAR * max(farthest, size / 2):
        message = f"{shown} is {radius / farthest:.0f} times the reach of the shapes: is it in kg·mm²?"
        yield "C-UNITS", Finding(*body.inertia_at, message)
    elif radius > WIDE * farthest:
        message = f"{shown} is more than the shapes reach from the center of mass, {farthest:.3g} m"
        yield "C-PLAUSIBLE", Finding(*body.inertia_at, message)
    elif radius < NARROW * farthest:
        message = f"{shown} is that of a point beside the shapes, which reach {farthest:.3g} m"
        yield "C-PLAUSIBLE", Finding(*body.inertia_at, message)


def _dense(body: WeighedBody, widths: Array) -> Iterator[Coded]:
    volume = float(np.prod(widths))
    if volume <= 0.0:
        return
    density = body.mass / volume
    if density > GRAMS:
        message = f"{body.mass:g} kg in {volume:.2g} m³ is {density:.2g} kg/m³: is it in grams?"
        yield "C-UNITS", Finding(*body.mass_at, message)
    elif density > DENSEST:
        message = f"{body.mass:g} kg in {volume:.2g} m³ is {density:.2g} kg/m³, denser than any metal"
        yield "C-PLAUSIBLE", Finding(*body.mass_at, message)


def _apart(body: WeighedBody) -> Iterator[Coded]:
    """Colliders that are beside what is seen, or many times its size."""
    seen = body.box(collides=False)
    if seen is None or body.marked or not body.whole:
        return
    size = float(np.linalg.norm(seen[1] - seen[0]))
    for shape in body.shapes:
        if not shape.collides:
            continue
        low, high = shape.corners.min(axis=0), shape.corners.max(axis=0)
        gap = float(np.linalg.norm(np.maximum(0.0, np.maximum(seen[0] - high, low - seen[1]))))
        if gap > 0.1 * size:
            message = f'a collider of "{body.name}" is {gap:.3g} m beside what is seen, {size:.2g} m wide'
            yield "C-PLAUSIBLE", Finding(*shape.placed_by, message)
        elif shape.extent > 5.0 * size > 0.0:
            message = f'a collider of "{body.name}" is {shape.extent:.3g} m wide, what is seen {size:.2g} m'
            yield "C-PLAUSIBLE", Finding(shape.element, shape.attribute, message)


def _neighbours(bodies: Sequence[WeighedBody]) -> Iterator[Coded]:
    """What is fixed to a body counts with it: only what moves apart needs to be solved for."""
    by_name = {one.name: one for one in bodies}
    holder = {one.name: _holder(one, by_name) for one in bodies}
    masses: dict[str, float] = {}
    for body in bodies:
        masses[holder[body.name]] = masses.get(holder[body.name], 0.0) + body.mass
    for body in bodies:
        if holder[body.name] != body.name or body.parent not in holder:
            continue
        own, above = masses[body.name], masses[holder[body.parent]]
        if own > STAND_IN < above and max(own / above, above / own) > RATIO:
            ratio = max(own / above, above / own)
            message = f'{own:g} kg beside the {above:g} kg of "{holder[body.parent]}", {ratio:.2g} to 1'
            yield "C-PLAUSIBLE", Finding(*body.mass_at, message)


def _holder(body: WeighedBody, by_name: Mapping[str, WeighedBody]) -> str:
    seen = {body.name}
    while body.fixed and body.parent in by_name and body.parent not in seen:
        body = by_name[body.parent]
        seen.add(body.name)
    return body.name
