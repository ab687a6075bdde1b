"""What is known to be wrong with a plan before its first stage runs."""

import os
from collections.abc import Mapping

from pipeline.errors import ConfigError, Diagnostic, as_problems
from pipeline.plan import Plan
from pipeline.stage import STAGES, Stage, stages_until


def beforehand(
    plan: Plan, environ: Mapping[str, str] = os.environ, stages: tuple[Stage, ...] = STAGES
) -> list[Diagnostic]:
    """The problems that the stages of a build know of before any work: a file or a key that is missing."""
    found: list[Diagnostic] = []
    for stage in stages_until(plan.until, stages):
        try:
            stage.preflight(plan, environ)
        except ConfigError as error:
            found += as_problems(error)
    return found


def before_a_sweep(plan: Plan) -> list[Diagnostic]:
    """The problems of one job of a sweep: those of a build, and what jobs must not do to each other."""
    from stages.fetch import writes

    found = beforehand(plan)
    if writes(plan):
        text = "a sweep must not change the document: its jobs would disturb each other"
        hint = "sweep source.configuration, or build one robot at a time"
        found.append(Diagnostic("E-VALUE", text, "source.variables", hint))
    return found
