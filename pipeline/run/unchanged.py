"""Recognises an unchanged build as a whole, without composing it or asking its stages.

A build that ends leaves a record in its cache, under its command line, its working folder and the identity of
the program: the answers of the file system and the environment (`pipeline.observed`), the keys to read a
source on this computer again, and the results of the build. The next build of the same command asks the same
questions. If every answer is the same, the source too, and the output folder still holds this very build,
only the documents about the run are written again. In every other case, also for a damaged record, the build
runs as usual. A record is data. Its answers can only be compared; it names the folder of the output, but that
is used only while it holds files with the digests in the record.
"""

import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkwright.pipeline import interrupt, observed
from linkwright.pipeline.caching import actions
from linkwright.pipeline.caching.actions import Action, Cache, Files, canonical
from linkwright.pipeline.changes.build_changes import BuildChanges, compare_builds
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.documents import documents
from linkwright.pipeline.errors import LinkwrightError
from linkwright.pipeline.mesh_details import as_cached
from linkwright.pipeline.observed import AnsweredQuestion, Observations
from linkwright.pipeline.options import Command
from linkwright.pipeline.output.folder import FAILED, Output
from linkwright.pipeline.output.location import require_free
from linkwright.pipeline.output.manifest import DOCUMENTS
from linkwright.pipeline.page.live_view import with_view
from linkwright.pipeline.report import Report
from linkwright.pipeline.run import program
from linkwright.pipeline.show.live import Engine, view_of
from linkwright.pipeline.terminal.progress import Log, Progress, Tee
from linkwright.stages.fetch import force, keys_to_read_again, read_again
from linkwright.stages.robot import codec

if TYPE_CHECKING:
    from linkwright.pipeline.run.build import BuildResult

VERSION = 2
"""Must be increased when a record changes its meaning."""

CONFIG = "config.yaml"
_RECORD, _PAGE, _PACK = "record.json", "page.html", "pack"
_FILES, _PICTURES = "files/", "pictures/"
"""Names of blobs: the record itself; the page without its live view, and the view; and the folders of the
robot's files and of its pictures."""

_CACHE_OVERRIDE = re.compile(r"(?:\+\+)?cache\.dir=([\w./~+-]+)")


@dataclass(frozen=True, slots=True)
class BuildRecord:
    """The record of a build, except its files, by which an unchanged build is recognised."""

    answers: tuple[AnsweredQuestion, ...]
    """The answers of the file system and the environment to the questions of the build."""

    source: Mapping[str, Any]
    """The keys to read the source again, if it is on this computer."""

    content: str
    """The digest of the source's identity when it was fetched."""

    stages: tuple[str, ...]
    """The keys of the stages' records in the cache."""

    folder: str
    """The output folder, without `suffix`."""

    suffix: str
    overwrite: bool
    report: Report
    """The report in the form of a cached build."""

    notes: tuple[tuple[str, ...], ...]
    """`Log.notes` of the build."""

    engine: Engine
    """Where the page finds the viewer's engine."""


def action_of(command: Command) -> Action:
    """Returns the action under which the build of a command is kept. Raises OSError if the working folder is
    gone."""
    command_values = {"overrides": command.overrides, "folders": command.config_dirs, "cwd": os.getcwd()}  # noqa: PTH109
    return Action("build", VERSION, command_values, {"program": program.identity()})


def remember(action: Action, command: Command, observations: Observations, built: "BuildResult") -> None:
    """Keeps a record of a build that ended, if the same answers lead to the same build."""
    run = built.run
    if not observations.is_repeatable or not _is_known_by_its_answers(built, _cache_folder(command)):
        return
    record = _record_of(built, observations.answers)
    outputs = {
        _RECORD: json.dumps(codec.plain_data(record)).encode(),
        CONFIG: built.documents[CONFIG],
        _PAGE: run.page(record.report, built.files, BuildChanges()).encode(),
        **({} if run.live_view.pack is None else {_PACK: run.live_view.pack}),
        **{_PICTURES + name: data for name, data in run.pictures.files.items()},
        **{_FILES + path: data for path, data in built.files.items()},
    }
    try:
        with actions.opened("use", run.plan.cache.dir) as cache:
            if all(cache.store.record(stage.key) for stage in built.actions.values()):
                cache.name(action, cache.keep(outputs))
    except LinkwrightError:
        return  # The build is whole; the next one runs as usual.


def _is_known_by_its_answers(built: "BuildResult", cache: str | None) -> bool:
    """Tells whether the build is whole, and depends only on questions asked before its first stage. `cache`:
    the folder in which the next build looks for the record."""
    plan, run, report = built.run.plan, built.run, built.report
    if plan.cache.mode != "use" or plan.cache.dir != cache or force(plan):
        return False
    if plan.plugins or plan.validate.checks or plan.validate.external or getattr(plan.source, "trust", False):
        return False
    is_complete = report.status in ("built", "invalid") and len(built.actions) == len(report.stages)
    return is_complete and run.live_view.lasts and run.pictures.lasts


def _record_of(built: "BuildResult", answers: tuple[AnsweredQuestion, ...]) -> BuildRecord:
    # Late: an unchanged build remembers nothing.
    from linkwright.pipeline.run.preflight import suffix_of

    run, report = built.run, built.report
    return BuildRecord(
        answers=answers,
        source=keys_to_read_again(run.plan),
        content=_identity_digest(built.actions["fetch"].config["pinned"]),
        stages=tuple(action.key for action in built.actions.values()),
        folder=str(run.plan.folder),
        suffix=suffix_of(run.plan),
        overwrite=run.plan.overwrite,
        report=replace(
            report,
            calls={"made": 0, "saved": run.saved},
            stages=tuple(replace(stage, cached=True, seconds=0.0) for stage in report.stages),
            details=as_cached(report.details),
        ),
        notes=tuple(tuple(lines) for lines in run.log.notes),
        engine=run.live_view.engine,
    )


def reuse(action: Action, command: Command, progress: Progress) -> Report | None:
    """Returns the report of an unchanged build, whose documents are written again; None if the build must
    run."""
    try:
        cache_folder = _cache_folder(command)
        if not (actions.folder(cache_folder, os.environ) / "ac").is_dir():
            return None
        with actions.opened("use", cache_folder) as cache:
            files = cache.find(action.key)
            record = None if files is None else codec.typed(BuildRecord, json.loads(files[_RECORD]))
            if files is None or record is None or not _is_unchanged(record, action, cache):
                return None
            require_free(
                Output(record.folder).target,
                _reserved_paths(record),
                actions.folder(cache_folder, os.environ),
            )
            return _renew_output(record, files, progress)
    except Exception:  # A record is damaged, or a folder refuses access: the build reports the error.
        if interrupt.has_come():
            raise
        return None


def _is_unchanged(record: BuildRecord, action: Action, cache: Cache) -> bool:
    if not observed.have_same_answers(record.answers, action.key):
        return False
    if record.source and _identity_digest(read_again(record.source, os.environ)) != record.content:
        return False
    # Reading a record marks it as used, so that `linkwright cache gc` drops it late.
    records = [cache.store.record(key) for key in record.stages]
    return None not in records


def _renew_output(record: BuildRecord, files: Files, progress: Progress) -> Report | None:
    """Writes the output folder again, with new documents; None if it does not hold this very build."""
    report, log = record.report, Log(os.environ)
    say = Tee(log, progress)
    output = Output(record.folder, lambda line: say.detail("output", line), overwrite=record.overwrite)
    robot = files.below(_FILES)
    live = view_of(files.get(_PACK), record.engine)
    page_files = {**live.files, **files.below(_PICTURES)}
    folder = output.folder(record.suffix)
    if (
        robot.digests != report.outputs
        or not compare_builds(folder, report.outputs, {}, page_files).unchanged
    ):
        return None
    output.prepare(record.suffix, [*robot, *page_files, *DOCUMENTS])
    for stage, lines in zip(report.stages, record.notes, strict=False):
        for line in lines:
            log.line(line)
        log.done(stage)
    for line in record.notes[-1]:
        log.line(line)
    new_documents = documents(report, with_view(files[_PAGE].decode(), live), files[CONFIG], log)
    interrupt.check()
    output.publish({**robot, **page_files, **new_documents}, record.suffix, report.outputs)
    output.remove(FAILED)
    for stage in report.stages:
        progress.done(stage)
    return report


def _identity_digest(identity: Mapping[str, Any] | None) -> str:
    return sha256(canonical(identity))


def _reserved_paths(record: BuildRecord) -> dict[str, Path]:
    path = record.source.get("path")
    return {"the source": Path(path)} if path else {}


def _cache_folder(command: Command) -> str | None:
    """Returns the cache folder that the command line names, if its override is plain."""
    folders = [match[1] for match in map(_CACHE_OVERRIDE.fullmatch, command.overrides) if match]
    return folders[-1] if folders else None
