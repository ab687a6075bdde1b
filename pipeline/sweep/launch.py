"""A sweep under one of Hydra's launchers.

Hydra's configuration comes from the command line alone; no robot's file is read again, since all plans
are known.
"""

import copy
import os
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from hydra._internal.callbacks import Callbacks
from hydra.core.config_loader import ConfigLoader
from hydra.core.hydra_config import HydraConfig
from hydra.core.plugins import Plugins
from hydra.errors import HydraException
from hydra.types import HydraContext
from omegaconf import DictConfig, OmegaConf, open_dict
from omegaconf.errors import OmegaConfBaseException

from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.interrupt import kept_from_workers
from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.sweep.folder import ACCOUNT

ALONE = "basic"
"""Hydra's launcher that runs the jobs one after the other in this process."""


@dataclass(frozen=True, slots=True)
class Account:
    """The record of a sweep for `multirun.yaml`: the tree that all jobs start from, the typed overrides, and
    the overrides of each job."""

    tree: DictConfig | None
    typed: Sequence[str]
    jobs: Sequence[Sequence[str]]

    def text(self, config: DictConfig) -> str:
        """The content of `multirun.yaml`, of a sweep that runs under `config`; secrets are blanked."""
        whole = copy.deepcopy(config)
        with open_dict(whole):
            for key, value in {} if self.tree is None else self.tree.items_ex(resolve=False):
                if key != "hydra":
                    whole[key] = copy.deepcopy(value)
            whole.hydra.overrides.task = [one for one in self.typed if not re.match(r"[+~]*hydra[./]", one)]
        return Secrets(os.environ).blanked(OmegaConf.to_yaml(whole))


def launch(
    ours: DictConfig, numbers: Mapping[str, Any], task: Callable[[int], Any], folder: Path, account: Account
) -> list[Any]:
    """Runs `task(number)` for every job and returns the results. Writes `multirun.yaml`.

    `ours`: the tree with the `hydra` node to run under; `numbers`: settings of its launcher. `task` goes to
    other processes with some launchers, and must not raise. ConfigError where the launcher cannot start.
    """
    config = copy.deepcopy(ours)
    try:
        with open_dict(config):
            for key, value in numbers.items():
                OmegaConf.update(config, f"hydra.launcher.{key}", value)
            # Escaped, so that a folder's name is never an interpolation.
            config.hydra.sweep.dir, config.hydra.sweep.subdir = str(folder).replace("${", r"\${"), "."
        launcher = Plugins.instance().instantiate_launcher(
            config=config,
            hydra_context=HydraContext(config_loader=cast(ConfigLoader, _Known()), callbacks=Callbacks()),
            task_function=_Numbered(task),
        )
    except (HydraException, OmegaConfBaseException) as error:
        raise _cannot_start(error) from error
    (folder / ACCOUNT).write_text(account.text(config), encoding="utf-8")
    wanted = config.hydra.sweeper.max_batch_size or 0
    size = wanted if wanted > 0 else len(account.jobs)
    alone = config.hydra.runtime.choices["hydra/launcher"] == ALONE
    done: list[Any] = []
    with nullcontext() if alone else kept_from_workers():
        for start in range(0, len(account.jobs), size):
            batch = [list(job) for job in account.jobs[start : start + size]]
            try:
                done += launcher.launch(batch, initial_job_idx=start)
            except (ValueError, TypeError, HydraException, OmegaConfBaseException) as error:
                # Jobs never raise, so the launcher rejects its settings.
                raise _cannot_start(error) from error
    return [job.return_value for job in done]


def _cannot_start(error: Exception) -> ConfigError:
    text = f"cannot run the jobs: {(str(error).splitlines() or [type(error).__name__])[0]}"
    return ConfigError(text, "hydra/launcher", "check the settings of hydra.launcher")


class _Known:
    """Replaces Hydra's loader, from which launchers get the configuration of each job."""

    def load_sweep_config(self, master: DictConfig, overrides: list[str]) -> DictConfig:
        config = copy.deepcopy(master)
        with open_dict(config):
            config.hydra.overrides.task = overrides
        return config


class _Numbered:
    """Hydra's task function: calls the task with the number of the job."""

    def __init__(self, task: Callable[[int], Any]) -> None:
        self._task = task

    def __call__(self, _: DictConfig) -> Any:
        return self._task(int(HydraConfig.get().job.num))
