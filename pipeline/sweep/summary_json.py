"""Reads and writes summary.json: the runs of a sweep, the oldest first, each with its jobs' outcomes.

Version 3: unfinished jobs are listed too, with the `status` null; `folder` is the path relative to the
sweep's folder, so that the file is valid wherever that folder is mounted or moved; a job may have an
`objective`. Before, `folder` was the path relative to the working folder.
"""

import json
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from linkwright.pipeline.caching.shared import UNREACHABLE_ERRORS, with_retries
from linkwright.pipeline.output import manifest
from linkwright.stages.robot.text.printable import printable_lines

SUMMARY = "summary.json"

VERSION = 3

MAX_JOBS = 20_000
"""Earlier runs are dropped if all runs together have more jobs than this."""

Run = Mapping[str, Any]
"""The time when a run `started`, its typed `overrides`, and its `jobs` as plain data."""


def runs(root: Path) -> list[dict[str, Any]]:
    """Returns the recorded runs of a sweep's folder, the oldest first; of version 1 only the last run. Raises
    OSError if the file system is out of reach."""
    try:
        content = json.loads(with_retries((root / SUMMARY).read_bytes))
    except OSError as error:
        if error.errno in UNREACHABLE_ERRORS:
            # Without them, the next summary would lose them.
            raise
        return []
    except (ValueError, RecursionError):
        return []
    if not isinstance(content, dict):
        return []
    stored_runs = content.get("runs")
    if not isinstance(stored_runs, list):
        jobs = content.get("jobs")
        stored_runs = [{"started": None, "overrides": [], "jobs": jobs}] if jobs else []
    kept_runs = [run for run in stored_runs if isinstance(run, dict)]
    version = content.get(manifest.SWEEP_KEY)
    if isinstance(version, int) and version < VERSION:
        return [
            {**run, "jobs": [_with_relative_folder(job, root) for job in run.get("jobs", ())]}
            for run in kept_runs
        ]
    return kept_runs


def text(all_runs: Sequence[Run]) -> bytes:
    """Returns the content of the file, with a line for each job."""
    return printable_lines("".join(_pieces(_newest_runs(all_runs)))).encode() + b"\n"


def relative_folder(folder: str, root: Path) -> str:
    """Returns the path of a job's folder relative to the folder of the sweep."""
    return Path(os.path.relpath(folder, root)).as_posix()


def _with_relative_folder(job: dict[str, Any], root: Path) -> dict[str, Any]:
    return (
        {**job, "folder": relative_folder(job["folder"], root)} if isinstance(job.get("folder"), str) else job
    )


def _newest_runs(all_runs: Sequence[Run]) -> list[Run]:
    """Returns the last run, and as many runs before it as fit into MAX_JOBS."""
    run_count, job_count = 0, 0
    for run in reversed(all_runs):
        job_count += len(run.get("jobs", ()))
        if run_count and job_count > MAX_JOBS:
            break
        run_count += 1
    return list(all_runs[len(all_runs) - run_count :])


def _pieces(all_runs: Sequence[Run]) -> Iterator[str]:
    yield f'{{"{manifest.SWEEP_KEY}": {VERSION}, "runs": ['
    for index, run in enumerate(all_runs):
        head = {key: value for key, value in run.items() if key != "jobs"}
        yield f'{"," if index else ""}\n{_line(head)[:-1]}, "jobs": ['
        for job_index, job in enumerate(run.get("jobs", ())):
            yield f"{',' if job_index else ''}\n{_line(job)}"
        yield "]}"
    yield "]}"


def _line(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)


def finite(value: Any) -> Any:
    """Replaces NaN and infinities in a value by YAML's words for them, since JSON has none."""
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    if isinstance(value, Mapping):
        return {key: finite(inner) for key, inner in value.items()}
    return [finite(inner) for inner in value] if isinstance(value, list) else value
