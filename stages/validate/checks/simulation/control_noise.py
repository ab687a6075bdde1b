"""Checks that the model stays stable under noise over the full range of every control, as in the exploration
of a learning policy.

It runs for 1 s; with `validate=strict` for 10 s.
"""

from collections.abc import Iterator

from linkwright.stages.robot.check import Check
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import unstable
from linkwright.stages.validate.simulate.noise import run_with_noise

SECONDS, STRICT_SECONDS = 1.0, 10.0
"""Length of the run [s]: by default, and with `validate=strict`."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Runs models with actuators under noise."""
    model = compiled.model
    if not model.nu:
        return
    run = run_with_noise(model, STRICT_SECONDS if compiled.options.strict else SECONDS)
    detail = f"{run.time:.3g} s of noise over the range of each control without a warning"
    findings = []
    if run.failure:
        detail = f"after {run.time:.3g} s of noise {run.failure}{' at ' + run.joint if run.joint else ''}"
        hint = "less gain or force, more armature or damping, or a shorter step would help"
        findings = [unstable(run.joint, f"{run.failure}: {hint}")]
    yield compiled.result("control noise", not run.failure, detail, findings=findings)
