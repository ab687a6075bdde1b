"""Checks of a plan before its first stage runs."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path

from linkwright.pipeline.caching import actions
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import ConfigError, Diagnostic, as_problems
from linkwright.pipeline.output.folder import Output
from linkwright.pipeline.output.location import require_free
from linkwright.pipeline.output.manifest import DOCUMENTS
from linkwright.pipeline.show.live import ENGINE_FILE
from linkwright.pipeline.show.preview import require
from linkwright.pipeline.stages.stage import STAGES, Stage, stages_until
from linkwright.stages.export.section import expected_paths
from linkwright.stages.fetch import writes
from linkwright.stages.show.graph_view.views import PICTURE
from linkwright.stages.show.preview import names


def plan_problems(
    plan: Plan, environ: Mapping[str, str] = os.environ, stages: tuple[Stage, ...] = STAGES
) -> list[Diagnostic]:
    """The problems that the stages find before any work, such as a missing file or API key."""
    found: list[Diagnostic] = []
    for stage in stages_until(plan.until, stages):
        try:
            stage.preflight(plan, environ)
        except ConfigError as error:
            found += as_problems(error)
    try:
        require(plan.page.preview)
    except ConfigError as error:
        found += as_problems(error)
    return found


def destination(
    plan: Plan, environ: Mapping[str, str] = os.environ, report: Callable[[str], None] = lambda _: None
) -> Output:
    """The output folder of a build.

    ConfigError where no output folder can be there, or where it would replace files that are not
    linkwright's; OutputError where that cannot be checked.
    """
    output = Output(plan.folder, report, overwrite=plan.overwrite)
    source = getattr(plan.source, "path", None)
    taken = {"the source": Path(source)} if source else {}
    require_free(output.target, taken, actions.folder(plan.cache.dir, environ))
    output.judge(suffix_of(plan), expected_files(plan))
    return output


def suffix_of(plan: Plan) -> str:
    """The suffix of the output folder: `.<stage>` for a build that stops before the export, else ""."""
    return "" if plan.until in ("export", "validate") else f".{plan.until}"


def expected_files(plan: Plan) -> list[str]:
    """The paths of the output files that are known before the build starts."""
    files = [*DOCUMENTS]
    if plan.until != "fetch":
        files += ["robot.json", PICTURE]
    if not suffix_of(plan):
        files += [*expected_paths(plan, plan.name), *_of_page(plan), *names(plan.page.preview)]
    return files


def _of_page(plan: Plan) -> list[str]:
    return [ENGINE_FILE] if plan.page.live == "shared" else []


def sweep_problems(plan: Plan) -> list[Diagnostic]:
    """The problems of one job of a sweep: those of a build, and conflicts between jobs."""
    found = plan_problems(plan)
    if writes(plan):
        text = "a sweep must not change the document: its jobs would disturb each other"
        hint = "sweep source.configuration, or build one robot at a time"
        found.append(Diagnostic("E-VALUE", text, "source.variables", hint))
    return found
