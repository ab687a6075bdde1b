"""The state of a running build, from which its report and its documents are made."""

import functools
import json
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from linkwright.pipeline import interrupt, report
from linkwright.pipeline.caching import bundles
from linkwright.pipeline.changes.since import Since, since
from linkwright.pipeline.config.choices import name_of
from linkwright.pipeline.config.files.file_text import as_yaml
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.documents import documents
from linkwright.pipeline.errors import LinkwrightError, SecretFound, exit_status
from linkwright.pipeline.mesh_details import kept
from linkwright.pipeline.page.document import frame
from linkwright.pipeline.page.hero import with_view
from linkwright.pipeline.report import Report, StageReport, Status
from linkwright.pipeline.run.products import digests
from linkwright.pipeline.run.strictness import strict_checks
from linkwright.pipeline.show.live import NOTHING, Live, is_plain, live
from linkwright.pipeline.show.preview import NONE, Drawing, Preview, begun
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
    shown: dict[str, str] = field(default_factory=dict)
    seen: Live = NOTHING
    drawing: Drawing = field(default_factory=Drawing)
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
        self.shown |= {name: files[name].decode() for name in (*VIEWS, PICTURES) if name in files}
        found = json.loads(files[NOTES])
        self.figures |= found["figures"]
        details = found.get("details", {})
        self.details |= kept(details) if cached else details
        self.source |= found.get("source", {})
        self.advice = found.get("advice", self.advice)
        self.stale = self.stale or found.get("stale", False)
        if stage.name == "fetch":
            self.bundle = {"manifest": bundles.remember(context.cache, files)}
            self.saved = found.get("calls", 0)
            context.calls["saved"] += self.saved if cached else 0
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
        self.progress.start("page")
        say = functools.partial(self.progress.detail, "page")
        self.seen = live(context, self.details.get("colliders", ()), Path(self.folder), sweep, say)
        self.note(self.seen.found)

    def begin_drawing(self, context: BuildContext) -> None:
        """Begins the robot's picture, beside the stages that come."""
        if not is_plain(context.environ):
            exported = context.files["export"].below(FILES)
            kind, say = self.plan.page.preview, functools.partial(self.progress.detail, "page")
            self.drawing = begun(context.cache, exported, exported.digests, kind, say)

    def draw(self) -> None:
        """Finishes the robot's picture."""
        self.pictures = self.drawing.result()
        self.note(self.pictures.found)
        self.progress.close()

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
            narrow_outline=tuple(self.shown.get(NARROW_OUTLINE, "").splitlines()),
            versions=report.versions(installed),
            **more,
        )

    def documents(
        self, done: Report, files: Mapping[str, bytes], last: Path | None = None
    ) -> dict[str, bytes]:
        """The documents about the build, beside the `files` of the robot, to replace those of `last`."""
        self.log.line(f"{done.status}: exit status {done.exit_status}")
        config = as_yaml(self.log.secrets.within(self.plan.tree()))
        beside = (*self.seen.files, *self.pictures.files)
        changes = None if last is None else since(last, done.outputs, files, beside, done.checks)
        page = with_view(self.page(done, files, changes), self.seen)
        return documents(done, page, config, self.log)

    def page(self, done: Report, files: Mapping[str, bytes], changes: Since | None) -> str:
        """The page about the build, without the live view."""
        sizes = {path: len(data) for path, data in files.items()}
        moves, secrets = self.seen.pack is not None, self.log.secrets
        return frame(done, self.shown, sizes, secrets, moves=moves, pictures=self.pictures, changes=changes)
