"""Composes the jobs of a sweep, each with a plan, a label and a folder, and runs a single job."""

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

from linkwright.pipeline.config import grammar
from linkwright.pipeline.config.files.trust import SweepSettings
from linkwright.pipeline.config.hydra.node import JobIdentity
from linkwright.pipeline.config.overrides import Override
from linkwright.pipeline.config.plan import Judge, Plan, is_run_key
from linkwright.pipeline.errors import as_problems, refusal
from linkwright.pipeline.interrupt import check, is_cause_of
from linkwright.pipeline.run.preflight import destination
from linkwright.pipeline.sweep.outcome import Outcome, built, failed
from linkwright.pipeline.sweep.outcome_files import begin, leave, withdraw
from linkwright.pipeline.sweep.summary_json import finite
from linkwright.pipeline.terminal.output import clean_stream, terminal_width
from linkwright.pipeline.terminal.wrapping import wrapped
from linkwright.stages.robot.errors import ConfigError, Diagnostic, LinkwrightError
from linkwright.stages.robot.text.printable import sentence

if TYPE_CHECKING:
    from linkwright.pipeline.config.compose import Composer, SweepRequest
    from linkwright.pipeline.report import Report
    from linkwright.pipeline.stages.prefetched import Prefetched

Build = Callable[..., "Report"]
"""The function that a job calls: `pipeline.run.build.build`, or a replacement in tests."""

MAX_SLUG_LENGTH = 60


@dataclass(frozen=True, slots=True)
class Job:
    """A job of a sweep; `label`: its swept overrides as text."""

    number: int
    label: str
    plan: Plan
    overrides: Mapping[str, Any] = field(default_factory=dict)
    pin: str = ""
    """The version or microversion of the document; "" before it is known."""

    fetched: "Prefetched | None" = None
    """The first stage of the build, if the sweep has fetched the source."""


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
        self._jobs = {job.number: job for job in jobs}
        self._build = build
        self._is_quiet = is_quiet

    def __call__(self, number: int) -> Outcome:
        check()
        job = self._jobs[number]
        self._say(f"job {number} starts: {job.label}")
        start = time.perf_counter()
        begin(job.plan.folder)
        outcome = self._outcome(job)
        leave(outcome, job.plan.folder)
        self._say(f"job {number} ended after {time.perf_counter() - start:.1f} s: {outcome.message}")
        return outcome

    def lost(self, number: int, reason: str) -> Outcome:
        """Returns the outcome of a job that ended without a result: its process was killed, or its launcher
        stopped."""
        job = self._jobs[number]
        error = LinkwrightError(f"ended without a result: {reason}")
        return failed(job.number, job.label, job.overrides, str(job.plan.folder), error)

    def _say(self, line: str) -> None:
        if not self._is_quiet:
            print_line(line)

    def _outcome(self, job: Job) -> Outcome:
        identity = (job.number, job.label, job.overrides)
        options = {"stages": job.fetched.stages} if job.fetched else {}
        try:
            return built(*identity, self._build(job.plan, **options))
        except BaseException as error:
            if is_cause_of(error):
                withdraw(job.plan.folder)
                raise KeyboardInterrupt from error
            # SystemExit too: it would end the whole sweep.
            return failed(*identity, str(job.plan.folder), error)


def print_line(line: str) -> None:
    # In a single write, since other processes write there too; a worker's pipe may be closed.
    with contextlib.suppress(BrokenPipeError):
        err, width = clean_stream(sys.stderr), terminal_width(sys.stderr)
        text = sentence(line)
        err.write(f"{text if width is None else wrapped(text, width)}\n")
        err.flush()


def compose_sweep(
    composer: "Composer",
    request: "SweepRequest",
    judge: Judge,
    all_overrides: Sequence[Sequence[str]] | None = None,
    first: int = 0,
) -> Sweep:
    """Composes and validates all jobs of a sweep, and chooses the folder of each.

    `all_overrides`: the overrides of each job; None for all combinations of the values. `first`: the number
    of the first job. `judge`: returns further problems of a job that are known before it starts. Raises
    ConfigError with the problems of the command line and of all jobs, each with the numbers of its jobs.
    """
    all_overrides, labels = expanded(composer, request, all_overrides)
    plans: list[Plan] = []
    settings: list[SweepSettings] = []
    numbers_of: dict[Diagnostic, list[int]] = {}
    for number, (job, label) in enumerate(zip(all_overrides, labels, strict=True)):
        try:
            composed = composer.compose(job, job=JobIdentity(first + number, label))
        except ConfigError as error:
            problems: Iterable[Diagnostic] = as_problems(error)
        else:
            plans.append(composed.plan)
            settings.append(composed.sweeping)
            problems = [
                *judge(composed.plan),
                *_disagreeing(settings[0], composed.sweeping, request.sweeping),
            ]
        for problem in problems:
            numbers_of.setdefault(problem, []).append(number)
    if numbers_of or request.problems:
        raise _refusal(numbers_of, labels, request.problems)
    folders, root = _placed(plans, settings, all_overrides, labels)
    jobs = []
    for number, (plan, folder) in enumerate(zip(plans, folders, strict=True)):
        placed = plan.model_copy(update={"output": str(folder)})
        data = _data(request.overrides, all_overrides[number], composer)
        jobs.append(Job(first + number, labels[number], placed, data))
    return Sweep(jobs, root, all_overrides, settings[0])


def expanded(
    composer: "Composer", request: "SweepRequest", all_overrides: Sequence[Sequence[str]] | None = None
) -> tuple[Sequence[Sequence[str]], list[str]]:
    """Returns the overrides of each job, and its label."""
    swept = [override for override in request.overrides if override.swept]
    overrides = [item for item in request.overrides if not (item.for_hydra_itself or is_run_key(item.key))]
    if all_overrides is None:
        _require_lists(composer, request)
        all_overrides = composer.reading.jobs(request.overrides)
    return all_overrides, [_label(swept or overrides, job) for job in all_overrides]


def _require_lists(composer: "Composer", request: "SweepRequest") -> None:
    """Raises ConfigError for intervals, since only lists of values can be combined."""
    text, hint = "a sweep needs a list of values", "list them, or search: hydra/sweeper=optuna"
    intervals = composer.reading.intervals(request.overrides)
    if intervals:
        problems = [Diagnostic("E-OVERRIDE", text, interval.typed, hint) for interval in intervals]
        raise refusal([*request.problems, *problems], "the sweep")


def _disagreeing(first: SweepSettings, other: SweepSettings, master: SweepSettings) -> list[Diagnostic]:
    """Returns the problems of jobs, for example of different robots, with different sweep settings."""
    problems = []
    if (first.launcher, first.launcher_settings) != (other.launcher, other.launcher_settings):
        text = "its file sets another launcher, or other launcher settings, than the file of job 0"
        hint = "a sweep has one launcher: choose it on the command line, for example hydra/launcher=basic"
        problems.append(Diagnostic("E-OVERRIDE", text, "hydra/launcher", hint))
    if other.params != master.params:
        text = "has no effect: the file that sets it is itself swept"
        hint = "remove it from the file, or sweep over one robot at a time"
        problems.append(Diagnostic("E-OVERRIDE", text, "hydra.sweeper.params", hint))
    return problems


def _placed(
    plans: Sequence[Plan],
    settings: Sequence[SweepSettings],
    all_overrides: Sequence[Sequence[str]],
    labels: Sequence[str],
) -> tuple[list[Path], Path]:
    """Returns the folder of each job, and the folder of the sweep."""
    roots = {plan.output for plan in plans}
    if len(roots) > 1:
        msg = "cannot be swept: every job has a folder of its own in the sweep's folder"
        raise ConfigError(msg, "output", "give one output, for the sweep's folder")
    names = sorted({plan.name for plan in plans})
    name = names[0] if len(names) == 1 else "robots"
    default_root = settings[0].dir or f"outputs/{name}.sweep"
    root = plans[0].folder if roots.pop() else Path(os.path.expanduser(default_root))  # noqa: PTH111
    folders: dict[Path, int] = {}
    for number, (setting, overrides, label) in enumerate(zip(settings, all_overrides, labels, strict=True)):
        folder = root / (_inside(setting.subdir) or usual_folder(label, overrides))
        twin = folders.setdefault(folder, number)
        if twin != number and setting.subdir:
            msg = f"jobs {twin} and {number} have the same folder: {folder}"
            raise ConfigError(msg, "hydra.sweep.subdir", "put ${hydra.job.num} into it")
        if twin != number:
            msg = f"jobs {twin} and {number} are the same: {label}"
            raise ConfigError(msg, hint="give each value once")
    return list(folders), root


def usual_folder(label: str, overrides: Sequence[str]) -> str:
    """Returns the name of a job's folder in the sweep's folder, unless `hydra.sweep.subdir` names it."""
    slug = re.sub(r"[^A-Za-z0-9.=_-]+", "_", label)[:MAX_SLUG_LENGTH].strip("_.") or "job"
    return f"{slug}-{_digest(overrides)}"


def _inside(subdir: str | None) -> str:
    """Returns the folder of a job below the sweep's folder; raises ConfigError for a folder elsewhere."""
    parts = Path(subdir or "").parts
    if subdir and (not parts or ".." in parts or Path(subdir).is_absolute()):
        msg = f"must be a folder below the sweep's (given {subdir})"
        raise ConfigError(msg, "hydra.sweep.subdir", "for example ${hydra.job.num}")
    return subdir or ""


def require_free_folders(jobs: Sequence[Job], environ: Mapping[str, str] = os.environ) -> None:
    """Raises ConfigError if a file that is not linkwright's is in the way of any job."""
    numbers_of: dict[Diagnostic, list[int]] = {}
    for job in jobs:
        try:
            destination(job.plan, environ)
        except ConfigError as error:
            for problem in as_problems(error):
                numbers_of.setdefault(problem, []).append(job.number)
    if numbers_of:
        raise _refusal(numbers_of, [job.label for job in jobs], ())


def _data(overrides: Iterable[Override], job: Sequence[str], composer: "Composer") -> dict[str, Any]:
    """Returns the overrides of a job as data, each key as it was typed."""
    data: dict[str, Any] = {}
    for override in overrides:
        sign, text = override.hydra.partition("=")[0], override.text_in(job)
        if text is None:
            continue
        value = composer.reading.data(text)
        if override.key == "robot" and "/" in str(value):
            value = Path(value).name
        # The key `joints.*.damping` was nested into `joints`.
        for _ in override.names_below:
            value = next(iter(value.values()))
        data[override.key if sign[:1] != "~" else f"~{override.key}"] = finite(value)
    return data


def _label(named: Sequence[Override], job: Sequence[str]) -> str:
    """Returns the label of a job, from its typed overrides: `mesh.tolerance=0.001 root=free`."""
    words = []
    for override in named:
        text = override.text_in(job) or ""
        value = text.partition("=")[2]
        words.append(f"{override.key}={_inner(value, override)}" if text else override.typed)
    return " ".join(words)


def _inner(value: str, override: Override) -> str:
    """Returns the inner value of a nested override, `{*:{damping:1}}` → `1`; for a robot's path its name."""
    if override.key == "robot" and "/" in value:
        return Path(value.strip("'")).name
    for name in override.names_below:
        value = value.removeprefix(f"{{{grammar.name(name)}:").removesuffix("}")
    return value


def _digest(overrides: Iterable[str]) -> str:
    """Returns 8 hex digits that identify the overrides of a job."""
    keys = {override: override.partition("=")[0].lstrip("+") for override in overrides}
    identity = sorted(
        override for override, key in keys.items() if not (re.match(r"hydra[./]", key) or is_run_key(key))
    )
    return hashlib.sha256("\n".join(identity).encode()).hexdigest()[:8]


def _refusal(
    numbers_of: dict[Diagnostic, list[int]], labels: Sequence[str], typed_problems: Sequence[Diagnostic]
) -> ConfigError:
    problems = [*typed_problems]
    for problem, numbers in numbers_of.items():
        if problem in typed_problems:
            continue
        if len(numbers) == len(labels):
            jobs = "every job"
        elif len(numbers) == 1:
            jobs = f"job {numbers[0]} ({labels[numbers[0]]})"
        else:
            jobs = f"jobs {', '.join(map(str, numbers))}"
        location = f"{jobs}: {problem.where}" if problem.where else jobs
        problems.append(Diagnostic(problem.code, problem.message, location, problem.hint))
    bad = len({number for numbers in numbers_of.values() for number in numbers})
    if typed_problems:
        return refusal(problems, "the sweep")
    msg = f"{bad} of {len(labels)} jobs cannot be built; nothing was built"
    return ConfigError(msg, problems=problems)
