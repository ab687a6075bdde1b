"""What is known to be wrong with a plan before its first stage runs."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path

from pipeline.caching import actions
from pipeline.config.plan import Plan
from pipeline.errors import ConfigError, Diagnostic, as_problems
from pipeline.output.folder import Output
from pipeline.output.location import require_free
from pipeline.output.manifest import DOCUMENTS
from pipeline.stage import STAGES, Stage, stages_until
from stages.graph.view.views import PICTURE


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


def destination(
    plan: Plan, environ: Mapping[str, str] = os.environ, tell: Callable[[str], None] = lambda _: None
) -> Output:
    """Where a build puts what it makes.

    ConfigError where no output can be there, or where it would replace what is not linkwright's, as far
    as that is known beforehand; OutputError where that cannot be found out.
    """
    output = Output(plan.folder, tell, overwrite=plan.overwrite)
    source = getattr(plan.source, "path", None)
    taken = {"the source": Path(source)} if source else {}
    require_free(output.target, taken, actions.folder(plan.cache.dir, environ))
    output.judge(suffix_of(plan), foreseen(plan))
    return output


def suffix_of(plan: Plan) -> str:
    """What the name of the folder has at its end: where a build stops before it has a robot's files,
    the name of the stage."""
    return "" if plan.until in ("export", "validate") else f".{plan.until}"


def foreseen(plan: Plan) -> list[str]:
    """The paths of the files that a build leaves, as far as they are known before it starts."""
    files = [*DOCUMENTS]
    if plan.until != "fetch":
        files += ["robot.json", PICTURE]
    if not suffix_of(plan):
        from stages import export

        files += export.expected_paths(plan, plan.name)
    return files


def before_a_sweep(plan: Plan) -> list[Diagnostic]:
    """The problems of one job of a sweep: those of a build, and what jobs must not do to each other."""
    from stages.fetch import writes

    found = beforehand(plan)
    if writes(plan):
        text = "a sweep must not change the document: its jobs would disturb each other"
        hint = "sweep source.configuration, or build one robot at a time"
        found.append(Diagnostic("E-VALUE", text, "source.variables", hint))
    return found
