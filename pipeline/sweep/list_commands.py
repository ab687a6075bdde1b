"""Runs the verbs about a list of jobs: `linkwright jobs` and `linkwright job`."""

import shlex
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.json_documents.document import CommandDocument
from linkwright.pipeline.json_documents.jobs import STALE, jobs_document
from linkwright.pipeline.options import JSON, SHORT
from linkwright.pipeline.sweep import job_list, listed_jobs
from linkwright.pipeline.sweep.fetching import named
from linkwright.pipeline.sweep.job_list import JobList, Share
from linkwright.pipeline.sweep.outcome import Outcome, sweep_status
from linkwright.pipeline.sweep.run import print_line
from linkwright.pipeline.sweep.terminal_table import table
from linkwright.pipeline.terminal.output import say, terminal_width
from linkwright.stages.robot.errors import Offline

_KINDS = ("done", "running", "failed", STALE, "missing")
"""The kinds of jobs, in the order of the message."""


@dataclass(frozen=True, slots=True)
class _Request:
    """The parsed arguments."""

    path: Path
    """The list of jobs."""

    rest: list[str]
    """The arguments besides the list, the share and the common options."""

    share: Share | None
    is_quiet: bool
    """Whether to show only errors."""

    json: bool
    """Whether to return a JSON document."""

    def answer(
        self,
        jobs: JobList,
        status: int,
        outcomes: Sequence[Outcome] = (),
        failures: Sequence[str] = (),
    ) -> int | CommandDocument:
        """Returns the exit status, or, with `--json`, the document that contains it."""
        if not self.json:
            return status
        return jobs_document(self.path, jobs.folder, len(jobs.jobs), outcomes, status, failures)


def jobs(arguments: Sequence[str]) -> int | CommandDocument:
    """Shows the states of the jobs of a list, or with `--fetch` fetches their sources; returns the exit
    status, or with `--json` a document. Raises ConfigError for wrong usage or a file that is not a list of
    jobs."""
    request = _parsed("jobs", arguments, ("--fetch",))
    rest = request.rest
    if any(argument != "--fetch" for argument in rest) or (rest and request.share):
        raise ConfigError("expected a list of jobs, and --fetch or --shard", "jobs", _usage("jobs"))
    return _fetch(request) if rest else _tell(request)


def job(arguments: Sequence[str]) -> int | CommandDocument:
    """Runs a job of a list, or a share of its jobs; returns the exit status, or with `--json` a document.
    Raises ConfigError for wrong usage, and for a file that is not a list of jobs."""
    request = _parsed("job", arguments, ())
    path, rest, share = request.path, request.rest, request.share
    if len(rest) != (0 if share else 1):
        raise ConfigError("expected a list of jobs, and a number or --shard", "job", _usage("job"))
    with listed_jobs.opened(path) as job_list_:
        chosen = [job_list.job_numbered(job_list_, rest[0], path)] if rest else job_list_.share(share)
        outcomes, unfetched = listed_jobs.run(job_list_, chosen, is_quiet=request.is_quiet)
    for outcome in outcomes:
        if outcome.status not in (0, 3):
            lines = [f"error: job {outcome.number} ({outcome.label}): {outcome.message}", *outcome.problems]
            say("\n  ".join(lines), sys.stderr)
        if not request.is_quiet:
            say(f"{outcome.folder}: {outcome.message}")
    if unfetched:
        text = (
            "nothing is fetched for this job yet"
            if len(unfetched) == 1
            else "nothing is fetched for them yet"
        )
        raise Offline(text, named(unfetched), f"linkwright jobs {shlex.quote(str(path))} --fetch")
    status = (outcomes[0].status if rest else None) or sweep_status(outcomes)
    return request.answer(job_list_, status, outcomes)


def _usage(verb: str) -> str:
    return f"linkwright {verb} --help shows how it is called"


def _parsed(verb: str, arguments: Sequence[str], options: Sequence[str]) -> _Request:
    """Parses the arguments; raises ConfigError for an unknown option or without a list."""
    unshared, share = job_list.split_share(arguments)
    rest = [word for word in unshared if word != JSON and SHORT.get(word, word) != "--quiet"]
    is_quiet = any(SHORT.get(word, word) == "--quiet" for word in unshared)
    unknown = [argument for argument in rest if argument.startswith("-") and argument not in options]
    if unknown:
        raise ConfigError(f"there is no option {unknown[0]}", verb, _usage(verb))
    places = [argument for argument in rest if argument not in options]
    if not places:
        raise ConfigError("expected a list of jobs", verb, _usage(verb))
    rest.remove(places[0])
    return _Request(Path(places[0]), rest, share, is_quiet, JSON in unshared)


def _fetch(request: _Request) -> int | CommandDocument:
    """Fetches the sources of all jobs, and writes the list with the states that were fetched."""
    path, failed = request.path, list[str]()
    with listed_jobs.opened(path) as job_list_:
        pinned = job_list_
        if job_list_.sources:
            pinned, failed = listed_jobs.fetch(
                job_list_, (lambda _: None) if request.is_quiet else print_line
            )
        elif not request.is_quiet:
            say(f"{path}: nothing to fetch: the sources of all jobs are on this computer")
    if pinned != job_list_:
        job_list.write(path, pinned)
    for line in failed:
        say(f"error: {line}", sys.stderr)
    return request.answer(job_list_, 1 if failed else 0, failures=failed)


def _tell(request: _Request) -> int | CommandDocument:
    """Shows a table of the jobs and their number by kind, and writes the summary of the sweep."""
    with listed_jobs.opened(request.path) as job_list_:
        outcomes = listed_jobs.outcomes(job_list_.share(request.share))
        # The summary is of all jobs, so a share writes none.
        if request.share is None:
            listed_jobs.summarise(job_list_, outcomes)
        status = sweep_status(outcomes)
        if request.json or (request.is_quiet and not status):
            return request.answer(job_list_, status, outcomes)
        if outcomes:
            say(table(outcomes, Path(job_list_.folder), terminal_width(sys.stdout)))
    numbers = Counter(map(_kind, outcomes))
    say(", ".join(f"{numbers[kind]} {kind}" for kind in _KINDS if numbers[kind]) or "no jobs")
    return status


def _kind(outcome: Outcome) -> str:
    """Returns the kind of a job: built and unmet jobs are done."""
    if outcome.message == STALE:
        return STALE
    return "done" if outcome.state in ("built", "unmet") else outcome.state
