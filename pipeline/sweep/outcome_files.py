"""Keeps the outcome of each job of a sweep, wherever it runs, in a file beside its folder.

The file is replaced as a whole: first it tells where the job runs, in the end how it ended. So the outcomes
of all jobs can be read while they run, after they were killed, and by another host.
"""

import contextlib
import json
import os
import socket
from collections.abc import Iterator, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from linkwright.pipeline import lock
from linkwright.pipeline.caching.shared import UNREACHABLE_ERRORS, with_retries
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.output.replacing import replace as replace_file
from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.sweep import summary_json
from linkwright.pipeline.sweep.outcome import RUNNING, Outcome, missing_outcome
from linkwright.stages.robot import codec

SUFFIX = ".outcome.json"

KILLED_MESSAGE = "was killed before its end"


def begin(folder: Path) -> None:
    """Records that the job of this output folder runs here."""
    _write(folder, {"host": socket.gethostname(), "process": os.getpid()})


def leave(outcome: Outcome, folder: Path) -> None:
    """Records how the job of this output folder ended."""
    _write(folder, {**asdict(outcome), "folder": summary_json.relative_folder(outcome.folder, folder.parent)})


def withdraw(folder: Path) -> None:
    """Removes the record of a job, which then counts as missing."""
    with contextlib.suppress(OSError):
        _record_path(folder).unlink(missing_ok=True)


def outcomes_of(root: Path) -> Iterator[Outcome]:
    """Yields the outcomes of all jobs of the last run of a sweep, from its folder alone. The outcome of a job
    without a record comes from the summary. Raises ConfigError if the summary is damaged."""
    for recorded, path in _last_run(root):
        folder = root / path
        default = missing_outcome(
            recorded.number, recorded.label, recorded.overrides, os.path.relpath(folder)
        )
        yield read_outcome(default if recorded.status is None else recorded, folder)


def _last_run(root: Path) -> list[tuple[Outcome, str]]:
    """Returns the jobs of the last run from the summary, each with the path of its folder relative to the
    sweep's."""
    try:
        run: Mapping[str, Any] = next(reversed(summary_json.runs(root)), {})
        folders = dict(enumerate(run.get("folders", ())))
        jobs = [codec.typed(Outcome, job) for job in run.get("jobs", ())]
        jobs_with_paths = [
            (replace(job, folder=os.path.relpath(root / job.folder)), folders.get(job.number, job.folder))
            for job in jobs
        ]
        if not all(_is_sound(job) and isinstance(path, str) for job, path in jobs_with_paths):
            raise TypeError
    except (AttributeError, KeyError, TypeError, ValueError):
        msg = "is no summary that this linkwright reads: it is of a later version, or was edited"
        hint = "read it with the linkwright that wrote it, or remove it and run the sweep again"
        raise ConfigError(msg, str(root / summary_json.SUMMARY), hint) from None
    return jobs_with_paths


def _is_sound(job: Outcome) -> bool:
    """Tells whether the values of an outcome have the right types, which JSON does not ensure."""
    texts = (job.label, job.message, *job.problems)
    tables = (job.overrides, job.figures, job.checks, job.calls)
    is_numbered = isinstance(job.number, int) and isinstance(job.status, int | None)
    return (
        is_numbered
        and all(isinstance(text, str) for text in texts)
        and all(isinstance(table, dict) for table in tables)
    )


def read_outcome(default: Outcome, folder: Path) -> Outcome:
    """Returns the outcome that the job of an output folder has left; `default` if it has left nothing. Raises
    OSError if the file system is out of reach."""
    try:
        record = json.loads(with_retries(_record_path(folder).read_bytes))
        if "status" in record:
            relative_folder = os.path.relpath(folder.parent / record["folder"])
            return Outcome(**{**record, "number": default.number, "folder": relative_folder})
        unfinished = missing_outcome(
            default.number, default.label, default.overrides, os.path.relpath(folder)
        )
        if _is_dead(record):
            return replace(unfinished, status=1, message=KILLED_MESSAGE)
        return replace(unfinished, message=RUNNING)
    except OSError as error:
        if error.errno in UNREACHABLE_ERRORS:
            raise
        return default
    except (ValueError, KeyError, TypeError):
        return default


def _is_dead(record: Mapping[str, Any]) -> bool:
    """Tells whether the process of a job has ended; for other hosts that is unknown."""
    if record["host"] != socket.gethostname():
        return False
    try:
        os.kill(record["process"], 0)
    except ProcessLookupError:
        return True
    except OSError:
        return False
    return False


def _record_path(folder: Path) -> Path:
    return lock.lock_path(folder).with_name(f"{folder.name}{SUFFIX}")


def _write(folder: Path, record: Mapping[str, Any]) -> None:
    """Writes the record. Without it, as on a full disk, the job counts as missing; its result also goes to
    the launcher."""
    path = _record_path(folder)
    text = json.dumps(Secrets(os.environ).within(dict(record)), ensure_ascii=False)
    with contextlib.suppress(OSError):
        lock.beside(folder)
        replace_file(path, text.encode("utf-8", "backslashreplace"))
