"""The folder of a sweep: its own files beside the folders of its jobs."""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkwright.pipeline.caching import actions
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.output import conflicts, manifest
from linkwright.pipeline.output.folder import move_aside, named
from linkwright.pipeline.output.location import ELSEWHERE, absolute, require_free
from linkwright.pipeline.page.sweep.document import page
from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.show.live import ENGINE_FILE, engine_file, is_plain
from linkwright.stages.robot.text.printable import printable_lines

if TYPE_CHECKING:
    from linkwright.pipeline.sweep.outcome import Outcome

SUMMARY, PAGE, ACCOUNT = "summary.json", "summary.html", "multirun.yaml"
OWN = (SUMMARY, PAGE, ACCOUNT, ENGINE_FILE)
"""The files of a sweep itself: the outcomes of its jobs as data and for people, Hydra's record of the sweep,
and the engine that the pages of its jobs share."""


def prepare(root: Path, plan: Plan, typed: Sequence[str], environ: Mapping[str, str] = os.environ) -> None:
    """Creates and marks the folder of a sweep, and records a new run with its `typed` overrides after earlier
    runs; `plan`: the plan of any job.

    ConfigError where no sweep can be there, the folder is of others, or a file that is not linkwright's is in
    its way; OutputError where it cannot be written.
    """
    with named(root):
        place = absolute(root)
        require_free(place, {}, actions.folder(plan.cache.dir, environ))
        if manifest.is_build(place):
            raise ConfigError(f"{root} is the folder of a build", "output", ELSEWHERE)
        if manifest.is_of_others(place):
            raise conflicts.foreign(root)
        stopped = _in_the_way(place)
        if stopped and not plan.overwrite:
            raise ConfigError(conflicts.message(root, stopped), "output", conflicts.ways_out(root))
        place.mkdir(parents=True, exist_ok=True)
        for path in stopped:
            move_aside(place / path, place, path)
        # Any content counts as ours until the sweep ends, since it may be killed.
        manifest.write(place, dict.fromkeys(OWN))
        run = {"started": f"{datetime.now(UTC):%Y-%m-%dT%H:%M:%SZ}", "overrides": list(typed), "jobs": []}
        _write(place, [*_runs(place), run])
        if plan.page.live != "kinematics" and not is_plain(environ):
            (place / ENGINE_FILE).write_bytes(engine_file())


def keep(outcomes: Sequence["Outcome"], root: Path) -> None:
    """Writes the outcomes of the jobs to `summary.json` and `summary.html`; OutputError where these cannot be
    written."""
    jobs = [asdict(outcome) for outcome in outcomes]
    with named(root):
        *before, run = _runs(root)
        _write(root, [*before, {**run, "jobs": jobs}])
        _replace(root / PAGE, _page(root, jobs))
        there = [name for name in OWN if (root / name).is_file()]
        manifest.write(root, {name: sha256((root / name).read_bytes()) for name in there})


def _in_the_way(root: Path) -> dict[str, str]:
    """Foreign or changed files at the paths that a sweep writes: path → reason."""
    own = manifest.ours(root) or dict.fromkeys(OWN if manifest.is_sweep(root) else ())
    others = manifest.others(root, own) if root.is_dir() else ()
    return {entry.path: conflicts.why(entry) for entry in others if entry.path in OWN}


def _runs(root: Path) -> list[dict[str, Any]]:
    """The recorded runs of the folder, the oldest first; of version 0.1 only the last run."""
    try:
        kept = json.loads((root / SUMMARY).read_bytes())
    except (OSError, ValueError):
        return []
    runs = kept.get("runs") if isinstance(kept, dict) else None
    if isinstance(runs, list):
        return [run for run in runs if isinstance(run, dict)]
    jobs = kept.get("jobs") if isinstance(kept, dict) else None
    return [{"started": None, "overrides": [], "jobs": jobs}] if jobs else []


def _write(root: Path, runs: Sequence[Mapping[str, Any]]) -> None:
    tree = {manifest.SWEEP: 2, "runs": list(runs)}
    text = json.dumps(Secrets(os.environ).within(tree), indent=2, ensure_ascii=False)
    _replace(root / SUMMARY, printable_lines(text).encode() + b"\n")


def _page(root: Path, jobs: Sequence[Mapping[str, Any]]) -> bytes:
    """The page about the last run."""
    inside = [{**job, "folder": Path(os.path.relpath(job["folder"], root)).as_posix()} for job in jobs]
    beside = [name for name in (SUMMARY, ACCOUNT) if (root / name).is_file()]
    secrets = Secrets(os.environ)
    return page(
        secrets.blanked(root.name), secrets.within(inside), lambda path: (root / path).exists(), beside
    )


def _replace(file: Path, data: bytes) -> None:
    staged = file.with_name(f".{file.name}.tmp")
    staged.write_bytes(data)
    staged.replace(file)
