"""Checks that the robot keeps its energy if nothing dissipates it, as a consistent mechanism does.

It moves without contacts, limits, friction, damping, springs, closed loops and actuators, from seeded speeds.
"""

from collections.abc import Iterator

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.simulate.energy import MAX_DRIFT, drift_of_energy


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Checks models with dofs. A drift above `MAX_DRIFT` passes if it shrinks with the step, as the error of
    the integrator does."""
    model = compiled.model
    if not model.nv:
        return
    drift = drift_of_energy(model)
    step, value = drift.by_step[-1]
    detail = f"drift per second relative to the largest kinetic energy, with steps of {step:g} s"
    if value >= MAX_DRIFT and drift.is_conserved:
        detail += f"; with twice the step {drift.by_step[-2][1]:.2g}: the integrator's own"
    message = f"the passive robot gains or loses {value:.2g} of its kinetic energy in a second"
    findings = [
        Finding("option", "timestep", f"{message}, with steps of {step:g} s: see the lightest bodies")
    ]
    limit = None if drift.is_conserved and value >= MAX_DRIFT else MAX_DRIFT
    yield compiled.result("energy", drift.is_conserved, detail, value, limit, findings)
