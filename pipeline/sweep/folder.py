"""Writes the folder of a sweep: its own files beside the folders of its jobs."""

import contextlib
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkwright.pipeline import lock
from linkwright.pipeline.caching import actions
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.output import conflicts, manifest
from linkwright.pipeline.output.folder import move_aside, output_errors
from linkwright.pipeline.output.location import ELSEWHERE, absolute, require_free
from linkwright.pipeline.output.replacing import replace
from linkwright.pipeline.page.sweep.document import page
from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.show.live import ENGINE_FILE, engine_file, is_plain
from linkwright.pipeline.sweep import summary_csv, summary_json
from linkwright.pipeline.sweep.outcome import Outcome, missing_outcome, state_of
from linkwright.pipeline.sweep.outcome_files import withdraw
from linkwright.pipeline.sweep.summary_csv import FILE_NAME
from linkwright.pipeline.sweep.summary_json import SUMMARY

if TYPE_CHECKING:
    from linkwright.pipeline.sweep.run import Job

Environ = Mapping[str, str]

PAGE, ACCOUNT = "summary.html", "multirun.yaml"
SWEEP_FILES = (SUMMARY, PAGE, FILE_NAME, ACCOUNT, ENGINE_FILE)
"""The files of a sweep itself: the outcomes of its jobs (as data, for people, and for spreadsheets), Hydra's
record of the sweep, and the viewer's engine, which the pages of its jobs share."""


def prepare(
    root: Path, jobs: Sequence["Job"], overrides: Sequence[str], environ: Environ = os.environ
) -> None:
    """Creates and marks the folder of a sweep, and records a new run of its `jobs`, all missing, with the
    `overrides` of the command line, after earlier runs. Raises the errors of `mark`."""
    mark(root, jobs[0].plan, environ)
    with output_errors(root):
        for job in jobs:
            withdraw(job.plan.folder)
    missing = [missing_outcome(job.number, job.label, job.overrides, str(job.plan.folder)) for job in jobs]
    record(root, missing, overrides, environ)


def mark(root: Path, plan: Plan, environ: Environ = os.environ) -> None:
    """Creates and marks the folder of a sweep, with the engine that its pages share; `plan`: the plan of any
    job. Raises ConfigError if no sweep can be there, if linkwright did not make the folder, or if a file that
    is not linkwright's is in its way; raises OutputError if it cannot be written.
    """
    with output_errors(root):
        absolute_root = absolute(root)
        require_free(absolute_root, {}, actions.folder(plan.cache.dir, environ))
        if manifest.is_build(absolute_root):
            raise ConfigError(f"{root} is the folder of a build", "output", ELSEWHERE)
        if manifest.is_foreign(absolute_root):
            raise conflicts.foreign_folder_error(root)
        blockers = _blockers(absolute_root)
        if blockers and not plan.overwrite:
            raise ConfigError(conflicts.message(root, blockers), "output", conflicts.conflict_hint(root))
        absolute_root.mkdir(parents=True, exist_ok=True)
        for path in blockers:
            move_aside(absolute_root / path, absolute_root, path)
        # Any content counts as the sweep's own until it ends, since it may be killed.
        manifest.write_shared(absolute_root, dict.fromkeys(SWEEP_FILES))
        if plan.page.live != "kinematics" and not is_plain(environ):
            replace(absolute_root / ENGINE_FILE, engine_file())


def is_marked(root: Path) -> bool:
    """Tells whether the folder is that of a sweep."""
    return manifest.written_files(root) is not None or manifest.is_sweep(root)


def record(
    root: Path, missing: Sequence[Outcome], overrides: Sequence[str], environ: Environ = os.environ
) -> None:
    """Records a new run in the folder of a sweep; all its jobs count as `missing` at first. Raises
    OutputError if that fails."""
    with output_errors(root):
        rows = _rows(missing, root)
        run = {
            "started": f"{datetime.now(UTC):%Y-%m-%dT%H:%M:%SZ}",
            "overrides": Secrets(environ).within(list(overrides)),
            "folders": [row["folder"] for row in rows],
            "jobs": rows,
        }
        replace(root / SUMMARY, summary_json.text([*summary_json.runs(root), run]))


def is_recorded(root: Path, folders: Sequence[Path]) -> bool:
    """Tells whether the last run in the folder of a sweep has jobs with these folders."""
    last: Mapping[str, Any] = next(reversed(summary_json.runs(root)), {})
    return bool(
        last.get("folders") == [summary_json.relative_folder(str(folder), root) for folder in folders]
    )


def write_summaries(outcomes: Iterable[Outcome], root: Path) -> None:
    """Writes the outcomes of the jobs to `summary.json`, `summary.html` and `summary.csv`; raises OutputError
    if that fails. It may be called while jobs run, and from several processes."""
    jobs = _rows(outcomes, root)
    with output_errors(root), _exclusively(root):
        *earlier_runs, run = summary_json.runs(root) or [{"started": None, "overrides": []}]
        # Any content counts as the sweep's own while it is written, since a kill may end that.
        manifest.write_shared(root, dict.fromkeys(SWEEP_FILES))
        replace(root / SUMMARY, summary_json.text([*earlier_runs, {**run, "jobs": jobs}]))
        with_states = [{**job, "state": state_of(job["status"], job["message"])} for job in jobs]
        replace(root / FILE_NAME, summary_csv.csv_content(with_states))
        replace(root / PAGE, _page(root, with_states))
        file_names = [name for name in SWEEP_FILES if (root / name).is_file()]
        manifest.write_shared(root, {name: sha256((root / name).read_bytes()) for name in file_names})


@contextlib.contextmanager
def _exclusively(root: Path) -> Iterator[None]:
    """Keeps other processes of this host from writing the summary. On a file system without locks the last
    writer wins."""
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError):
            stack.enter_context(lock.acquired(lock.beside(root / SUMMARY), lambda: None))
        yield


def _rows(outcomes: Iterable[Outcome], root: Path) -> list[dict[str, Any]]:
    """Returns the outcomes as plain data, by number, without secrets, with the jobs' folders relative to the
    sweep's."""
    secrets = Secrets(os.environ)
    rows = []
    for outcome in sorted(outcomes, key=lambda outcome: outcome.number):
        row = asdict(outcome) | {"folder": summary_json.relative_folder(outcome.folder, root)}
        rows.append(secrets.within(row) if secrets else row)
    return rows


def _blockers(root: Path) -> dict[str, str]:
    """Returns the foreign or changed files at the paths that a sweep writes: path → reason."""
    own_files = manifest.written_files(root) or dict.fromkeys(SWEEP_FILES if manifest.is_sweep(root) else ())
    entries = manifest.foreign_or_changed(root, own_files) if root.is_dir() else ()
    return {entry.path: conflicts.block_reason(entry) for entry in entries if entry.path in SWEEP_FILES}


def _page(root: Path, jobs: Sequence[Mapping[str, Any]]) -> bytes:
    """Returns the page about the last run."""
    linked_files = [name for name in (SUMMARY, FILE_NAME, ACCOUNT) if (root / name).is_file()]
    title = Secrets(os.environ).blanked(root.name)
    return page(title, jobs, lambda path: (root / path).exists(), linked_files)
