"""Runs jobs of a sweep, whose sources are fetched, under its launcher."""

import functools
from collections.abc import Callable, Sequence
from pathlib import Path

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.report import Report
from linkwright.pipeline.run.build import build as build_robot
from linkwright.pipeline.secrets import withhold_keys
from linkwright.pipeline.sweep.launch import Config, SweepRecord, announcement, launch
from linkwright.pipeline.sweep.outcome import Outcome
from linkwright.pipeline.sweep.run import Job, Task, print_line


def launch_jobs(
    jobs: Sequence[Job],
    build: Callable[[Plan], Report] | None,
    config: Config,
    root: Path,
    record: SweepRecord,
    *,
    is_quiet: bool,
    first: int = 0,
) -> list[Outcome]:
    """Runs the jobs of the sweep in the folder `root`, and returns their outcomes. No process that the
    launcher starts has an API key. `build` replaces the real build; `first`: the number of the first job."""
    task = Task(jobs, build or functools.partial(build_robot, sweep=root), is_quiet=is_quiet)
    text = announcement(config, len(jobs), root)
    if text and not is_quiet:
        print_line(text)
    with withhold_keys():
        return launch(config, task, root, record, first)
