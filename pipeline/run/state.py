"""Keeps the state of a running build, and makes its report and its documents."""

import functools
import json
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from linkwright.pipeline import interrupt, report
from linkwright.pipeline.caching import bundles
from linkwright.pipeline.changes.build_changes import BuildChanges, compare_builds
from linkwright.pipeline.config.choices import default_robot_name
from linkwright.pipeline.config.files.file_text import as_yaml
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.documents import documents
from linkwright.pipeline.errors import LinkwrightError, SecretFound, exit_status
from linkwright.pipeline.mesh_details import as_cached
from linkwright.pipeline.objective.value import objective
from linkwright.pipeline.page.document import frame
from linkwright.pipeline.page.live_view import with_view
from linkwright.pipeline.reference.exit_status import BUILT, UNMET
from linkwright.pipeline.report import Report, StageReport, Status
from linkwright.pipeline.run.products import digests
from linkwright.pipeline.run.strictness import strict_checks
from linkwright.pipeline.show.live import NOTHING, Live, is_plain, live
from linkwright.pipeline.show.preview import NONE, Drawing, Preview, start_drawing
from linkwright.pipeline.stages.context import FILES, NOTES, BuildContext
from linkwright.pipeline.stages.stage import STAGES, Stage, libraries, perform
from linkwright.pipeline.terminal.progress import Log, Progress
from linkwright.stages.fetch import describe
from linkwright.stages.mesh.view.views import PICTURES
from linkwright.stages.robot import codec
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.show.graph_view.views import NARROW_OUTLINE, OUTLINE, VIEWS


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
    saved: int = 0
    advice: str = ""
    views: dict[str, str] = field(default_factory=dict)
    live_view: Live = NOTHING
    drawing: Drawing = field(default_factory=Drawing)
    pictures: Preview = NONE

    def __post_init__(self) -> None:
        self.source |= describe(self.plan)

    @property
    def has_user_name(self) -> bool:
        """Tells whether the user named the robot; else its name comes from its source."""
        return self.plan.name != default_robot_name({"url": self.source.get("url")})

    def stage(self, stage: Stage, context: BuildContext) -> None:
        """Runs a stage, and records its time and its findings."""
        context.detail = context.cache.on_wait = lambda line: self.progress.detail(stage.name, line)
        context.transient = lambda line: self.transient(stage.name, line)
        self.calls = context.calls
        self.progress.start(stage.name)
        start = time.perf_counter()
        files, cached = perform(stage, context)
        seconds = time.perf_counter() - start
        context.files[stage.name] = files
        self.views |= {name: files[name].decode() for name in (*VIEWS, PICTURES) if name in files}
        notes = json.loads(files[NOTES])
        self.figures |= notes["figures"]
        details = notes.get("details", {})
        self.details |= as_cached(details) if cached else details
        self.source |= notes.get("source", {})
        self.advice = notes.get("advice", self.advice)
        self.stale = self.stale or notes.get("stale", False)
        if stage.name == "fetch":
            self.bundle = {"manifest": bundles.remember(context.cache, files)}
            self.saved = notes.get("calls", 0)
            context.calls["saved"] += self.saved if cached else 0
        self.note(codec.decode_diagnostics(notes["diagnostics"]))
        stage_report = StageReport(stage.name, cached, round(seconds, 4), notes["summary"])
        self.stages.append(stage_report)
        self.progress.done(stage_report)

    def transient(self, stage: str, line: str) -> None:
        """Shows a line about a long step; raises KeyboardInterrupt after Ctrl-C."""
        interrupt.check()
        self.progress.transient(stage, line)

    def note(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Records diagnostics, each once."""
        for diagnostic in diagnostics:
            if diagnostic not in self.diagnostics:
                self.diagnostics.append(diagnostic)
                self.log.line(f"{diagnostic.code} {diagnostic.where}: {diagnostic.message}")

    def make_live_view(self, context: BuildContext, sweep: Path | None) -> None:
        """Makes the live view of the robot in `report.html`."""
        self.progress.start("page")
        say = functools.partial(self.progress.detail, "page")
        self.live_view = live(context, self.details.get("colliders", ()), Path(self.folder), sweep, say)
        self.note(self.live_view.diagnostics)

    def begin_drawing(self, context: BuildContext) -> None:
        """Begins to draw the robot's picture while the following stages run."""
        if not is_plain(context.environ):
            exported = context.files["export"].below(FILES)
            kind, say = self.plan.page.preview, functools.partial(self.progress.detail, "page")
            self.drawing = start_drawing(context.cache, exported, exported.digests, kind, say)

    def finish_drawing(self) -> None:
        """Waits for the robot's picture, and records it."""
        self.pictures = self.drawing.result()
        self.note(self.pictures.diagnostics)
        self.progress.close()

    def success_report(self, context: BuildContext, files: Mapping[str, bytes]) -> Report:
        """Returns the report of a build whose stages all ran and made `files`."""
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
        status_code = BUILT if status == "built" else UNMET
        outputs, picture = digests(context, files), self.pictures.path
        value = objective(context, files, checks)
        return self.report(
            status=status,
            exit_status=status_code,
            checks=checks,
            outputs=outputs,
            preview=picture,
            objective=value,
        )

    def failure_report(self, error: BaseException) -> Report:
        """Returns the report of a build that `error` ended."""
        if isinstance(error, SecretFound):
            # The findings of the stages may contain a part of the secret.
            self.views, self.diagnostics = {}, []
        details: dict[str, Any] = {"type": type(error).__name__, "message": str(error)}
        if isinstance(error, LinkwrightError):
            details |= {"message": error.message, "where": error.where, "hint": error.hint}
            details["problems"] = codec.plain_data(error.problems)
        return self.report(status="failed", exit_status=exit_status(error), error=details)

    def report(self, **fields: Any) -> Report:
        """Returns a report with the given fields, and the others from the state."""
        installed = {name: version for stage in STAGES for name, version in libraries(stage).items()}
        return Report(
            name=self.plan.name,
            title="" if self.has_user_name else self.source.get("title", ""),
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
            outline=tuple(self.views.get(OUTLINE, "").splitlines()),
            narrow_outline=tuple(self.views.get(NARROW_OUTLINE, "").splitlines()),
            versions=report.versions(installed),
            **fields,
        )

    def documents(
        self, result: Report, files: Mapping[str, bytes], last_folder: Path | None = None
    ) -> dict[str, bytes]:
        """Returns the documents about the build. `files`: the robot's files; `last_folder`: the folder of the
        last build, whose differences the page lists."""
        self.log.line(f"{result.status}: exit status {result.exit_status}")
        config = as_yaml(self.log.secrets.within(self.plan.tree()))
        page_files = (*self.live_view.files, *self.pictures.files)
        changes = (
            None
            if last_folder is None
            else compare_builds(last_folder, result.outputs, files, page_files, result.checks)
        )
        page = with_view(self.page(result, files, changes), self.live_view)
        return documents(result, page, config, self.log)

    def page(self, result: Report, files: Mapping[str, bytes], changes: BuildChanges | None) -> str:
        """Returns the page about the build, without the live view."""
        sizes = {path: len(data) for path, data in files.items()}
        moves, secrets = self.live_view.pack is not None, self.log.secrets
        return frame(result, self.views, sizes, secrets, moves=moves, pictures=self.pictures, changes=changes)
