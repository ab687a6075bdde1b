"""Runs a sweep under one of Hydra's launchers.

Hydra's configuration comes from the command line only; no robot's file is read again, since all plans are
known.
"""

import copy
import os
import re
import sys
from collections.abc import Sequence
from concurrent.futures import BrokenExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from shutil import which
from typing import Any, Protocol, cast

from hydra._internal.callbacks import Callbacks
from hydra.core.config_loader import ConfigLoader
from hydra.core.hydra_config import HydraConfig
from hydra.core.plugins import Plugins
from hydra.errors import HydraException
from hydra.types import HydraContext
from omegaconf import DictConfig, OmegaConf, open_dict
from omegaconf.errors import OmegaConfBaseException

from linkwright.pipeline.config.files.trust import SweepSettings
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.interrupt import kept_from_workers
from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.sweep.folder import ACCOUNT, PAGE
from linkwright.pipeline.sweep.launchers.processors import share
from linkwright.stages.robot.system import garbage, process_usage
from linkwright.stages.robot.text.plural import count

Config = DictConfig
"""Hydra's configuration, under which a sweep runs."""

GROUP = "hydra/launcher"

SERIAL = "basic"
"""Hydra's launcher that runs the jobs one after the other in this process."""

SUBMITIT = "linkwright.pipeline.sweep.launchers.submitit_jobs"
"""The module for jobs of submitit; imported if submitit is installed."""

CARRIED_PREFIX = "LINKWRIGHT_"
"""Prefix of environment variables that go along with a job; they hold no key."""

MINIMA = {"timeout_min": 1, "mem_gb": 1, "cpus_per_task": 1, "array_parallelism": 1, "max_num_timeout": 0}
"""Smallest allowed values of launchers' settings, which submitit does not check."""


class LaunchedTask(Protocol):
    """The task that launchers run, in any process."""

    def __call__(self, number: int) -> Any:
        """Runs a job and returns its result; raises only KeyboardInterrupt."""

    def lost(self, number: int, reason: str) -> Any:
        """Returns the result of a job that ended without a result."""


@dataclass(frozen=True, slots=True)
class SweepRecord:
    """The record of a sweep for `multirun.yaml`."""

    tree: DictConfig | None
    """The tree that all jobs start from."""

    typed: Sequence[str]
    """The overrides of the command line."""

    jobs: Sequence[Sequence[str]]
    """The overrides of each job."""

    def text(self, config: DictConfig) -> str:
        """Returns the content of `multirun.yaml` for a sweep under `config`; secrets are blanked."""
        content = copy.deepcopy(config)
        with open_dict(content):
            for key, value in {} if self.tree is None else self.tree.items_ex(resolve=False):
                if key != "hydra":
                    content[key] = copy.deepcopy(value)
            task = [override for override in self.typed if not re.match(r"[+~]*hydra[./]", override)]
            content.hydra.overrides.task = task
        return Secrets(os.environ).blanked(OmegaConf.to_yaml(content))


def launcher_config(tree: DictConfig, settings: SweepSettings) -> DictConfig:
    """Returns Hydra's configuration for the sweep: the `tree` with the `hydra` node, and the `settings` of
    its launcher and its sweeper that files make. Raises ConfigError if the settings are wrong, as far as that
    is known before a job starts."""
    config = copy.deepcopy(tree)
    try:
        with open_dict(config):
            for key, value in settings.launcher_settings.items():
                OmegaConf.update(config, f"hydra.launcher.{key}", value)
            for key, value in settings.search_settings.items():
                OmegaConf.update(config, f"hydra.{key}", value)
    except OmegaConfBaseException as error:
        raise _cannot_start(error) from error
    launcher = config.hydra.launcher
    for key, minimum in MINIMA.items():
        value = launcher.get(key)
        if isinstance(value, int | float) and value < minimum:
            raise ConfigError(f"must be at least {minimum} (given {value})", f"hydra.launcher.{key}")
    if launcher.get("n_jobs") == 0:
        raise ConfigError("must not be 0", "hydra.launcher.n_jobs", "-1 has a job for each processor")
    if str(launcher.get("_target_")).endswith(".SlurmLauncher") and not (which("sbatch") and which("srun")):
        hint = "start the sweep on a host of the cluster, or with hydra/launcher=slurm_local"
        raise ConfigError("Slurm is not on this computer: it has no sbatch or no srun", GROUP, hint)
    return config


def launch(
    config: DictConfig, task: LaunchedTask, folder: Path, record: SweepRecord, first: int = 0
) -> list[Any]:
    """Runs `task(number)` for every job and returns the results; writes `multirun.yaml`.

    `config`: the result of `launcher_config`; `first`: the number of the first job. Some launchers pickle
    `task` and call it in other processes. The result of a killed job comes from `task.lost`; if the launcher
    stops with the job, so do the results of all unfinished jobs. Raises ConfigError if the launcher cannot
    start.
    """
    sweeper = OmegaConf.to_container(config.hydra.sweeper, resolve=False)
    batch_size = cast(dict[str, Any], sweeper).get("max_batch_size") or 0
    size = batch_size if batch_size > 0 else len(record.jobs)
    try:
        with open_dict(config):
            # Escaped, so that a folder's name is never an interpolation.
            config.hydra.sweep.dir, config.hydra.sweep.subdir = str(folder).replace("${", r"\${"), "."
        processors = share(config.hydra.launcher, min(size, len(record.jobs)), process_usage.processors())
        launcher = Plugins.instance().instantiate_launcher(
            config=config,
            hydra_context=context(),
            task_function=_JobFunction(task, processors),
        )
    except (HydraException, OmegaConfBaseException, ImportError, RuntimeError) as error:
        raise _cannot_start(error) from error
    (folder / ACCOUNT).write_text(record.text(config), encoding="utf-8")
    results: list[Any] = []
    with _launcher_context(config, task):
        for start in range(0, len(record.jobs), size):
            batch = [list(job) for job in record.jobs[start : start + size]]
            try:
                results += [job.return_value for job in launcher.launch(batch, initial_job_idx=first + start)]
            except Exception as error:
                if not _is_loss(error):
                    # Jobs never raise, so the launcher rejects its settings.
                    raise _cannot_start(error) from error
                numbers = range(first + start, first + start + len(batch))
                results += [task.lost(number, _first_line(error)) for number in numbers]
    return results


def _launcher_context(config: DictConfig, task: LaunchedTask) -> ExitStack:
    """Returns the context in which the launcher must run its jobs."""
    stack = ExitStack()
    if config.hydra.runtime.choices[GROUP] != SERIAL:
        stack.enter_context(kept_from_workers())
    if _is_submitit(config):
        stack.enter_context(import_module(SUBMITIT).judge_jobs(task.lost))
    return stack


def _is_submitit(config: DictConfig) -> bool:
    return ".hydra_submitit_launcher." in str(config.hydra.launcher.get("_target_"))


def announcement(config: DictConfig, jobs: int, folder: Path) -> str:
    """Returns the message before a launch whose jobs do not write to this terminal; else "". `jobs`: the
    number of jobs."""
    if not _is_submitit(config):
        return ""
    return f"{count(jobs, 'job')} for {config.hydra.runtime.choices[GROUP]}: {folder / PAGE} shows them"


def _is_loss(error: Exception) -> bool:
    """Tells whether a launcher stopped because a process of its jobs was killed."""
    ray = sys.modules.get("ray.exceptions")
    return isinstance(error, (BrokenExecutor, *((ray.RayError,) if ray else ())))


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]


def _cannot_start(error: Exception) -> ConfigError:
    text = f"cannot run the jobs: {_first_line(error)}"
    return ConfigError(text, GROUP, "check the settings of hydra.launcher")


def context() -> HydraContext:
    """Returns the context that Hydra's plug-ins are created with."""
    return HydraContext(config_loader=cast(ConfigLoader, _MasterLoader()), callbacks=Callbacks())


class _MasterLoader:
    """Replaces Hydra's loader, from which launchers get the configuration of each job."""

    def load_sweep_config(self, master: DictConfig, overrides: list[str]) -> DictConfig:
        config = copy.deepcopy(master)
        with open_dict(config):
            config.hydra.overrides.task = overrides
        return config


class _JobFunction:
    """Hydra's task function: calls the task with the number of the job.

    A job runs in the folder where the sweep was started, with its LINKWRIGHT_ variables, and `processors`
    processors.
    """

    def __init__(self, task: LaunchedTask, processors: int | None) -> None:
        self._task, self._processors = task, processors
        self._place, self._starter = os.getcwd(), os.getpid()  # noqa: PTH109
        self._variables = {
            name: value for name, value in os.environ.items() if name.startswith(CARRIED_PREFIX)
        }

    def __call__(self, _: DictConfig) -> Any:
        os.chdir(self._place)
        os.environ.update(self._variables)
        if "submitit" in sys.modules and "SUBMITIT_EXECUTOR" in os.environ:
            import_module(SUBMITIT).within_a_job()
        is_worker = os.getpid() != self._starter
        if is_worker:
            garbage.collect_rarely()
        with process_usage.limited_processors(self._processors):
            result = self._task(int(HydraConfig.get().job.num))
        if is_worker:
            # joblib collects garbage each second, and would traverse all modules each time.
            garbage.freeze_present_objects()
        return result
