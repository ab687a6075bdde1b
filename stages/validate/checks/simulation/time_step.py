"""The model stays whole from `home` at half its time step, and at double: it does not owe that to its step.

For 0.5 s each; with `validate=strict` for 2 s.
"""

from collections.abc import Iterator

from linkwright.stages.mujoco.trial import OPEN, trial_run
from linkwright.stages.robot.check import Check, CheckLevel
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import unstable
from linkwright.stages.validate.simulate.running import with_options

SECONDS, STRICT_SECONDS = 0.5, 2.0


def check(compiled: CompiledModel) -> Iterator[Check]:
    """At half the step an error: what only a longer step keeps whole is a mistake of its solution. At double
    the step a warning: it has little to spare."""
    model = compiled.model
    if not model.nv:
        return
    seconds = STRICT_SECONDS if compiled.asked.strict else SECONDS
    step = float(model.opt.timestep)
    for name, factor in (("half", 0.5), ("double", 2.0)):
        with with_options(model, timestep=factor * step):
            trial = trial_run(model, seconds)
        detail = f"{trial.time:.3g} s with steps of {factor * step:g} s; loops opened by at most [m, rad]"
        findings = []
        if trial.failed:
            where = f" at {', '.join(trial.joints[:3])}" if trial.joints else ""
            detail = f"with steps of {factor * step:g} s, after {trial.time:.3g} s {trial.failed}{where}"
            words = f"{trial.failed} with {name} the time step, after {trial.time:.3g} s"
            findings = [unstable(trial.joint, words)]
        level: CheckLevel = "error" if name == "half" else "warning"
        yield compiled.result(
            f"{name} the time step", not trial.failed, detail, trial.opening, OPEN, findings, level
        )
