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
from linkwright.pipeline.options import JSON, LONG_OPTIONS
from linkwright.pipeline.reference.exit_status import BUILT, FAILED, UNMET
from linkwright.pipeline.sweep import job_list, listed_jobs
from linkwright.pipeline.sweep.fetching import job_names
from linkwright.pipeline.sweep.job_list import JobList, Share
from linkwright.pipeline.sweep.outcome import Outcome, sweep_status
from linkwright.pipeline.sweep.run import print_line
from linkwright.pipeline.sweep.terminal_table import table
from linkwright.pipeline.terminal.output import say, terminal_width
from linkwright.stages.robot.errors import Offline

_KINDS = ("done", "running", "failed", STALE, "missing")
"""The kinds of jobs, in the order of the message. Jobs that are built or unmet count as done."""


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

    as_json: bool
    """Whether to return a JSON document."""

    def answer(
        self,
        jobs: JobList,
        status: int,
        outcomes: Sequence[Outcome] = (),
        failures: Sequence[str] = (),
    ) -> int | CommandDocument:
        """Returns the exit status, or, with `--json`, the document that contains it."""
        if not self.as_json:
            return status
        return jobs_document(self.path, jobs.folder, len(jobs.jobs), outcomes, status, failures)


def jobs(arguments: Sequence[str]) -> int | CommandDocument:
    """Shows the states of the jobs of a list, or with `--fetch` fetches their sources; returns the exit
    status, or with `--json` a document. Raises ConfigError for wrong usage or a file that is not a list of
    jobs."""
    request = _parse_arguments("jobs", arguments, ("--fetch",))
    rest = request.rest
    if any(argument != "--fetch" for argument in rest) or (rest and request.share):
        raise ConfigError("expected a list of jobs, and --fetch or --shard", "jobs", _usage("jobs"))
    return _fetch(request) if rest else _show_status(request)


def job(arguments: Sequence[str]) -> int | CommandDocument:
    """Runs a job of a list, or a share of its jobs; returns the exit status, or with `--json` a document.
    Raises ConfigError for wrong usage, and for a file that is not a list of jobs."""
    request = _parse_arguments("job", arguments, ())
    path, rest, share = request.path, request.rest, request.share
    if len(rest) != (0 if share else 1):
        raise ConfigError("expected a list of jobs, and a number or --shard", "job", _usage("job"))
    with listed_jobs.open_list(path) as listed:
        chosen = [job_list.job_numbered(listed, rest[0], path)] if rest else listed.share(share)
        outcomes, unfetched = listed_jobs.run(listed, chosen, is_quiet=request.is_quiet)
    for outcome in outcomes:
        if outcome.status not in (BUILT, UNMET):
            lines = [f"error: job {outcome.number} ({outcome.label}): {outcome.message}", *outcome.problems]
            say("\n  ".join(lines), sys.stderr)
        if not request.is_quiet:
            say(f"{outcome.folder}: {outcome.message}")
    if unfetched:
        jobs_text = "this job" if len(unfetched) == 1 else "these jobs"
        text = f"nothing is fetched for {jobs_text} yet"
        raise Offline(text, job_names(unfetched), f"linkwright jobs {shlex.quote(str(path))} --fetch")
    # A single job has its own exit status, unless it has not ended.
    status = sweep_status(outcomes)
    if rest and outcomes[0].status:
        status = outcomes[0].status
    return request.answer(listed, status, outcomes)


def _usage(verb: str) -> str:
    return f"linkwright {verb} --help shows its usage"


def _parse_arguments(verb: str, arguments: Sequence[str], options: Sequence[str]) -> _Request:
    """Parses the arguments; raises ConfigError for an unknown option or without a list."""
    unshared, share = job_list.split_share(arguments)
    rest = [word for word in unshared if word != JSON and LONG_OPTIONS.get(word, word) != "--quiet"]
    is_quiet = any(LONG_OPTIONS.get(word, word) == "--quiet" for word in unshared)
    unknown = [argument for argument in rest if argument.startswith("-") and argument not in options]
    if unknown:
        raise ConfigError(f"there is no option {unknown[0]}", verb, _usage(verb))
    paths = [argument for argument in rest if argument not in options]
    if not paths:
        raise ConfigError("expected a list of jobs", verb, _usage(verb))
    rest.remove(paths[0])
    return _Request(Path(paths[0]), rest, share, is_quiet, JSON in unshared)


def _fetch(request: _Request) -> int | CommandDocument:
    """Fetches the sources of all jobs, and writes the list with the states that were fetched."""
    path, failures = request.path, list[str]()
    with listed_jobs.open_list(path) as listed:
        pinned = listed
        if listed.sources:
            pinned, failures = listed_jobs.fetch(listed, (lambda _: None) if request.is_quiet else print_line)
        elif not request.is_quiet:
            say(f"{path}: nothing to fetch: the sources of all jobs are on this computer")
    if pinned != listed:
        job_list.write(path, pinned)
    for line in failures:
        say(f"error: {line}", sys.stderr)
    return request.answer(listed, FAILED if failures else BUILT, failures=failures)


def _show_status(request: _Request) -> int | CommandDocument:
    """Shows a table of the jobs and their number by kind, and writes the summary of the sweep."""
    with listed_jobs.open_list(request.path) as listed:
        outcomes = listed_jobs.outcomes(listed.share(request.share))
        # The summary is of all jobs, so a share writes none.
        if request.share is None:
            listed_jobs.summarise(listed, outcomes)
        status = sweep_status(outcomes)
        is_shown = not request.as_json and (status != BUILT or not request.is_quiet)
        if is_shown and outcomes:
            say(table(outcomes, Path(listed.folder), terminal_width(sys.stdout)))
    if is_shown:
        numbers = Counter(map(_job_kind, outcomes))
        say(", ".join(f"{numbers[kind]} {kind}" for kind in _KINDS if numbers[kind]) or "no jobs")
    return request.answer(listed, status, outcomes)


def _job_kind(outcome: Outcome) -> str:
    """Returns the kind of a job: built and unmet jobs are done."""
    if outcome.message == STALE:
        return STALE
    return "done" if outcome.state in ("built", "unmet") else outcome.state
