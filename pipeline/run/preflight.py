"""Checks a plan before its first stage runs."""

import os
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from linkwright.pipeline.caching import actions
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import ConfigError, Diagnostic, as_problems
from linkwright.pipeline.objective.value import require as require_objective
from linkwright.pipeline.output.folder import Output
from linkwright.pipeline.output.location import require_free
from linkwright.pipeline.output.manifest import DOCUMENTS
from linkwright.pipeline.show.live import ENGINE_FILE
from linkwright.pipeline.show.preview import require as require_preview_library
from linkwright.pipeline.stages.stage import STAGES, Stage, stages_until
from linkwright.stages.export.section import expected_paths
from linkwright.stages.fetch import changes_document, is_remote
from linkwright.stages.show.graph_view.views import PICTURE
from linkwright.stages.show.preview import names as preview_names


def plan_problems(
    plan: Plan, environ: Mapping[str, str] = os.environ, stages: tuple[Stage, ...] = STAGES
) -> list[Diagnostic]:
    """Returns the problems of a plan that are known before any stage runs, such as a missing file or API
    key."""
    checks: list[Callable[[], None]] = [
        *(partial(stage.preflight, plan, environ) for stage in stages_until(plan.until, stages)),
        partial(require_preview_library, plan.page.preview),
        partial(require_objective, plan),
    ]
    problems: list[Diagnostic] = []
    for check in checks:
        try:
            check()
        except ConfigError as error:
            problems += as_problems(error)
    return problems


def destination(
    plan: Plan, environ: Mapping[str, str] = os.environ, report: Callable[[str], None] = lambda _: None
) -> Output:
    """Returns the output folder of a build; `report` gets lines about it.

    Raises ConfigError if no output folder can be at its path, or if the build would replace files that
    Linkwright did not write; raises OutputError if the existing files cannot be examined.
    """
    output = Output(plan.folder, report, overwrite=plan.overwrite)
    # Only sources that are files have a path.
    source_path = getattr(plan.source, "path", None)
    paths_in_use = {"the source": Path(source_path)} if source_path else {}
    require_free(output.target, paths_in_use, actions.folder(plan.cache.dir, environ))
    output.judge(suffix_of(plan), expected_files(plan))
    return output


def suffix_of(plan: Plan) -> str:
    """Returns the suffix of the output folder: `.<stage>` for a build that stops before the export, or ""."""
    return "" if plan.until in ("export", "validate") else f".{plan.until}"


def expected_files(plan: Plan) -> list[str]:
    """Returns the paths of the output files that are known before the build starts."""
    files = [*DOCUMENTS]
    if plan.until != "fetch":
        files += ["robot.json", PICTURE]
    if not suffix_of(plan):
        files += [*expected_paths(plan, plan.name), *_engine_files(plan), *preview_names(plan.page.preview)]
    return files


def _engine_files(plan: Plan) -> list[str]:
    """Returns the file of the viewer's engine, in a list; [] if the page contains it or has no viewer."""
    return [ENGINE_FILE] if plan.page.live == "shared" else []


def job_problems(plan: Plan) -> list[Diagnostic]:
    """Returns the problems of a job of a sweep: those of its build, and settings that no sweep allows."""
    return [*plan_problems(plan), *_sweep_only_problems(plan)]


def offline_job_problems(plan: Plan) -> list[Diagnostic]:
    """Returns the problems of a job of a sweep that asks no server, and so needs no API key."""
    if not is_remote(plan):
        return job_problems(plan)
    offline_source = plan.source.model_copy(update={"offline": True, "refresh": False})
    return [*plan_problems(plan.model_copy(update={"source": offline_source})), *_sweep_only_problems(plan)]


def _sweep_only_problems(plan: Plan) -> list[Diagnostic]:
    """Returns a problem for each setting of a plan that a build allows and a sweep does not."""
    problems = []
    if changes_document(plan):
        text = "a sweep must not change the document: its jobs would disturb each other"
        hint = "sweep source.configuration, or build one robot at a time"
        problems.append(Diagnostic("E-VALUE", text, "source.variables", hint))
    if is_remote(plan) and plan.cache.mode == "bypass":
        text = "a sweep needs the cache: it fetches the source once, and its jobs build from the cache"
        hint = "leave it out; cache.dir=FOLDER names another cache"
        problems.append(Diagnostic("E-VALUE", text, "cache.mode", hint))
    return problems
