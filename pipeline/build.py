"""One build: five stages in order; a stage whose inputs did not change comes from the cache."""

import functools
import json
import os
import time
import traceback
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pipeline import interrupt, report
from pipeline.caching import actions, bundles
from pipeline.config.choices import name_of
from pipeline.config.plan import Plan
from pipeline.context import NOTES, ROBOT, BuildContext
from pipeline.documents import documents
from pipeline.early_imports import Ahead
from pipeline.errors import (
    ConfigError,
    InTheWay,
    LinkwrightError,
    SecretFound,
    as_problems,
    exit_status,
    refusal,
)
from pipeline.live.made import NOTHING, Live, is_plain, live
from pipeline.mesh_details import kept
from pipeline.output.folder import FAILED, Output
from pipeline.output.room import require_room
from pipeline.preflight import destination, expected_files, plan_problems, suffix_of
from pipeline.preview import NONE, Preview, preview
from pipeline.products import digests, products
from pipeline.progress import Log, Progress, Quiet, Tee
from pipeline.report import Report, StageReport, Status
from pipeline.stage import STAGES, Stage, libraries, perform, stages_until
from pipeline.strictness import strict_checks
from stages.fetch import describe, remarks
from stages.fetch.onshape.api.ledger import FOLDER as LEDGER
from stages.graph.view.views import OUTLINE, VIEWS
from stages.mesh.view.views import PICTURES
from stages.robot import codec
from stages.robot.check import Check
from stages.robot.errors import Diagnostic


@dataclass(frozen=True, slots=True)
class Built:
    """A build in memory: its report, the robot's files by relative path, and the robot as the graph stage
    encoded it (None where the build stopped before)."""

    report: Report
    files: Mapping[str, bytes]
    robot: bytes | None


def build(
    plan: Plan,
    progress: Progress | None = None,
    environ: Mapping[str, str] | None = None,
    stages: tuple[Stage, ...] = STAGES,
    began: float | None = None,
    sweep: Path | None = None,
) -> Report:
    """Builds the robot that `plan` describes and writes its output folder.

    Returns the report, whose `exit_status` is 3 where a check failed or an older state was used.
    Raises ConfigError for errors found before the first stage, and another LinkwrightError for later
    errors; then the last good output is unchanged, and `<output>.failed` holds the report and the log.

    `began` [s since the epoch]: the start of the sweep that this job belongs to; its jobs share the
    replies of a workspace since then, so that all build the same state of it. `sweep`: the sweep's folder,
    with the engine that their pages share.
    """
    return build_files(plan, progress, environ, stages, began, sweep=sweep).report


def build_files(
    plan: Plan,
    progress: Progress | None = None,
    environ: Mapping[str, str] | None = None,
    stages: tuple[Stage, ...] = STAGES,
    began: float | None = None,
    in_memory: bool = False,
    sweep: Path | None = None,
) -> Built:
    """As `build`, and returns the files; `in_memory`: writes no output folder, even after a failure."""
    environ = os.environ if environ is None else environ
    stages = stages_until(plan.until, stages)
    suffix = suffix_of(plan)
    log = Log(environ)
    run = Run(plan, "" if in_memory else f"{plan.folder}{suffix}", log, Tee(log, progress or Quiet()))
    output = prepared(run, environ, stages, in_memory)
    run.note(remarks(plan))
    files: dict[str, bytes] = {}
    try:
        with actions.opened(plan.cache.mode, plan.cache.dir, environ) as store:
            # Beside the permanent cache, even if this build does not use that cache.
            ledger = actions.folder(plan.cache.dir, environ) / LEDGER
            context = BuildContext(plan, store, environ, ledger=ledger, began=began)
            ahead = Ahead(module for stage in stages for module in stage.modules)
            context.import_ahead = ahead.start
            context.require_room = functools.partial(require_room, store.store, output, suffix)
            with ahead:
                for stage in stages:
                    run.stage(stage, context)
                    ahead.wait()
            files = products(context)
            log.secrets.check(files)
            if output:
                run.look(context, sweep)
                run.draw(context, files)
            done = run.finished(context, files)
            robot = context.files["graph"][ROBOT] if "graph" in context.files else None
            if output:
                whole = {**files, **run.seen.files, **run.pictures.files}
                whole |= run.documents(done, files, output.folder(suffix))
                interrupt.check()
                output.publish(whole, suffix, done.outputs)
    except Exception as error:
        if interrupt.behind(error):
            raise KeyboardInterrupt from error
        # A result that cannot be moved into the output folder is kept there.
        leave_failure(output, run, error, files if isinstance(error, InTheWay) else {})
        raise
    finally:
        run.progress.close()
    if output:
        output.remove(FAILED)
    return Built(done, files, robot)


def prepared(
    run: "Run", environ: Mapping[str, str], stages: tuple[Stage, ...], in_memory: bool
) -> Output | None:
    """Prepares the output folder; None for a build in memory. ConfigError with all problems that are known
    before the first stage."""
    wrong = plan_problems(run.plan, environ, stages)
    output = None
    try:
        if not in_memory:
            output = destination(run.plan, environ, lambda line: run.progress.detail("output", line))
    except ConfigError as error:
        if not wrong:
            raise
        wrong += as_problems(error)
    if wrong:
        raise refusal(wrong)
    if output:
        output.prepare(suffix_of(run.plan), expected_files(run.plan))
    return output


@dataclass(slots=True)
class Run:
    """The state of a running build, from which its report is made."""

    plan: Plan
    folder: str
    log: Log
    progress: Progress
    stages: list[StageReport] = field(default_factory=list)
    source: dict[str, Any] = field(default_factory=dict)
    calls: dict[str, Any] = field(default_factory=lambda: {"made": 0, "saved": 0})
    bundle: dict[str, str] = field(default_factory=dict)
    figures: dict[str, float] = field(default_factory=dict)
    details: dict[str, Any] = field(default_factory=dict)
    diagnostics: list[Diagnostic] = field(default_factory=list)
    stale: bool = False
    advice: str = ""
    shown: dict[str, str] = field(default_factory=dict)
    seen: Live = NOTHING
    pictures: Preview = NONE

    def __post_init__(self) -> None:
        self.source |= describe(self.plan)

    @property
    def named(self) -> bool:
        """Whether the user named the robot; else its name comes from its source."""
        return self.plan.name != name_of({"url": self.source.get("url")})

    def stage(self, stage: Stage, context: BuildContext) -> None:
        """Runs one stage, and records its time and its findings."""
        context.detail = context.cache.on_wait = lambda line: self.progress.detail(stage.name, line)
        context.transient = lambda line: self.transient(stage.name, line)
        self.calls = context.calls
        self.progress.start(stage.name)
        start = time.perf_counter()
        files, cached = perform(stage, context)
        seconds = time.perf_counter() - start
        context.files[stage.name] = files
        if stage.name == "fetch":
            self.bundle = {"manifest": bundles.remember(context.cache, files)}
        self.shown |= {name: files[name].decode() for name in (*VIEWS, PICTURES) if name in files}
        found = json.loads(files[NOTES])
        self.figures |= found["figures"]
        details = found.get("details", {})
        self.details |= kept(details) if cached else details
        self.source |= found.get("source", {})
        self.advice = found.get("advice", self.advice)
        self.stale = self.stale or found.get("stale", False)
        if cached:
            context.calls["saved"] += found.get("calls", 0)
        self.note(codec.decode_diagnostics(found["diagnostics"]))
        done = StageReport(stage.name, cached, round(seconds, 4), found["summary"])
        self.stages.append(done)
        self.progress.done(done)

    def transient(self, stage: str, line: str) -> None:
        """Shows a line about a long step, which Ctrl-C ends."""
        interrupt.check()
        self.progress.transient(stage, line)

    def note(self, found: Iterable[Diagnostic]) -> None:
        """Records diagnostics, each once."""
        for diagnostic in found:
            if diagnostic not in self.diagnostics:
                self.diagnostics.append(diagnostic)
                self.log.line(f"{diagnostic.code} {diagnostic.where}: {diagnostic.message}")

    def look(self, context: BuildContext, sweep: Path | None) -> None:
        """Makes what `report.html` shows of the robot."""
        say = functools.partial(self.progress.detail, "page")
        self.seen = live(context, self.details.get("colliders", ()), Path(self.folder), sweep, say)
        self.note(self.seen.found)

    def draw(self, context: BuildContext, files: Mapping[str, bytes]) -> None:
        """Makes the robot's picture, of a build that exports."""
        if "export" in context.files and not is_plain(context.environ):
            kind, say = self.plan.page.preview, functools.partial(self.progress.detail, "page")
            self.pictures = preview(context.cache, files, digests(context, files), kind, say)
            self.note(self.pictures.found)

    def finished(self, context: BuildContext, files: Mapping[str, bytes]) -> Report:
        """The report of a build whose stages all ran and made `files`."""
        checks: tuple[Check, ...] = ()
        if "validate" in context.files:
            checks = codec.decode_checks(context.files["validate"]["checks.json"])
            checks += strict_checks(self.plan.validate.level, self.diagnostics, checks)
        for check in checks:
            word = "passed" if check.passed else "FAILED" if check.fails else "WARNING"
            self.log.line(f"{word} {check.name}: {check.detail}")
        status: Status = "stale" if self.stale else "built"
        if any(check.fails for check in checks):
            status = "invalid"
        ended = 0 if status == "built" else 3
        made, picture = digests(context, files), self.pictures.path
        return self.report(status=status, exit_status=ended, checks=checks, outputs=made, preview=picture)

    def failed(self, error: BaseException) -> Report:
        """The report of a build that `error` ended."""
        if isinstance(error, SecretFound):
            # The findings of the stages may contain a part of the secret.
            self.shown, self.diagnostics = {}, []
        what: dict[str, Any] = {"type": type(error).__name__, "message": str(error)}
        if isinstance(error, LinkwrightError):
            what |= {"message": error.message, "where": error.where, "hint": error.hint}
            what["problems"] = codec.plain(error.problems)
        return self.report(status="failed", exit_status=exit_status(error), error=what)

    def report(self, **more: Any) -> Report:
        installed = {name: v for stage in STAGES for name, v in libraries(stage).items()}
        return Report(
            name=self.plan.name,
            title="" if self.named else self.source.get("title", ""),
            folder=self.folder,
            until=self.plan.until,
            source=self.source,
            calls=dict(self.calls),
            bundle=self.bundle,
            stages=tuple(self.stages),
            figures=self.figures,
            details=self.details,
            diagnostics=tuple(self.diagnostics),
            advice=self.advice,
            outline=tuple(self.shown.get(OUTLINE, "").splitlines()),
            versions=report.versions(installed),
            **more,
        )

    def documents(
        self, done: Report, files: Mapping[str, bytes], last: Path | None = None
    ) -> dict[str, bytes]:
        """The documents about the build, beside the `files` of the robot, to replace those of `last`."""
        self.log.line(f"{done.status}: exit status {done.exit_status}")
        return documents(done, files, self.shown, self.plan, self.log, last, self.seen, self.pictures)


def leave_failure(output: Output | None, run: Run, error: Exception, files: Mapping[str, bytes]) -> None:
    """Writes the report and the log of a failed build, and its `files`, beside the last good output; for a
    build in memory only the error's notes list its API calls."""
    for line in str(error).splitlines():
        run.log.line(line)
    if not isinstance(error, LinkwrightError):
        for line in "".join(traceback.format_exception(error)).splitlines():
            run.log.line(line)
    failed = run.failed(error)
    place = None
    try:
        if output:
            place = output.publish({**files, **run.documents(failed, files)}, FAILED)
    except LinkwrightError as second:
        # The first error is the one to raise.
        run.progress.detail("output", f"no report of this failure could be written: {second}")
    else:
        for line in report.failure_lines(failed, place):
            error.add_note(line)
