"""Checks the mass ratio of neighbouring bodies, and finds bodies that are nearly massless by accident."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import named

MAX_RATIO = 1000.0
"""Ratio of the masses of two bodies that a joint connects, above which solvers converge slowly."""

MIN_MASS = 1e-4
"""Mass [kg] below which a body is reported, unless its link has that mass: it may be a placeholder, which
engines simulate badly."""

MASS_TOLERANCE = 1e-6
"""Relative tolerance within which a body has the mass of its link."""


class _NeighbourPair(NamedTuple):
    """A body and the nearest body above it that has mass. Pairs are ordered by their ratio."""

    ratio: float
    """The mass of the heavier body, divided by the mass of the other."""

    body: int
    parent: int


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Checks the mass ratio of neighbouring bodies, and that no body is nearly massless unless its link is.
    Both results are warnings if they fail."""
    bodies = [body for body in range(1, compiled.model.nbody) if compiled.model.body_mass[body] > 0.0]
    if bodies:
        yield from _ratio_check(compiled, bodies)
        yield _light_check(compiled, bodies)


def _ratio_check(compiled: CompiledModel, bodies: Sequence[int]) -> Iterator[Check]:
    model = compiled.model
    pairs = sorted((pair for body in bodies if (pair := _pair(model, body)) is not None), reverse=True)
    if pairs:
        worst = pairs[0]
        detail = (
            "largest ratio of the masses of neighbouring bodies, "
            f"{model.body(worst.body).name} and {model.body(worst.parent).name}"
        )
        findings = [_ratio_finding(model, pair) for pair in pairs if pair.ratio >= MAX_RATIO]
        passed = worst.ratio < MAX_RATIO
        yield compiled.result("mass ratio", passed, detail, worst.ratio, MAX_RATIO, findings, "warning")


def _light_check(compiled: CompiledModel, bodies: Sequence[int]) -> Check:
    masses = {body: float(compiled.model.body_mass[body]) for body in bodies}
    light = [body for body in bodies if masses[body] < MIN_MASS and not _is_intended(compiled, body)]
    detail = (
        f"mass [kg] of the lightest body; less than {MIN_MASS:g} is accepted only if the link is as light"
    )
    findings = [_light_finding(compiled.model, body) for body in light]
    smallest = min(masses.values())
    return compiled.result("light bodies", not light, detail, smallest, MIN_MASS, findings, "warning")


def _pair(model: Any, body: int) -> _NeighbourPair | None:
    """Returns the pair of a body and the nearest body above it that has mass; None if only the world is
    above."""
    parent = int(model.body_parentid[body])
    while parent and model.body_mass[parent] <= 0.0:
        parent = int(model.body_parentid[parent])
    if not parent:
        return None
    masses = float(model.body_mass[body]), float(model.body_mass[parent])
    return _NeighbourPair(max(masses) / min(masses), body, parent)


def _ratio_finding(model: Any, pair: _NeighbourPair) -> Finding:
    light, heavy = sorted((pair.body, pair.parent), key=lambda index: float(model.body_mass[index]))
    message = f"{model.body(heavy).name} is {pair.ratio:,.0f} times as heavy as {model.body(light).name}"
    return Finding(named("body", model.body(light).name), "inertial mass", message)


def _light_finding(model: Any, body: int) -> Finding:
    mass = float(model.body_mass[body])
    message = f"its mass is {mass:.3g} kg, which no link of this name has"
    return Finding(named("body", model.body(body).name), "inertial mass", message)


def _is_intended(compiled: CompiledModel, body: int) -> bool:
    """Tells whether the link of this name has this mass, or the body carries the dofs of a loop, and so has
    only a share of a link's mass."""
    name, mass = compiled.model.body(body).name, float(compiled.model.body_mass[body])
    # The MJCF export adds these bodies: see `export/mjcf/loops.py`.
    carriers = {f"{loop.name}_carrier" for loop in compiled.robot.loops}
    masses = [link.inertial.mass for link in compiled.robot.links if link.name == name]
    return name in carriers or any(abs(expected - mass) <= MASS_TOLERANCE * expected for expected in masses)
