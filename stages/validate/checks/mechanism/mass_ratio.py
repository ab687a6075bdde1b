"""Checks that no body is thousands of times heavier than its neighbour, or nearly massless by accident."""

from collections.abc import Iterator
from typing import Any

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import named

MAX_RATIO = 1000.0
"""Ratio of the masses of two bodies that a joint connects, above which solvers converge slowly."""

MIN_MASS = 1e-4
"""Mass [kg] below which a body is reported, unless CAD says so: it may be a stand-in that engines handle
badly."""

MASS_TOLERANCE = 1e-6
"""Relative tolerance within which a mass is that of CAD."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Yields warnings for robots with at least two bodies."""
    model = compiled.model
    pairs = [(body, _above(model, body)) for body in range(1, model.nbody) if model.body_mass[body] > 0.0]
    ratios = sorted(((_ratio(model, *pair), *pair) for pair in pairs if pair[1]), reverse=True)
    if ratios:
        worst, body, above = ratios[0]
        names = f"{model.body(body).name} and {model.body(above).name}"
        detail = f"of the masses of neighbours; the largest: {names}"
        findings = [_uneven(model, *ratio) for ratio in ratios if ratio[0] >= MAX_RATIO]
        yield compiled.result("mass ratio", worst < MAX_RATIO, detail, worst, MAX_RATIO, findings, "warning")
    light = [
        body for body, _ in pairs if model.body_mass[body] < MIN_MASS and not _is_intended(compiled, body)
    ]
    least = min((float(model.body_mass[body]) for body, _ in pairs), default=None)
    if least is not None:
        detail = f"the lightest body [kg]; fewer than {MIN_MASS:g} only where CAD says so"
        findings = [_tiny(model, body) for body in light]
        yield compiled.result("light bodies", not light, detail, least, MIN_MASS, findings, "warning")


def _above(model: Any, body: int) -> int:
    """Returns the nearest body above `body` that has a mass; 0 without such a body."""
    above = int(model.body_parentid[body])
    while above and model.body_mass[above] <= 0.0:
        above = int(model.body_parentid[above])
    return above


def _ratio(model: Any, body: int, above: int) -> float:
    masses = float(model.body_mass[body]), float(model.body_mass[above])
    return max(masses) / min(masses)


def _uneven(model: Any, ratio: float, body: int, above: int) -> Finding:
    light, heavy = sorted((body, above), key=lambda index: float(model.body_mass[index]))
    message = f"{model.body(heavy).name} is {ratio:,.0f} times as heavy as {model.body(light).name}"
    return Finding(named("body", model.body(light).name), "inertial mass", message)


def _tiny(model: Any, body: int) -> Finding:
    message = f"it weighs {float(model.body_mass[body]):.3g} kg, which is not what its parts weigh"
    return Finding(named("body", model.body(body).name), "inertial mass", message)


def _is_intended(compiled: CompiledModel, body: int) -> bool:
    """Tells whether the robot has a link of this mass, or the body is the carrier of a loop's dofs, which has
    a share of a link's mass."""
    name, mass = compiled.model.body(body).name, float(compiled.model.body_mass[body])
    loops = {f"{loop.name}_carrier" for loop in compiled.robot.loops}
    masses = [link.inertial.mass for link in compiled.robot.links if link.name == name]
    return name in loops or any(abs(expected - mass) <= MASS_TOLERANCE * expected for expected in masses)
