"""Runs a single build: five stages in order, with the cached result of each unchanged stage."""

import functools
import os
import traceback
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from linkwright.pipeline import interrupt, report
from linkwright.pipeline.caching import actions
from linkwright.pipeline.caching.actions import Action
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import (
    ConfigError,
    InTheWay,
    LinkwrightError,
    as_problems,
    refusal,
)
from linkwright.pipeline.output.folder import FAILED, Output
from linkwright.pipeline.output.room import require_room
from linkwright.pipeline.report import Report
from linkwright.pipeline.run.early_imports import EarlyImports
from linkwright.pipeline.run.preflight import destination, expected_files, plan_problems, suffix_of
from linkwright.pipeline.run.products import products
from linkwright.pipeline.run.state import Run
from linkwright.pipeline.stages.context import ROBOT, BuildContext
from linkwright.pipeline.stages.stage import STAGES, Stage, stages_until
from linkwright.pipeline.terminal.progress import Log, Progress, Quiet, Tee
from linkwright.stages.fetch import remarks
from linkwright.stages.fetch.onshape.api.ledger import FOLDER as LEDGER


@dataclass(frozen=True, slots=True)
class BuildResult:
    """A finished build in memory."""

    report: Report
    files: Mapping[str, bytes]
    """The robot's files by relative path."""

    robot: bytes | None
    """The robot as the graph stage encoded it; None if the build stopped before."""

    documents: Mapping[str, bytes]
    """The documents about the build; empty for a build that writes no folder."""

    run: Run
    actions: Mapping[str, Action]
    """The actions of the stages, without stages whose result is not kept."""


def build(
    plan: Plan,
    progress: Progress | None = None,
    environ: Mapping[str, str] | None = None,
    stages: tuple[Stage, ...] = STAGES,
    sweep: Path | None = None,
) -> Report:
    """Builds the robot that `plan` describes and writes its output folder.

    Returns the report, whose `exit_status` is 3 if a check failed or an older state was used.
    Raises ConfigError for errors found before the first stage, and another LinkwrightError for later errors;
    then the last good output is unchanged, and `<output>.failed` holds the report and the log. `sweep`: the
    folder of the sweep that this job belongs to, with the engine that the pages of its jobs share.
    """
    return build_files(plan, progress, environ, stages, sweep=sweep).report


def build_files(
    plan: Plan,
    progress: Progress | None = None,
    environ: Mapping[str, str] | None = None,
    stages: tuple[Stage, ...] = STAGES,
    in_memory: bool = False,
    sweep: Path | None = None,
) -> BuildResult:
    """Builds as `build` does, and returns the files. `in_memory`: whether to write no output folder, even
    after a failure."""
    environ = os.environ if environ is None else environ
    stages = stages_until(plan.until, stages)
    suffix = suffix_of(plan)
    log = Log(environ)
    run = Run(plan, "" if in_memory else f"{plan.folder}{suffix}", log, Tee(log, progress or Quiet()))
    output = prepare_output(run, environ, stages, in_memory)
    run.note(remarks(plan))
    files: dict[str, bytes] = {}
    documents: dict[str, bytes] = {}
    try:
        with actions.opened(plan.cache.mode, plan.cache.dir, environ) as store:
            # Beside the permanent cache, even if this build does not use that cache.
            ledger = actions.folder(plan.cache.dir, environ) / LEDGER
            context = BuildContext(plan, store, environ, ledger=ledger)
            ahead = EarlyImports({stage.name: stage.modules for stage in stages})
            context.import_ahead = ahead.start
            context.require_room = functools.partial(require_room, store.store, output, suffix)
            with ahead:
                for stage in stages:
                    ahead.wait(stage.name)
                    run.stage(stage, context)
                    if output and stage.name == "export":
                        run.begin_drawing(context)
            files = products(context)
            log.secrets.check(files)
            if output:
                run.make_live_view(context, sweep)
                run.finish_drawing()
            finished_report = run.success_report(context, files)
            robot = context.files["graph"][ROBOT] if "graph" in context.files else None
            if output:
                documents = run.documents(finished_report, files, output.folder(suffix))
                interrupt.check()
                all_files = {**files, **run.live_view.files, **run.pictures.files, **documents}
                output.publish(all_files, suffix, finished_report.outputs)
    except Exception as error:
        if interrupt.is_cause_of(error):
            raise KeyboardInterrupt from error
        # A result that cannot be moved into the output folder is kept there.
        leave_failure(output, run, error, files if isinstance(error, InTheWay) else {})
        raise
    finally:
        run.drawing.end()
        run.progress.close()
    if output:
        output.remove(FAILED)
    return BuildResult(finished_report, files, robot, documents, run, context.actions)


def prepare_output(
    run: Run, environ: Mapping[str, str], stages: tuple[Stage, ...], in_memory: bool
) -> Output | None:
    """Prepares and returns the output folder; None for a build in memory. Raises ConfigError with all
    problems that are known before the first stage."""
    problems = plan_problems(run.plan, environ, stages)
    output = None
    try:
        if not in_memory:
            output = destination(run.plan, environ, lambda line: run.progress.detail("output", line))
    except ConfigError as error:
        if not problems:
            raise
        problems += as_problems(error)
    if problems:
        raise refusal(problems)
    if output:
        output.prepare(suffix_of(run.plan), expected_files(run.plan))
    return output


def leave_failure(output: Output | None, run: Run, error: Exception, files: Mapping[str, bytes]) -> None:
    """Writes the report and the log of a failed build, and its `files`, beside the last good output. A build
    in memory writes nothing; the error's notes list its API calls."""
    for line in str(error).splitlines():
        run.log.line(line)
    if not isinstance(error, LinkwrightError):
        for line in "".join(traceback.format_exception(error)).splitlines():
            run.log.line(line)
    failure_report = run.failure_report(error)
    failure_folder = None
    try:
        if output:
            failure_folder = output.publish({**files, **run.documents(failure_report, files)}, FAILED)
    except LinkwrightError as write_error:
        # The first error is raised.
        run.progress.detail("output", f"no report of this failure could be written: {write_error}")
    else:
        for line in report.failure_lines(failure_report, failure_folder):
            error.add_note(line)
