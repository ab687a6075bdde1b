"""Checks that the model is stable from `home` at half and at double its time step.

Each run takes 0.5 s; with `validate=strict` 2 s.
"""

from collections.abc import Iterator

from linkwright.stages.mujoco.trial import MAX_OPENING, trial_run
from linkwright.stages.robot.check import Check, CheckLevel
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import unstable
from linkwright.stages.validate.simulate.running import with_options

SECONDS, STRICT_SECONDS = 0.5, 2.0
"""Length of each run [s]: by default, and with `validate=strict`."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Yields an error if the model is unstable at half the step, since a model that only a longer step keeps
    stable is wrong. Yields a warning if it is unstable at double the step, since its margin is small."""
    model = compiled.model
    if not model.nv:
        return
    seconds = STRICT_SECONDS if compiled.options.strict else SECONDS
    step = float(model.opt.timestep)
    for name, factor in (("half", 0.5), ("double", 2.0)):
        with with_options(model, timestep=factor * step):
            trial = trial_run(model, seconds)
        detail = f"{trial.time:.3g} s with steps of {factor * step:g} s; loops opened by at most [m, rad]"
        findings = []
        if trial.failed:
            where = f" at {', '.join(trial.joints[:3])}" if trial.joints else ""
            detail = f"with steps of {factor * step:g} s, after {trial.time:.3g} s {trial.failed}{where}"
            message = f"{trial.failed} with {name} the time step, after {trial.time:.3g} s"
            findings = [unstable(trial.joint, message)]
        level: CheckLevel = "error" if name == "half" else "warning"
        yield compiled.result(
            f"{name} the time step", not trial.failed, detail, trial.opening, MAX_OPENING, findings, level
        )
