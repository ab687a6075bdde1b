"""Defines the documents of a sweep and of a list of jobs."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any, ClassVar

from linkwright.pipeline.json_documents.document import AnyValue, CommandDocument

STALE = "stale"
"""The message of a job whose folder contains the build of another configuration or document state."""


@dataclass(frozen=True)
class JobDocument:
    """A job of a sweep.

    number: its number; the first is 0.
    label: its swept values as text.
    state: `built`; `unmet`: a check failed, or the state is not the newest; `failed`; `running`; `missing`;
        `stale`: its folder has the build of another configuration or state.
    exit_status: the exit status of its build; null if it has not ended.
    message: how it ended, in words.
    folder: its output folder, which has its report.json; `.failed` is added for a failed build.
    overrides: its values by key.
    figures: the figures of its build.
    objective: the value that a search improves, or null.
    checks: the number of checks that `passed`, and the names of those that `warned` and `failed`.
    calls: API calls `made` and `saved`.
    problems: the first problems of the error that ended it.
    """

    number: int
    label: str
    state: str
    exit_status: int | None
    message: str
    folder: str
    overrides: AnyValue
    figures: AnyValue
    objective: float | None
    checks: AnyValue
    calls: Mapping[str, int]
    problems: tuple[str, ...]


@dataclass(frozen=True)
class SweepDocument(CommandDocument):
    """A sweep (`linkwright -m --json ...`).

    exit_status: 0: all jobs are built and valid; 1: a job failed; 3: a check of a job failed. For a search
        that of its best job.
    folder: the folder of the sweep, with summary.json, summary.csv and summary.html.
    counts: the number of jobs in each state.
    jobs: the jobs.
    best: the numbers of the best jobs of a search; empty for a sweep over lists of values.
    """

    FORMAT: ClassVar[str] = "linkwright-sweep"

    exit_status: int
    folder: str
    counts: Mapping[str, int]
    jobs: tuple[JobDocument, ...]
    best: tuple[int, ...]


@dataclass(frozen=True)
class JobsDocument(CommandDocument):
    """A list of jobs (`linkwright jobs`, `linkwright job`, and a sweep with `--plan`).

    exit_status: 0: all chosen jobs are built and valid, or with `--fetch` or `--plan` nothing failed; 3: a
        check of a job failed; 1: a job or a fetch failed, or a job is not done.
    file: the list.
    folder: the folder of the sweep, relative to the list's working folder.
    counts: the number of chosen jobs in each state.
    jobs: the chosen jobs; with `--fetch` and `--plan` none.
    size: the number of jobs in the list.
    failures: with `--fetch` and `--plan`: why sources cannot be fetched.
    """

    FORMAT: ClassVar[str] = "linkwright-jobs"

    exit_status: int
    file: str
    folder: str
    counts: Mapping[str, int]
    jobs: tuple[JobDocument, ...]
    size: int
    failures: tuple[str, ...]


def job_documents(outcomes: Iterable[Any]) -> tuple[JobDocument, ...]:
    """Returns the documents of outcomes (see `pipeline.sweep.outcome.Outcome`)."""
    return tuple(
        JobDocument(
            number=outcome.number,
            label=outcome.label,
            state="stale" if outcome.message == STALE else outcome.state,
            exit_status=outcome.status,
            message=outcome.message,
            folder=outcome.folder,
            overrides=outcome.overrides,
            figures=outcome.figures,
            objective=outcome.objective,
            checks=outcome.checks,
            calls=outcome.calls,
            problems=outcome.problems,
        )
        for outcome in outcomes
    )


def sweep_document(
    status: int, folder: PurePath, outcomes: Iterable[Any], best: Sequence[int] = ()
) -> SweepDocument:
    """Returns the document of a sweep in `folder`; `best`: the numbers of the best jobs of a search."""
    jobs = job_documents(outcomes)
    return SweepDocument(status, str(folder), _counts(jobs), jobs, tuple(best))


def jobs_document(
    file: PurePath,
    folder: str,
    size: int,
    outcomes: Iterable[Any] = (),
    status: int = 0,
    failures: Sequence[str] = (),
) -> JobsDocument:
    """Returns the document of a list with `size` jobs; `outcomes`: those of the chosen jobs."""
    jobs, status = job_documents(outcomes), status or int(bool(failures))
    return JobsDocument(status, str(file), folder, _counts(jobs), jobs, size, tuple(failures))


def _counts(jobs: Iterable[JobDocument]) -> dict[str, int]:
    """Returns the number of jobs in each state that occurs."""
    return dict(Counter(job.state for job in jobs))
