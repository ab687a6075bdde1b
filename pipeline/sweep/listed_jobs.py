"""Writes the jobs of a sweep as a list; composes, fetches and runs them again; reads their outcomes."""

import contextlib
import functools
import json
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import compress
from operator import not_
from pathlib import Path

from linkwright.pipeline.caching import actions
from linkwright.pipeline.config.compose import session
from linkwright.pipeline.config.hydra.node import JobIdentity
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.errors import CacheError, ConfigError, OutputError, refusal
from linkwright.pipeline.json_documents.jobs import STALE
from linkwright.pipeline.options import Command
from linkwright.pipeline.run.build import build
from linkwright.pipeline.run.preflight import suffix_of
from linkwright.pipeline.secrets import withhold_keys
from linkwright.pipeline.stages.prefetched import Prefetched, source_identity
from linkwright.pipeline.sweep import folder, job_list
from linkwright.pipeline.sweep.fetching import Fetching
from linkwright.pipeline.sweep.job_list import Digests, JobList, ListedJob
from linkwright.pipeline.sweep.outcome import Outcome, missing_outcome
from linkwright.pipeline.sweep.outcome_files import read_outcome
from linkwright.pipeline.sweep.run import Job, Sweep, Task, expanded, usual_folder
from linkwright.stages.fetch import is_remote

_CONFIG, _REPORT = "config.yaml", "report.json"


def job_list_of(command: Command, sweep: Sweep, fetching: Fetching, path: Path) -> JobList:
    """Returns the list of the jobs of a sweep, for a file `path`; `fetching` knows the number of API
    calls."""
    digests, sources = Digests(), dict[int, tuple[int, str]]()
    for group in fetching.groups:
        sources |= dict.fromkeys(group.numbers, (group.numbers[0], group.pin))
    jobs = []
    for job in sweep.jobs:
        source, pin = sources.get(job.number, (None, ""))
        identity = (job.number, job.label, job.overrides, digests.of(job.plan.tree()))
        jobs.append(ListedJob(*identity, job.plan.folder.as_posix(), suffix_of(job.plan), source, pin))
    working_folder = os.path.relpath(Path.cwd(), path.absolute().parent)
    command_values = (Path(working_folder).as_posix(), command.config_dirs, command.overrides)
    return JobList(*command_values, sweep.root.as_posix(), fetching.more, fetching.exact, tuple(jobs))


@contextlib.contextmanager
def open_list(path: Path) -> Iterator[JobList]:
    """Yields the list in a file, and makes its working folder that of this process for the time. Raises
    ConfigError without such a list or folder."""
    jobs = job_list.read(path)
    working_folder = path.absolute().parent / jobs.cwd
    if not working_folder.is_dir():
        msg = f"its working folder {jobs.cwd}, relative to the list, does not exist"
        raise ConfigError(msg, str(path), "move the list back to its place in a tree with the same files")
    with contextlib.chdir(working_folder):
        yield jobs


def compose_jobs(jobs: JobList, chosen: Sequence[ListedJob]) -> list[Job]:
    """Composes the `chosen` jobs of a list again. Raises ConfigError if their configuration has changed."""
    digests, composed_jobs = Digests(), []
    with session(jobs.config_dirs) as composer:
        request = composer.with_params(*composer.read(jobs.overrides, multirun=True))
        if request.problems:
            raise refusal(request.problems, "the list of jobs")
        all_overrides, labels = expanded(composer, request)
        for job in chosen:
            if labels[job.number : job.number + 1] != [job.label]:
                raise _stale(job)
            composed_job = composer.compose(all_overrides[job.number], job=JobIdentity(job.number, job.label))
            plan = composed_job.plan.model_copy(update={"output": job.folder})
            # A subdir of the command may contain the time, which has changed.
            usual_path = Path(jobs.folder) / usual_folder(job.label, all_overrides[job.number])
            is_placed = bool(composed_job.sweeping.subdir) or Path(job.folder) == usual_path
            if not is_placed or suffix_of(plan) != job.suffix or digests.of(plan.tree()) != job.digest:
                raise _stale(job)
            first = Prefetched(source_identity(plan), job.pin) if is_remote(plan) else None
            composed_jobs.append(Job(job.number, job.label, plan, job.overrides, job.pin, first))
    return composed_jobs


def _stale(job: ListedJob) -> ConfigError:
    msg = "the list is stale: a file of the configuration, or linkwright, has changed since it was written"
    return ConfigError(msg, f"job {job.number} ({job.label})", "write it again: the sweep with --plan FILE")


def run(
    jobs: JobList, chosen: Sequence[ListedJob], *, is_quiet: bool = False
) -> tuple[list[Outcome], list[Job]]:
    """Builds jobs one after the other, without an API key or an API call; returns their outcomes, and the
    jobs that are not built because nothing is fetched for them."""
    all_jobs = compose_jobs(jobs, chosen)
    fetched = [job.fetched is None or _is_fetched(job.plan, job.fetched) for job in all_jobs]
    built, unfetched = list(compress(all_jobs, fetched)), list(compress(all_jobs, map(not_, fetched)))
    root = Path(jobs.folder)
    if built and not folder.is_marked(root):
        try:
            folder.mark(root, built[0].plan)
        except OutputError:
            # Another job may have marked it at the same time.
            if not folder.is_marked(root):
                raise
    task = Task(built, functools.partial(build, sweep=root), is_quiet=is_quiet)
    with withhold_keys():
        return [task(job.number) for job in built], unfetched


def _is_fetched(plan: Plan, stage: Prefetched) -> bool:
    try:
        with actions.opened(plan.cache.mode, plan.cache.dir, os.environ) as cache:
            return cache.find(stage.action.key) is not None
    except CacheError:
        return True  # or not: the job fails with this error, and leaves it in the summary


def fetch(jobs: JobList, say: Callable[[str], None]) -> tuple[JobList, list[str]]:
    """Fetches the sources of a list once; returns the list with the state that its jobs build, and a message
    for each reason why configurations cannot be fetched."""
    fetching = Fetching(compose_jobs(jobs, jobs.sources))
    fetching.ask_servers()
    say(fetching.line(len(jobs.jobs)))
    pins = {job.number: job.pin for job in fetching.fetch(say)}
    pinned = [job if job.source is None else replace(job, pin=pins[job.source]) for job in jobs.jobs]
    return replace(jobs, jobs=tuple(pinned)), fetching.failures()


def outcomes(chosen: Sequence[ListedJob]) -> list[Outcome]:
    """Returns the outcomes that the jobs have left in their folders. A job whose folder contains another
    build has the message STALE."""
    ended = []
    for job in chosen:
        default = missing_outcome(job.number, job.label, job.overrides, os.path.relpath(job.folder))
        outcome = read_outcome(default, Path(job.folder))
        # A folder that is named by the job's number may hold the outcome of another sweep.
        is_other = outcome.ended and outcome.overrides != job.overrides
        if is_other or (outcome.state in ("built", "unmet") and not _holds_build_of(job)):
            outcome = replace(default, message=STALE)
        ended.append(outcome)
    return ended


def _holds_build_of(job: ListedJob) -> bool:
    """Tells whether the output folder contains the build of the job's configuration and document state."""
    output_folder = Path(f"{job.folder}{job.suffix}")
    try:
        if sha256((output_folder / _CONFIG).read_bytes()) != job.digest:
            return False
        if not job.pin.startswith("m/"):
            return True
        source = json.loads((output_folder / _REPORT).read_bytes())["source"]
    except (OSError, ValueError, KeyError, TypeError):
        return False
    return bool(f"m/{source.get('microversion')}" == job.pin)


def summarise(jobs: JobList, results: Sequence[Outcome]) -> None:
    """Writes the summary of the sweep, if any of its jobs has begun."""
    root = Path(jobs.folder)
    if not folder.is_marked(root):
        return
    folders = [Path(job.folder) for job in jobs.jobs]
    if not folder.is_recorded(root, folders):
        missing = [missing_outcome(job.number, job.label, job.overrides, job.folder) for job in jobs.jobs]
        folder.record(root, missing, jobs.overrides)
    folder.write_summaries(results, root)
