"""Recognises an unchanged build as a whole: nothing is composed, and no stage is asked.

A build that ends leaves a record in its cache, under its command line, its working folder and the identity of
the program: what was asked of the file system and the environment (`pipeline.observed`), how the source on
this computer is read again, and what the build made. The next build of the same command asks the same again.
Where every answer is the same, the source too, and the output folder still holds this very build, only the
documents about the run are written again. In every other case, also for a damaged record, the build runs as
usual.

A record is data. Its answers can only be compared; it names the folder of the output, but that is used only
while it holds files with the digests in the record.
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
from linkwright.pipeline.changes.since import Since, since
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.documents import documents
from linkwright.pipeline.errors import LinkwrightError
from linkwright.pipeline.mesh_details import kept
from linkwright.pipeline.observed import Answer, Observed
from linkwright.pipeline.options import Command
from linkwright.pipeline.output.folder import FAILED, Output
from linkwright.pipeline.output.location import require_free
from linkwright.pipeline.output.manifest import DOCUMENTS
from linkwright.pipeline.page.hero import with_view
from linkwright.pipeline.report import Report
from linkwright.pipeline.run import program
from linkwright.pipeline.show.live import Engine, view_of
from linkwright.pipeline.terminal.progress import Log, Progress, Tee
from linkwright.stages.fetch import force, keys_to_read_again, read_again
from linkwright.stages.robot import codec

if TYPE_CHECKING:
    from linkwright.pipeline.run.build import Built

VERSION = 2
"""Raised when a record changes its meaning."""

CONFIG = "config.yaml"
_RECORD, _PAGE, _PACK = "record.json", "page.html", "pack"
_FILES, _PICTURES = "files/", "pictures/"
"""Names of blobs: the record itself; the page without its live view, and the view; and the folders of the
robot's files and of its pictures."""

_CACHE = re.compile(r"(?:\+\+)?cache\.dir=([\w./~+-]+)")


@dataclass(frozen=True, slots=True)
class Kept:
    """What an unchanged build needs, besides files.

    `answers` to the questions of the build; `source`: its keys, where it is on this computer; `content`: the
    digest of what identified it when it was fetched; `stages`: the keys of their records in the cache.
    `folder`, `suffix` and `overwrite` are those of the output; `report`: as a cached build has it; `notes`:
    as the log has them; `engine`: of the page.
    """

    answers: tuple[Answer, ...]
    source: Mapping[str, Any]
    content: str
    stages: tuple[str, ...]
    folder: str
    suffix: str
    overwrite: bool
    report: Report
    notes: tuple[tuple[str, ...], ...]
    engine: Engine


def action_of(command: Command) -> Action:
    """The action under which the build of a command is kept. OSError where the working folder is gone."""
    typed = {"overrides": command.overrides, "folders": command.config_dirs, "cwd": os.getcwd()}  # noqa: PTH109
    return Action("build", VERSION, typed, {"program": program.identity()})


def remember(action: Action, command: Command, seen: Observed, built: "Built") -> None:
    """Keeps a record of a build that ended, where the same answers lead to the same build."""
    run = built.run
    if not seen.lasts or not _is_known_by_its_answers(built, _cache_folder(command)):
        return
    kept = _kept(built, seen.answers)
    made = {
        _RECORD: json.dumps(codec.plain(kept)).encode(),
        CONFIG: built.documents[CONFIG],
        _PAGE: run.page(kept.report, built.files, Since()).encode(),
        **({} if run.seen.pack is None else {_PACK: run.seen.pack}),
        **{_PICTURES + name: data for name, data in run.pictures.files.items()},
        **{_FILES + path: data for path, data in built.files.items()},
    }
    try:
        with actions.opened("use", run.plan.cache.dir) as cache:
            if all(cache.store.record(stage.key) for stage in built.actions.values()):
                cache.name(action, cache.keep(made))
    except LinkwrightError:
        return  # The build is whole; the next one runs as usual.


def _is_known_by_its_answers(built: "Built", cache: str | None) -> bool:
    """Whether the build is whole, and depends on nothing but what is asked before its first stage. `cache`:
    the folder in which the next build looks for the record."""
    plan, run, report = built.run.plan, built.run, built.report
    if plan.cache.mode != "use" or plan.cache.dir != cache or force(plan):
        return False
    if plan.plugins or plan.validate.checks or plan.validate.external or getattr(plan.source, "trust", False):
        return False
    whole = report.status in ("built", "invalid") and len(built.actions) == len(report.stages)
    return whole and run.seen.lasts and run.pictures.lasts


def _kept(built: "Built", answers: tuple[Answer, ...]) -> Kept:
    # Late: an unchanged build remembers nothing.
    from linkwright.pipeline.run.preflight import suffix_of

    run, report = built.run, built.report
    return Kept(
        answers=answers,
        source=keys_to_read_again(run.plan),
        content=_content(built.actions["fetch"].config["pinned"]),
        stages=tuple(action.key for action in built.actions.values()),
        folder=str(run.plan.folder),
        suffix=suffix_of(run.plan),
        overwrite=run.plan.overwrite,
        report=replace(
            report,
            calls={"made": 0, "saved": run.saved},
            stages=tuple(replace(stage, cached=True, seconds=0.0) for stage in report.stages),
            details=kept(report.details),
        ),
        notes=tuple(tuple(lines) for lines in run.log.notes),
        engine=run.seen.engine,
    )


def again(action: Action, command: Command, progress: Progress) -> Report | None:
    """The report of an unchanged build, whose documents are written anew; None where the build must run."""
    try:
        cache_folder = _cache_folder(command)
        if not (actions.folder(cache_folder, os.environ) / "ac").is_dir():
            return None
        with actions.opened("use", cache_folder) as cache:
            files = cache.find(action.key)
            kept = None if files is None else codec.typed(Kept, json.loads(files[_RECORD]))
            if files is None or kept is None or not _is_unchanged(kept, action, cache):
                return None
            require_free(Output(kept.folder).target, _taken(kept), actions.folder(cache_folder, os.environ))
            return _renewed(kept, files, progress)
    except Exception:  # A record that is damaged, or a folder that refuses: the build says what is wrong.
        if interrupt.came():
            raise
        return None


def _is_unchanged(kept: Kept, action: Action, cache: Cache) -> bool:
    if not observed.still_true(kept.answers, action.key):
        return False
    if kept.source and _content(read_again(kept.source, os.environ)) != kept.content:
        return False
    # Reading a record marks it as used, so that `linkwright cache gc` drops it late.
    records = [cache.store.record(key) for key in kept.stages]
    return None not in records


def _renewed(kept: Kept, files: Files, progress: Progress) -> Report | None:
    """Writes the output folder again, with new documents; None where it does not hold this very build."""
    report, log = kept.report, Log(os.environ)
    say = Tee(log, progress)
    output = Output(kept.folder, lambda line: say.detail("output", line), overwrite=kept.overwrite)
    robot = files.below(_FILES)
    live = view_of(files.get(_PACK), kept.engine)
    beside = {**live.files, **files.below(_PICTURES)}
    folder = output.folder(kept.suffix)
    if robot.digests != report.outputs or not since(folder, report.outputs, {}, beside).nothing:
        return None
    output.prepare(kept.suffix, [*robot, *beside, *DOCUMENTS])
    for stage, lines in zip(report.stages, kept.notes, strict=False):
        for line in lines:
            log.line(line)
        log.done(stage)
    for line in kept.notes[-1]:
        log.line(line)
    about = documents(report, with_view(files[_PAGE].decode(), live), files[CONFIG], log)
    interrupt.check()
    output.publish({**robot, **beside, **about}, kept.suffix, report.outputs)
    output.remove(FAILED)
    for stage in report.stages:
        progress.done(stage)
    return report


def _content(identity: Mapping[str, Any] | None) -> str:
    return sha256(canonical(identity))


def _taken(kept: Kept) -> dict[str, Path]:
    path = kept.source.get("path")
    return {"the source": Path(path)} if path else {}


def _cache_folder(command: Command) -> str | None:
    """The folder of the cache that the command line names, as far as that is plain to see."""
    found = [match[1] for match in map(_CACHE.fullmatch, command.overrides) if match]
    return found[-1] if found else None
