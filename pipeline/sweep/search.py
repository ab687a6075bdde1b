"""Runs a sweep whose jobs a searching sweeper of Hydra chooses, by the objectives of earlier jobs.

Each trial is composed where the search was started, its source is fetched there, and the launcher runs it.
"""

import itertools
import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from linkwright.pipeline.config.objective_section import ObjectiveSection
from linkwright.pipeline.config.overrides import Override
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import ConfigError, as_problems, refusal
from linkwright.pipeline.json_documents.document import CommandDocument
from linkwright.pipeline.json_documents.jobs import sweep_document
from linkwright.pipeline.options import Command
from linkwright.pipeline.output.folder import output_errors
from linkwright.pipeline.report import Report
from linkwright.pipeline.run.preflight import job_problems
from linkwright.pipeline.sweep.fetching import fetch_sources
from linkwright.pipeline.sweep.folder import mark, record, write_summaries
from linkwright.pipeline.sweep.job_launcher import launch_jobs
from linkwright.pipeline.sweep.launch import Config, SweepRecord, launcher_config
from linkwright.pipeline.sweep.launchers.searching import directions_of, search
from linkwright.pipeline.sweep.outcome import Outcome, failed
from linkwright.pipeline.sweep.run import Job, compose_sweep, require_free_folders
from linkwright.pipeline.sweep.terminal_table import table
from linkwright.pipeline.terminal.output import say, terminal_width
from linkwright.stages.fetch.source import SweepState
from linkwright.stages.robot.errors import Diagnostic

if TYPE_CHECKING:
    from linkwright.pipeline.config.compose import Composer, SweepRequest

MAX_VALUES, MAX_CORNERS = 64, 64
"""Largest number of values of a key, and of corners of the whole space, that are validated before the first
job."""

Objective = tuple[float, ...]


def run_search(
    command: Command,
    composer: "Composer",
    request: "SweepRequest",
    build: Callable[[Plan], Report] | None,
) -> int | CommandDocument:
    """Runs a search; returns the exit status, which is that of the best job, or with `--json` a document.
    Raises ConfigError for an invalid space, and without an objective."""
    _require_distinct(request)
    first = compose_sweep(composer, request, job_problems, corners(request))
    config = launcher_config(
        composer.hydra_config(request.sweeping.launcher, request.sweeping.sweeper), request.sweeping
    )
    trials = Trials(command, composer, request, config, build, first.jobs[0], first.root)
    require_free_folders(first.jobs[:1])
    mark(first.root, first.jobs[0].plan)
    record(first.root, [], command.overrides)
    with output_errors(first.root):
        try:
            search(config, trials.root, trials.space, trials.evaluate)
        finally:
            if trials.outcomes:
                write_summaries(trials.outcomes, first.root)
    is_quiet = command.detail == "errors"
    best = trials.best()
    status = (best[0].status or 0) if best else 1
    if command.json:
        return sweep_document(status, first.root, trials.outcomes, [job.number for job in best])
    if not is_quiet or not best:
        say(table(trials.outcomes, first.root, terminal_width(sys.stdout)))
    for outcome in best if not is_quiet else ():
        numbers = ", ".join(f"{value:.6g}" for value in trials.numbers(outcome))
        say(f"best: {numbers} of job {outcome.number}: {outcome.label}")
    return status


def _require_distinct(request: "SweepRequest") -> None:
    """Raises ConfigError for keys that are the same key for Hydra, and so for its sweeper."""
    keys: dict[str, Override] = {}
    for override in request.overrides:
        twin = keys.setdefault(override.hydra.partition("=")[0], override) if override.swept else override
        if twin is not override:
            text = (
                f"cannot be searched beside {twin.key}: for Hydra's sweeper both are {twin.key.split('.')[0]}"
            )
            hint = "search vars.NAME, and write ${vars.NAME} where the robot's file sets this key"
            raise refusal(
                [*request.problems, Diagnostic("E-OVERRIDE", text, override.key, hint)], "the search"
            )


def corners(request: "SweepRequest") -> list[list[str]]:
    """Returns the overrides of the jobs that are validated before a search: each value of a key with the
    first value of all other keys, and the corners of the space."""
    fixed = [
        override.hydra for override in request.overrides if not (override.swept or override.for_hydra_itself)
    ]
    swept = [
        (override.hydra.partition("=")[0], _sample(override.values))
        for override in request.overrides
        if override.swept
    ]
    firsts = [values[0] for _, values in swept]
    chosen = [
        [*firsts[:index], value, *firsts[index + 1 :]]
        for index, (_, values) in enumerate(swept)
        for value in values
    ]
    ends = itertools.product(*((values[0], values[-1]) for _, values in swept))
    chosen += map(list, itertools.islice(ends, MAX_CORNERS))
    unique = list(dict.fromkeys(map(tuple, chosen)))
    keys = [key for key, _ in swept]
    return [
        [*fixed, *(f"{key}={value}" for key, value in zip(keys, values, strict=True))] for values in unique
    ]


def _sample(values: Sequence[str]) -> list[str]:
    """Returns at most MAX_VALUES values: the first and the last, and some at even distances between."""
    if len(values) <= MAX_VALUES:
        return list(values)
    step = (len(values) - 1) / (MAX_VALUES - 1)
    return [values[round(index * step)] for index in range(MAX_VALUES)]


def _objective(plan: Plan, directions: Sequence[str]) -> ObjectiveSection:
    section = plan.objective
    if section is None:
        msg = "a search needs a number from each job, to compare the jobs"
        raise ConfigError(msg, "objective", "for example objective.figure=mass")
    if section.names and len(section.names) != len(directions):
        figures = f"{len(section.names)} figures need the same number of directions"
        msg = f"{figures}, but there are {len(directions)}"
        words = ",".join(["minimize"] * len(section.names))
        raise ConfigError(msg, "objective", f"hydra.sweeper.direction=[{words}]")
    return section


class Trials:
    """Runs the trials of a search, and keeps the outcomes of all jobs so far in `outcomes`, by number.

    A trial that was tried before is not run again. The objective of an invalid trial, or of a job that fails,
    is the key `objective.failed`.
    """

    def __init__(
        self,
        command: Command,
        composer: "Composer",
        request: "SweepRequest",
        config: Config,
        build: Callable[[Plan], Report] | None,
        first: Job,
        root: Path,
    ) -> None:
        self._command, self._composer, self._request, self._config = command, composer, request, config
        self._build, self.root = build, root
        self._directions = directions_of(config)
        self._objective = _objective(first.plan, self._directions)
        self.outcomes: list[Outcome] = []
        self._numbers: dict[tuple[str, ...], int] = {}
        self._fixed = [
            override.hydra
            for override in request.overrides
            if not (override.swept or override.for_hydra_itself)
        ]
        swept = [override.hydra for override in request.overrides if override.swept]
        self.space = [text.lstrip("+") for text in swept]
        """The overrides that are searched, as the sweeper and its results show them."""
        self._signs = {text.lstrip("+").partition("=")[0]: text for text in swept}
        self._state = SweepState(time.time())

    def evaluate(self, overrides: Sequence[Sequence[str]]) -> list[Objective]:
        """Runs trials; returns their objectives in the same order."""
        identities = [tuple(sorted(trial)) for trial in overrides]
        new = {name: list(trial) for name, trial in zip(identities, overrides) if name not in self._numbers}
        first = len(self.outcomes)
        jobs: list[Job] = []
        refused: list[tuple[tuple[str, ...], ConfigError]] = []
        for name, trial in new.items():
            number = first + len(jobs)
            try:
                jobs.append(self._job(trial, number))
                self._numbers[name] = number
            except ConfigError as error:
                refused.append((name, error))
        self.outcomes += self._run(jobs, first)
        for name, refusal_of in refused:
            self._numbers[name] = len(self.outcomes)
            self.outcomes.append(self._refusal_outcome(len(self.outcomes), new[name], refusal_of))
        write_summaries(self.outcomes, self.root)
        return [self.numbers(self.outcomes[self._numbers[name]]) for name in identities]

    def numbers(self, outcome: Outcome) -> Objective:
        """Returns the objective of a job, with a number for each direction."""
        objective: Sequence[float] = ()
        if outcome.status in (0, 3):
            head = f"{str(self._objective.target).rpartition('.')[2]}."
            names = self._objective.names or [name for name in outcome.figures if name.startswith(head)]
            single = [] if outcome.objective is None else [outcome.objective]
            objective = single or [outcome.figures[name] for name in names]
        if not objective:
            worst = [math.inf if direction == "minimize" else -math.inf for direction in self._directions]
            failed_value = self._objective.failed
            objective = (
                worst
                if not failed_value
                else failed_value * len(worst)
                if len(failed_value) == 1
                else failed_value
            )
        return tuple(objective)

    def best(self) -> list[Outcome]:
        """Returns the jobs that no other job beats in every direction; for a single direction only the first
        of them. Jobs with a failed check count only if there are no others."""
        built = [outcome for outcome in self.outcomes if outcome.status == 0] or [
            outcome for outcome in self.outcomes if outcome.status == 3
        ]
        signs = [1.0 if direction == "minimize" else -1.0 for direction in self._directions]
        costs = [[sign * number for sign, number in zip(signs, self.numbers(job))] for job in built]
        if len(signs) == 1:
            return [built[costs.index(min(costs))]] if built else []
        return [
            job
            for job, cost in zip(built, costs)
            if not any(all(a <= b for a, b in zip(other, cost)) and other != cost for other in costs)
        ]

    def _job(self, trial: Sequence[str], number: int) -> Job:
        """Returns the job of a trial; raises ConfigError if it is invalid."""
        pairs = (override.partition("=") for override in trial)
        overrides = [f"{self._signs[key].partition('=')[0]}={value}" for key, _, value in pairs]
        overrides = [*self._fixed, *overrides]
        sweep = compose_sweep(self._composer, self._request, job_problems, [overrides], number)
        (job,) = sweep.jobs
        folder = self.root / job.plan.folder.relative_to(sweep.root)
        return replace(job, plan=job.plan.model_copy(update={"output": str(folder)}))

    def _run(self, jobs: list[Job], first: int) -> list[Outcome]:
        if not jobs:
            return []
        is_quiet = self._command.detail == "errors"
        fetched = jobs if self._build else fetch_sources(jobs, is_quiet=is_quiet, state=self._state)
        record = SweepRecord(self._request.tree, self._command.overrides, [[job.label] for job in jobs])
        return launch_jobs(
            fetched, self._build, self._config, self.root, record, is_quiet=is_quiet, first=first
        )

    def _refusal_outcome(self, number: int, trial: Sequence[str], error: ConfigError) -> Outcome:
        """Returns the outcome of an invalid trial."""
        label = " ".join(trial)
        values = dict(override.split("=", 1) for override in trial)
        problems = [
            replace(problem, where=problem.where.removeprefix("every job").removeprefix(": "))
            for problem in as_problems(error)
        ]
        error_of_trial = refusal(problems, "the trial")
        return failed(number, label, values, str(self.root / f"{number}"), error_of_trial)
