"""The jobs of a sweep: a plan, a label and a folder for each."""

import contextlib
import hashlib
import os
import re
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkwright.pipeline.config.files.trust import SweepSettings
from linkwright.pipeline.config.overrides import Override
from linkwright.pipeline.config.plan import Judge, Plan, is_run_key
from linkwright.pipeline.errors import as_problems, refusal
from linkwright.pipeline.interrupt import behind, check
from linkwright.pipeline.run.preflight import destination
from linkwright.pipeline.sweep.outcome import Outcome, built, failed
from linkwright.pipeline.terminal.output import clean, width_of
from linkwright.pipeline.terminal.wrapping import wrapped
from linkwright.stages.robot.errors import ConfigError, Diagnostic
from linkwright.stages.robot.text.printable import sentence

if TYPE_CHECKING:
    from linkwright.pipeline.config.compose import Composed, Composer, SweepRequest
    from linkwright.pipeline.report import Report

Build = Callable[[Plan], "Report"]
"""The function that a job calls: `pipeline.run.build.build`, or a replacement in tests."""

LONGEST_SLUG = 60


@dataclass(frozen=True, slots=True)
class Job:
    """One plan of a sweep. `label`: its swept overrides as text; `plan.output`: its own folder;
    `overrides`: key → value."""

    number: int
    label: str
    plan: Plan
    overrides: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Sweep:
    """All jobs of a sweep, its folder, the overrides of each job, and the sweep settings of files."""

    jobs: Sequence[Job]
    root: Path
    overrides: Sequence[Sequence[str]]
    sweeping: SweepSettings


class Task:
    """Runs a job in any process: builds, prints its start and its end, and never raises."""

    def __init__(self, jobs: Sequence[Job], build: Build, *, is_quiet: bool = False) -> None:
        self._jobs = tuple(jobs)
        self._build = build
        self._is_quiet = is_quiet

    def __call__(self, number: int) -> Outcome:
        check()
        job = self._jobs[number]
        self._say(f"job {number} starts: {job.label}")
        start = time.perf_counter()
        outcome = self._outcome(job)
        self._say(f"job {number} ended after {time.perf_counter() - start:.1f} s: {outcome.message}")
        return outcome

    def _say(self, line: str) -> None:
        if not self._is_quiet:
            _print(line)

    def _outcome(self, job: Job) -> Outcome:
        which = (job.number, job.label, job.overrides)
        try:
            return built(*which, self._build(job.plan))
        except BaseException as error:
            if behind(error):
                raise KeyboardInterrupt from error
            # SystemExit too: it would end the whole sweep.
            return failed(*which, str(job.plan.folder), error)


def _print(line: str) -> None:
    # In one write, since other processes write there too; a worker's pipe may be closed.
    with contextlib.suppress(BrokenPipeError):
        err, width = clean(sys.stderr), width_of(sys.stderr)
        text = sentence(line)
        err.write(f"{text if width is None else wrapped(text, width)}\n")
        err.flush()


def jobs_of(composer: "Composer", asked: "SweepRequest", judge: Judge) -> Sweep:
    """Every job of a sweep, composed and validated, and the sweep's folder.

    ConfigError lists the known problems of the command line and those of all jobs, each with the numbers
    of its jobs; `judge` adds problems of a job before it starts.
    """
    swept = [override for override in asked.overrides if override.swept]
    overrides = [one for one in asked.overrides if not (one.for_hydra_itself or is_run_key(one.key))]
    everything = composer.reading.jobs(asked.overrides)
    labels = [_label(swept or overrides, job) for job in everything]
    made: list[Composed] = []
    found: dict[Diagnostic, list[int]] = {}
    for number, (job, label) in enumerate(zip(everything, labels, strict=True)):
        try:
            composed = composer.compose(job, job=(number, label))
        except ConfigError as error:
            problems: Iterable[Diagnostic] = as_problems(error)
        else:
            made.append(composed)
            problems = [
                *judge(composed.plan),
                *_disagreeing(made[0].sweeping, composed.sweeping, asked.sweeping),
            ]
        for problem in problems:
            found.setdefault(problem, []).append(number)
    if found or asked.problems:
        raise _refused(found, labels, asked.problems)
    data = [_data(asked.overrides, job, composer) for job in everything]
    jobs, root = _placed(made, everything, labels, data)
    return Sweep(jobs, root, everything, made[0].sweeping)


def _disagreeing(first: SweepSettings, other: SweepSettings, master: SweepSettings) -> list[Diagnostic]:
    """The problems of jobs, for example of different robots, with different sweep settings."""
    found = []
    if (first.launcher, first.numbers) != (other.launcher, other.numbers):
        text = "its file sets another launcher, or other launcher settings, than the file of job 0"
        hint = "a sweep has one launcher: choose it on the command line, for example hydra/launcher=basic"
        found.append(Diagnostic("E-OVERRIDE", text, "hydra/launcher", hint))
    if other.params != master.params:
        text = "has no effect: the file that sets it is itself swept"
        hint = "remove it from the file, or sweep over one robot at a time"
        found.append(Diagnostic("E-OVERRIDE", text, "hydra.sweeper.params", hint))
    return found


def _placed(
    made: Sequence["Composed"],
    everything: list[list[str]],
    labels: list[str],
    data: list[dict[str, Any]],
) -> tuple[list[Job], Path]:
    plans = [composed.plan for composed in made]
    roots = {plan.output for plan in plans}
    if len(roots) > 1:
        msg = "cannot be swept: every job has a folder of its own in the sweep's folder"
        raise ConfigError(msg, "output", "give one output, for the sweep's folder")
    names = sorted({plan.name for plan in plans})
    name = names[0] if len(names) == 1 else "robots"
    usual = made[0].sweeping.dir or f"outputs/{name}.sweep"
    root = plans[0].folder if roots.pop() else Path(os.path.expanduser(usual))  # noqa: PTH111
    jobs: list[Job] = []
    for number, (composed, overrides, label) in enumerate(zip(made, everything, labels, strict=True)):
        folder = root / (_inside(composed.sweeping.subdir) or f"{_slug(label)}-{_digest(overrides)}")
        twin = next((job for job in jobs if job.plan.folder == folder), None)
        if twin is not None and composed.sweeping.subdir:
            msg = f"jobs {twin.number} and {number} have the same folder: {folder}"
            raise ConfigError(msg, "hydra.sweep.subdir", "put ${hydra.job.num} into it")
        if twin is not None:
            msg = f"jobs {twin.number} and {number} are the same: {label}"
            raise ConfigError(msg, hint="give each value once")
        plan = composed.plan.model_copy(update={"output": str(folder)})
        jobs.append(Job(number, label, plan, data[number]))
    return jobs, root


def _inside(subdir: str | None) -> str:
    """The folder of a job below the sweep's folder; ConfigError for a folder elsewhere."""
    parts = Path(subdir or "").parts
    if subdir and (not parts or ".." in parts or Path(subdir).is_absolute()):
        msg = f"must be a folder below the sweep's (given {subdir})"
        raise ConfigError(msg, "hydra.sweep.subdir", "for example ${hydra.job.num}")
    return subdir or ""


def judge_folders(jobs: Sequence[Job], environ: Mapping[str, str] = os.environ) -> None:
    """ConfigError where a file that is not linkwright's is in the way of any job."""
    found: dict[Diagnostic, list[int]] = {}
    for job in jobs:
        try:
            destination(job.plan, environ)
        except ConfigError as error:
            for problem in as_problems(error):
                found.setdefault(problem, []).append(job.number)
    if found:
        raise _refused(found, [job.label for job in jobs], ())


def _data(overrides: Iterable[Override], job: Sequence[str], composer: "Composer") -> dict[str, Any]:
    """The overrides of a job as data, each key as it was typed."""
    found: dict[str, Any] = {}
    for override in overrides:
        sign = override.hydra.partition("=")[0]
        text = next((one for one in job if one.partition("=")[0] == sign), None)
        if text is None:
            continue
        value = composer.reading.data(text)
        if override.key == "robot" and "/" in str(value):
            value = Path(value).name
        if sign.lstrip("+~") != override.key:
            # `joints.*.damping` was nested into `joints`.
            while isinstance(value, Mapping) and len(value) == 1:
                value = next(iter(value.values()))
        found[override.key if sign[:1] != "~" else f"~{override.key}"] = value
    return found


def _label(named: Sequence[Override], job: Sequence[str]) -> str:
    """The label of a job, from its typed overrides: `mesh.tolerance=0.001 root=free`."""
    words = []
    for override in named:
        sign = override.hydra.partition("=")[0]
        found = next((text for text in job if text.partition("=")[0] == sign), "")
        value = found.partition("=")[2]
        words.append(f"{override.key}={_inner(value, override)}" if found else override.typed)
    return " ".join(words)


def _inner(value: str, override: Override) -> str:
    """The inner value of a nested override, `{*:{damping:1}}` → `1`; for a robot's path its name."""
    if override.key == "robot" and "/" in value:
        return Path(value.strip("'")).name
    if override.hydra.partition("=")[0].lstrip("+") == override.key:
        return value
    return value.rstrip("}").rpartition(":")[2]


def _slug(label: str) -> str:
    return re.sub(r"[^A-Za-z0-9.=_-]+", "_", label)[:LONGEST_SLUG].strip("_.") or "job"


def _digest(overrides: Iterable[str]) -> str:
    """8 hex digits that identify the overrides of a job."""
    keys = {one: one.partition("=")[0].lstrip("+") for one in overrides}
    identity = sorted(
        one for one, key in keys.items() if not (re.match(r"hydra[./]", key) or is_run_key(key))
    )
    return hashlib.sha256("\n".join(identity).encode()).hexdigest()[:8]


def _refused(
    found: dict[Diagnostic, list[int]], labels: Sequence[str], known: Sequence[Diagnostic]
) -> ConfigError:
    problems = [*known]
    for problem, numbers in found.items():
        if problem in known:
            continue
        if len(numbers) == len(labels):
            jobs = "every job"
        elif len(numbers) == 1:
            jobs = f"job {numbers[0]} ({labels[numbers[0]]})"
        else:
            jobs = f"jobs {', '.join(map(str, numbers))}"
        where = f"{jobs}: {problem.where}" if problem.where else jobs
        problems.append(Diagnostic(problem.code, problem.message, where, problem.hint))
    bad = len({number for numbers in found.values() for number in numbers})
    if known:
        return refusal(problems, "the sweep")
    msg = f"{bad} of {len(labels)} jobs cannot be built; nothing was built"
    return ConfigError(msg, problems=problems)
