"""Runs or plans a sweep from the command line."""

import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from linkwright.pipeline.config.compose import session
from linkwright.pipeline.config.files.trust import BASIC_OPTION
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.json_documents.document import CommandDocument
from linkwright.pipeline.json_documents.jobs import jobs_document, sweep_document
from linkwright.pipeline.options import Command
from linkwright.pipeline.output.folder import output_errors
from linkwright.pipeline.report import Report
from linkwright.pipeline.run.preflight import job_problems, offline_job_problems
from linkwright.pipeline.sweep import job_list
from linkwright.pipeline.sweep.fetching import Fetching, fetch_sources
from linkwright.pipeline.sweep.folder import prepare, write_summaries
from linkwright.pipeline.sweep.job_launcher import launch_jobs
from linkwright.pipeline.sweep.launch import Config, SweepRecord, launcher_config
from linkwright.pipeline.sweep.listed_jobs import job_list_of
from linkwright.pipeline.sweep.outcome import Outcome, sweep_status
from linkwright.pipeline.sweep.outcome_files import outcomes_of
from linkwright.pipeline.sweep.run import Sweep, compose_sweep, require_free_folders
from linkwright.pipeline.sweep.search import run_search
from linkwright.pipeline.sweep.summary_updates import updating_summary
from linkwright.pipeline.sweep.terminal_table import table
from linkwright.pipeline.terminal.output import say, terminal_width
from linkwright.stages.robot.text.plural import count


def run_sweep(command: Command, build: Callable[[Plan], Report] | None) -> int | CommandDocument:
    """Builds each robot of the sweep; returns the exit status, or with `--json` a document. `build`: replaces
    the real build; None for the real build, for which the sources are fetched first."""
    with session(command.config_dirs, judge=job_problems) as composer:
        request = composer.with_params(*composer.read(command.overrides, multirun=True))
        if request.sweeping.sweeper != BASIC_OPTION:
            return run_search(command, composer, request, build)
        composed_sweep = compose_sweep(composer, request, job_problems)
        require_free_folders(composed_sweep.jobs)
        settings = composed_sweep.sweeping
        config = launcher_config(composer.hydra_config(settings.launcher), settings)
        record = SweepRecord(request.tree, command.overrides, composed_sweep.overrides)
        returned_outcomes = _run_jobs(command, composed_sweep, config, record, build)
    outcomes = _merged_outcomes(outcomes_of(composed_sweep.root), returned_outcomes)
    return _report(command, outcomes, composed_sweep.root)


def _run_jobs(
    command: Command,
    composed_sweep: Sweep,
    config: Config,
    record: SweepRecord,
    build: Callable[[Plan], Report] | None,
) -> list[Outcome]:
    """Prepares the folder of the sweep, and runs its jobs under the launcher. Returns the outcomes that the
    jobs returned."""
    root, is_quiet = composed_sweep.root, _is_quiet(command)
    prepare(root, composed_sweep.jobs, command.overrides)
    jobs = composed_sweep.jobs if build else fetch_sources(composed_sweep.jobs, is_quiet=is_quiet)
    with output_errors(root), updating_summary(root):
        return launch_jobs(jobs, build, config, root, record, is_quiet=is_quiet)


def _report(command: Command, outcomes: Sequence[Outcome], root: Path) -> int | CommandDocument:
    """Shows the outcomes, writes the summaries of the sweep, and returns the exit status, or with `--json` a
    document."""
    is_quiet = _is_quiet(command)
    status = sweep_status(outcomes)
    if (status or not is_quiet) and not command.json:
        say(table(outcomes, root, terminal_width(sys.stdout)))
    write_summaries(outcomes, root)
    return sweep_document(status, root, outcomes) if command.json else status


def _is_quiet(command: Command) -> bool:
    return command.detail == "errors"


def write_plan(command: Command) -> int | CommandDocument:
    """Writes the list of the jobs of a sweep, and builds nothing; returns the exit status, or with `--json` a
    document."""
    path = Path(command.plan)
    find_problems = offline_job_problems if command.offline else job_problems
    with session(command.config_dirs, judge=find_problems) as composer:
        request = composer.with_params(*composer.read(command.overrides, multirun=True))
        if request.sweeping.sweeper != BASIC_OPTION:
            msg = f"hydra/sweeper={request.sweeping.sweeper} chooses its jobs by the results of earlier jobs"
            raise ConfigError(msg, "--plan", "leave out --plan, or list the values without a search")
        composed_sweep = compose_sweep(composer, request, find_problems)
    require_free_folders(composed_sweep.jobs)
    job_list.require_place(path)
    fetching = Fetching(composed_sweep.jobs)
    # Asking the servers takes a few calls for each document. An estimate from the cache takes none.
    if command.offline:
        fetching.estimate_from_cache()
    else:
        fetching.ask_servers()
    job_list.write(path, job_list_of(command, composed_sweep, fetching, path))
    size, failures = len(composed_sweep.jobs), fetching.failures()
    if not _is_quiet(command):
        say(f"{path}: {fetching.line(size) if fetching.groups else count(size, 'job')}")
    for line in failures:
        say(f"error: {line}", sys.stderr)
    if command.json:
        return jobs_document(path, composed_sweep.root.as_posix(), size, failures=failures)
    return 1 if failures else 0


def _merged_outcomes(
    recorded_outcomes: Iterable[Outcome], returned_outcomes: Sequence[Outcome]
) -> list[Outcome]:
    """Returns the outcome of each job: the outcome that it left in a file, or, if it could not write that
    file (on a full disk, for example), the outcome that it returned."""
    by_number = {outcome.number: outcome for outcome in recorded_outcomes}
    for outcome in returned_outcomes:
        if outcome.number not in by_number or not by_number[outcome.number].ended:
            by_number[outcome.number] = outcome
    return [by_number[number] for number in sorted(by_number)]
