"""No body is thousands of times heavier than its neighbour, and none weighs next to nothing by accident."""

from collections.abc import Iterator
from typing import Any

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import named

RATIO = 1000.0
"""Of the masses of two bodies that a joint connects: from here on solvers converge slowly."""

LIGHT = 1e-4
"""A body below this mass [kg] has it from CAD, or is a stand-in that no engine likes."""

SAME = 1e-6
"""Relative difference of a mass from that of CAD."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Warnings. None for a single body."""
    model = compiled.model
    pairs = [(body, _above(model, body)) for body in range(1, model.nbody) if model.body_mass[body] > 0.0]
    ratios = sorted(((_ratio(model, *pair), *pair) for pair in pairs if pair[1]), reverse=True)
    if ratios:
        worst, body, above = ratios[0]
        names = f"{model.body(body).name} and {model.body(above).name}"
        detail = f"of the masses of neighbours; the largest: {names}"
        findings = [_uneven(model, *one) for one in ratios if one[0] >= RATIO]
        yield compiled.result("mass ratio", worst < RATIO, detail, worst, RATIO, findings, "warning")
    light = [body for body, _ in pairs if model.body_mass[body] < LIGHT and not _meant(compiled, body)]
    least = min((float(model.body_mass[body]) for body, _ in pairs), default=None)
    if least is not None:
        detail = f"the lightest body [kg]; fewer than {LIGHT:g} only where CAD says so"
        findings = [_tiny(model, body) for body in light]
        yield compiled.result("light bodies", not light, detail, least, LIGHT, findings, "warning")


def _above(model: Any, body: int) -> int:
    """The nearest body above one that has a mass; 0 for none."""
    above = int(model.body_parentid[body])
    while above and model.body_mass[above] <= 0.0:
        above = int(model.body_parentid[above])
    return above


def _ratio(model: Any, body: int, above: int) -> float:
    masses = float(model.body_mass[body]), float(model.body_mass[above])
    return max(masses) / min(masses)


def _uneven(model: Any, ratio: float, body: int, above: int) -> Finding:
    light, heavy = sorted((body, above), key=lambda one: float(model.body_mass[one]))
    words = f"{model.body(heavy).name} is {ratio:,.0f} times as heavy as {model.body(light).name}"
    return Finding(named("body", model.body(light).name), "inertial mass", words)


def _tiny(model: Any, body: int) -> Finding:
    words = f"it weighs {float(model.body_mass[body]):.3g} kg, which is not what its parts weigh"
    return Finding(named("body", model.body(body).name), "inertial mass", words)


def _meant(compiled: CompiledModel, body: int) -> bool:
    """Whether the robot has a link of this mass, or the body carries the dofs of one of its loops, with a
    share of a link's mass."""
    name, mass = compiled.model.body(body).name, float(compiled.model.body_mass[body])
    loops = {f"{loop.name}_carrier" for loop in compiled.robot.loops}
    known = [link.inertial.mass for link in compiled.robot.links if link.name == name]
    return name in loops or any(abs(one - mass) <= SAME * one for one in known)
