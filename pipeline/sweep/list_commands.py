"""Runs the verbs about a list of jobs: `linkwright jobs` and `linkwright job`."""

import shlex
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.options import SHORT
from linkwright.pipeline.sweep import job_list, listed_jobs
from linkwright.pipeline.sweep.fetching import named
from linkwright.pipeline.sweep.job_list import Share
from linkwright.pipeline.sweep.outcome import Outcome, sweep_status
from linkwright.pipeline.sweep.run import print_line
from linkwright.pipeline.sweep.terminal_table import table
from linkwright.pipeline.terminal.output import say, width_of
from linkwright.stages.robot.errors import Offline

_KINDS = ("done", "running", "failed", listed_jobs.STALE, "missing")
"""The kinds of jobs, in the order of the message."""


def jobs(arguments: Sequence[str]) -> int:
    """Tells the states of the jobs of a list, or with `--fetch` fetches their sources; returns the exit
    status. Raises ConfigError for wrong usage, and for a file that is no list."""
    path, rest, share, is_quiet = _parsed("jobs", arguments, ("--fetch",))
    if any(argument != "--fetch" for argument in rest) or (rest and share):
        raise ConfigError("expected a list of jobs, and --fetch or --shard", "jobs", _usage("jobs"))
    return _fetch(path, is_quiet=is_quiet) if rest else _tell(path, share, is_quiet=is_quiet)


def job(arguments: Sequence[str]) -> int:
    """Runs a job of a list, or a share of its jobs; returns the exit status. Raises ConfigError for wrong
    usage, and for a file that is no list."""
    path, rest, share, is_quiet = _parsed("job", arguments, ())
    if len(rest) != (0 if share else 1):
        raise ConfigError("expected a list of jobs, and a number or --shard", "job", _usage("job"))
    with listed_jobs.opened(path) as job_list_:
        chosen = [job_list.job_numbered(job_list_, rest[0], path)] if rest else job_list_.share(share)
        outcomes, unfetched = listed_jobs.run(job_list_, chosen, is_quiet=is_quiet)
    for outcome in outcomes:
        if outcome.status not in (0, 3):
            lines = [f"error: job {outcome.number} ({outcome.label}): {outcome.message}", *outcome.problems]
            say("\n  ".join(lines), sys.stderr)
        if not is_quiet:
            say(f"{outcome.folder}: {outcome.message}")
    if unfetched:
        text = (
            "nothing is fetched for this job yet"
            if len(unfetched) == 1
            else "nothing is fetched for them yet"
        )
        raise Offline(text, named(unfetched), f"linkwright jobs {shlex.quote(str(path))} --fetch")
    single = outcomes[0].status if rest else None
    return sweep_status(outcomes) if single is None else single


def _usage(verb: str) -> str:
    return f"linkwright {verb} --help shows how it is called"


def _parsed(
    verb: str, arguments: Sequence[str], options: Sequence[str]
) -> tuple[Path, list[str], Share | None, bool]:
    """Returns the path of the list, the other arguments, the share, and whether to show only errors."""
    unshared, share = job_list.split_share(arguments)
    rest = [argument for argument in unshared if SHORT.get(argument, argument) != "--quiet"]
    is_quiet = len(rest) < len(unshared)
    unknown = [argument for argument in rest if argument.startswith("-") and argument not in options]
    if unknown:
        raise ConfigError(f"there is no option {unknown[0]}", verb, _usage(verb))
    places = [argument for argument in rest if argument not in options]
    if not places:
        raise ConfigError("expected a list of jobs", verb, _usage(verb))
    rest.remove(places[0])
    return Path(places[0]), rest, share, is_quiet


def _fetch(path: Path, *, is_quiet: bool) -> int:
    with listed_jobs.opened(path) as job_list_:
        if not job_list_.sources:
            if not is_quiet:
                say(f"{path}: nothing to fetch: the sources of all jobs are on this computer")
            return 0
        pinned, failed = listed_jobs.fetch(job_list_, (lambda _: None) if is_quiet else print_line)
    if pinned != job_list_:
        job_list.write(path, pinned)
    for line in failed:
        say(f"error: {line}", sys.stderr)
    return 1 if failed else 0


def _tell(path: Path, share: Share | None, *, is_quiet: bool) -> int:
    with listed_jobs.opened(path) as job_list_:
        outcomes = listed_jobs.outcomes(job_list_.share(share))
        if share is None:
            listed_jobs.summarise(job_list_, outcomes)
        status = sweep_status(outcomes)
        if is_quiet and not status:
            return 0
        if outcomes:
            say(table(outcomes, Path(job_list_.folder), width_of(sys.stdout)))
    numbers = Counter(map(_kind, outcomes))
    say(", ".join(f"{numbers[kind]} {kind}" for kind in _KINDS if numbers[kind]) or "no jobs")
    return status


def _kind(outcome: Outcome) -> str:
    if outcome.message == listed_jobs.STALE:
        return listed_jobs.STALE
    return "done" if outcome.state in ("built", "unmet") else outcome.state
