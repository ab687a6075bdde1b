"""Runs or plans a sweep from the command line."""

import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from linkwright.pipeline.config.compose import session
from linkwright.pipeline.config.files.trust import BASIC
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.options import Command
from linkwright.pipeline.output.folder import named
from linkwright.pipeline.report import Report
from linkwright.pipeline.run.preflight import offline_problems, sweep_problems
from linkwright.pipeline.sweep import job_list
from linkwright.pipeline.sweep.fetching import Fetching, fetch_sources
from linkwright.pipeline.sweep.folder import keep, prepare
from linkwright.pipeline.sweep.fresh import kept_fresh
from linkwright.pipeline.sweep.launch import Account, settled
from linkwright.pipeline.sweep.launched import launch_jobs
from linkwright.pipeline.sweep.listed import job_list_of
from linkwright.pipeline.sweep.outcome import Outcome, sweep_status
from linkwright.pipeline.sweep.outcome_files import outcomes_of
from linkwright.pipeline.sweep.run import jobs_of, judge_folders
from linkwright.pipeline.sweep.search import run_search
from linkwright.pipeline.sweep.terminal_table import table
from linkwright.pipeline.terminal.output import say, width_of
from linkwright.stages.robot.text.plural import count


def sweep(command: Command, build: Callable[[Plan], Report] | None) -> int:
    """Builds each robot of the sweep; returns the exit status."""
    with session(command.config_dirs, judge=sweep_problems) as composer:
        request = composer.with_params(*composer.read(command.overrides, multirun=True))
        if request.sweeping.sweeper != BASIC:
            return run_search(command, composer, request, build)
        composed_sweep = jobs_of(composer, request, sweep_problems)
        judge_folders(composed_sweep.jobs)
        config = settled(composer.ours(composed_sweep.sweeping.launcher), composed_sweep.sweeping)
        prepare(composed_sweep.root, composed_sweep.jobs, command.overrides)
        is_quiet = command.detail == "errors"
        jobs = composed_sweep.jobs if build else fetch_sources(composed_sweep.jobs, is_quiet=is_quiet)
        account = Account(request.tree, command.overrides, composed_sweep.overrides)
        with named(composed_sweep.root), kept_fresh(composed_sweep.root):
            returned = launch_jobs(jobs, build, config, composed_sweep.root, account, is_quiet=is_quiet)
    outcomes = _completed(outcomes_of(composed_sweep.root), returned)
    status = sweep_status(outcomes)
    if status or not is_quiet:
        say(table(outcomes, composed_sweep.root, width_of(sys.stdout)))
    keep(outcomes, composed_sweep.root)
    return status


def plan(command: Command) -> int:
    """Writes the list of the jobs of a sweep, and builds nothing; returns the exit status."""
    path = Path(command.plan)
    judge = offline_problems if command.offline else sweep_problems
    with session(command.config_dirs, judge=judge) as composer:
        request = composer.with_params(*composer.read(command.overrides, multirun=True))
        if request.sweeping.sweeper != BASIC:
            msg = f"hydra/sweeper={request.sweeping.sweeper} chooses its jobs by the results of earlier jobs"
            raise ConfigError(msg, "--plan", "leave out --plan, or list the values without a search")
        composed_sweep = jobs_of(composer, request, judge)
    judge_folders(composed_sweep.jobs)
    job_list.require_place(path)
    fetching = Fetching(composed_sweep.jobs)
    if command.offline:
        fetching.guess()
    else:
        fetching.look()
    job_list.write(path, job_list_of(command, composed_sweep, fetching, path))
    if command.detail != "errors":
        size = len(composed_sweep.jobs)
        say(f"{path}: {fetching.line(size) if fetching.groups else count(size, 'job')}")
    for line in fetching.failures():
        say(f"error: {line}", sys.stderr)
    return 1 if fetching.failures() else 0


def _completed(recorded: Iterable[Outcome], returned: Sequence[Outcome]) -> list[Outcome]:
    """Returns the outcome of each job: the outcome that it left in a file, or, if it could not write that
    file (on a full disk, for example), the outcome that it returned."""
    by_number = {outcome.number: outcome for outcome in recorded}
    for outcome in returned:
        if outcome.number not in by_number or not by_number[outcome.number].ended:
            by_number[outcome.number] = outcome
    return [by_number[number] for number in sorted(by_number)]
