"""Runs a searching sweeper of Hydra, with a launcher whose jobs return their objectives."""

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hydra.core.plugins import Plugins
from hydra.core.utils import JobReturn, JobStatus
from hydra.errors import HydraException
from hydra.plugins.launcher import Launcher
from omegaconf import DictConfig, open_dict
from omegaconf.errors import OmegaConfBaseException

from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.sweep.launch import context

Evaluate = Callable[[Sequence[Sequence[str]]], Sequence[Sequence[float]]]
"""Maps the overrides of trials to the objective of each, a number for each direction."""

REJECTIONS = (HydraException, OmegaConfBaseException, ImportError, ValueError, TypeError, AssertionError)
"""Exceptions of sweepers for settings and spaces that they reject."""


def directions_of(config: DictConfig) -> list[str]:
    """Returns the direction of each number of the objective: "minimize" or "maximize"."""
    direction = config.hydra.sweeper.get("direction", "minimize")
    directions = (
        [direction] if isinstance(direction, str) or not hasattr(direction, "__iter__") else list(direction)
    )
    return [str(getattr(entry, "name", entry)) for entry in directions]


def search(config: DictConfig, folder: Path, space: list[str], evaluate: Evaluate) -> None:
    """Lets the sweeper of `config` search `space`, overrides with the values of each key; its own files go to
    `folder`. Raises ConfigError if it rejects its settings or the space."""
    with open_dict(config):
        # Escaped, so that a folder's name is never an interpolation.
        config.hydra.sweep.dir = str(folder).replace("${", r"\${")
    try:
        with _replace_launcher(_Trials(evaluate)):
            sweeper = Plugins.instance().instantiate_sweeper(
                hydra_context=context(), task_function=lambda _: None, config=config
            )
        # The table of the jobs tells the same.
        logging.getLogger("optuna").setLevel(logging.ERROR)
        sweeper.sweep(space)
    except REJECTIONS as error:
        lines = str(error).splitlines() or [type(error).__name__]
        msg = f"cannot search: {lines[0]}"
        raise ConfigError(msg, "hydra/sweeper", "check the settings of hydra.sweeper") from error


@contextmanager
def _replace_launcher(launcher: Launcher) -> Iterator[None]:
    """Makes Hydra give `launcher` to a sweeper that asks for its launcher."""
    plugins = Plugins.instance()
    vars(plugins)["instantiate_launcher"] = lambda **_: launcher
    try:
        yield
    finally:
        del vars(plugins)["instantiate_launcher"]


class _Trials(Launcher):
    """The launcher that a sweeper sees: the result of each trial is its objective, a number for a single
    direction and a list for several."""

    def __init__(self, evaluate: Evaluate) -> None:
        self._evaluate = evaluate

    def setup(self, **_: Any) -> None:
        """Does nothing: the launcher is complete."""

    def launch(self, job_overrides: Sequence[Sequence[str]], initial_job_idx: int) -> list[JobReturn]:
        return [_job_return(list(numbers)) for numbers in self._evaluate(job_overrides)]


def _job_return(numbers: list[float]) -> JobReturn:
    result = JobReturn()
    result.return_value = numbers[0] if len(numbers) == 1 else numbers
    result.status = JobStatus.COMPLETED
    return result
