"""Reads Hydra's own configuration: launchers, sweep folders, and keys that a file must not set."""

from collections.abc import Iterable, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig, open_dict

from linkwright.pipeline.config.files.trust import (
    FOLDER_KEYS,
    LAUNCHER,
    PARAMS_KEY,
    SEARCH_KEYS,
    TRUST_CODE,
    SweepSettings,
    compare_hydra_nodes,
)
from linkwright.pipeline.config.hydra.errors import LAUNCHERS, SWEEPERS, composition_problem, plug_in_problem
from linkwright.pipeline.config.hydra.loader import SEARCHPATH_PREFIX, composed
from linkwright.pipeline.config.overrides import Override
from linkwright.pipeline.config.partial import Draft
from linkwright.pipeline.config.plain import as_written, value_at
from linkwright.pipeline.config.presets import Presets
from linkwright.pipeline.errors import Diagnostic
from linkwright.pipeline.terminal import pasted

RAY = "ray"
"""The launcher of Ray, an option that Linkwright ships."""


class HydraOptions(NamedTuple):
    """The options of hydra/launcher and hydra/sweeper; "" for the default."""

    launcher: str = ""
    sweeper: str = ""


class JobIdentity(NamedTuple):
    """The number of a job in its sweep, and its label."""

    number: int
    label: str
    """The overrides of the job, separated by spaces."""


class HydraSettings:
    """Hydra's own configuration: the node `hydra` of the trees that a session composes.

    Tells which of its keys the command line sets, and which a file sets and may set.
    """

    def __init__(self, presets: Presets) -> None:
        self._presets = presets
        self._command: list[str] = []
        self._command_configs: dict[HydraOptions, DictConfig] = {}
        """Options → the configuration that the command line alone composes."""
        self._command_nodes: dict[HydraOptions, dict[str, Any]] = {}
        """Options → the node `hydra` of that configuration, with its interpolations."""
        self.typed_overrides: list[str] = []
        """The overrides of Hydra's own keys on the command line."""

    def accept_overrides(self, overrides: Sequence[Override], command: Sequence[str]) -> list[Diagnostic]:
        """Stores the overrides of Hydra's own keys. If they cannot be composed, stores none; returns the
        problems. `command`: the words of the typed command, for hints."""
        self._command = list(command)
        self.typed_overrides = [override.hydra for override in overrides if override.for_hydra_itself]
        if not self.typed_overrides:
            return []
        problems = self._composition_problems(overrides)
        if problems:
            self.typed_overrides = []
        return problems

    def _composition_problems(self, overrides: Sequence[Override]) -> list[Diagnostic]:
        """Composes Hydra's configuration with the stored overrides, and returns the problems."""
        try:
            self.trusted_config()
        # Hydra and OmegaConf raise errors of many types.
        except Exception as error:
            launchers = [override.values[0] for override in overrides if override.key == LAUNCHERS]
            problems = [self._launcher_problem(launcher) for launcher in launchers]
            return [problem for problem in problems if problem] or [composition_problem(error, self._presets)]
        return []

    def typed_keys(self, keys: Iterable[str]) -> set[str]:
        """Returns the keys that the command line sets. `keys`: keys of Hydra, with `hydra.`."""
        # A prefix (`+`, `++`) may come before the key.
        return {key for key in keys if any(f"{key}=" in override for override in self.typed_overrides)}

    def trusted_config(self, launcher: str = "", sweeper: str = "") -> DictConfig:
        """Returns Hydra's configuration as the command line alone composes it, without the robot's file.

        Sweeps run under it. `launcher`, `sweeper`: options of hydra/launcher and hydra/sweeper, "" for the
        default. The user's own options are found only in folders that `--config-dir` names.
        """
        options = HydraOptions(launcher, sweeper)
        if options not in self._command_configs:
            option_by_group = {LAUNCHERS: launcher, SWEEPERS: sweeper}
            group_overrides = [f"{group}={option}" for group, option in option_by_group.items() if option]
            search_path = search_path_override(self._presets.config_folders)
            arguments = [*group_overrides, *self.typed_overrides, *search_path]
            self._command_configs[options], _ = composed(arguments)
        return self._command_configs[options]

    def sweep_settings(
        self, config: DictConfig, draft: Draft, robot_name: Any = None, job: JobIdentity | None = None
    ) -> SweepSettings:
        """Returns the sweep settings; adds a problem to `draft` for each key of Hydra that no file may set.

        `job`: the job whose folders the settings have; without a job they have no folders.
        """
        launcher, sweeper = (str(config.hydra.runtime.choices.get(group)) for group in (LAUNCHERS, SWEEPERS))
        # Linkwright ships the option `ray` itself, so it composes even if the plug-in is missing.
        if launcher == RAY and find_spec("hydra_plugins.hydra_ray_launcher") is None:
            draft.add(plug_in_problem(RAY))
        file_settings = (
            self._file_settings(config, HydraOptions(launcher, sweeper), draft) if self._presets.own else {}
        )
        folder_keys = [
            key for key in FOLDER_KEYS if key in file_settings or self.typed_keys([f"hydra.{key}"])
        ]
        folders: dict[str, str] = {}
        if job is not None and folder_keys:
            _set_job(config, robot_name, job)
            folders = {
                key: str(value_at(config, ("hydra", *key.split(".")), draft.problems)) for key in folder_keys
            }
        return _sweep_settings(launcher, sweeper, file_settings, folders)

    def _file_settings(self, config: DictConfig, options: HydraOptions, draft: Draft) -> dict[str, Any]:
        """Returns the settings of Hydra that files set and may set, by key without `hydra.`; adds a problem
        for each other setting."""
        try:
            if options not in self._command_nodes:
                self._command_nodes[options] = as_written(self.trusted_config(*options).hydra)
        # Hydra and OmegaConf raise errors of many types.
        except Exception as error:
            draft.add(self._launcher_problem(options.launcher) or composition_problem(error, self._presets))
            return {}
        # The search path of the composed tree has the user's folders, which no file has added.
        searchpath = [f"file://{folder}" for folder in self._presets.own]
        trusted_node = {**self._command_nodes[options], "searchpath": searchpath}
        settings, problems = compare_hydra_nodes(
            as_written(config.hydra),
            trusted_node,
            lambda place: value_at(config, ("hydra", *place), draft.problems),
            self._command,
        )
        # A key that could not be resolved has a problem already.
        reported_places = {problem.where for problem in draft.problems}
        draft.problems += [problem for problem in problems if problem.where not in reported_places]
        return settings

    def _launcher_problem(self, launcher: str) -> Diagnostic | None:
        """Returns a problem if a launcher is the user's own, but is not in a folder that `--config-dir`
        names."""
        files = self._presets.own_files([f"{LAUNCHERS}/{launcher}"])
        if not files:
            return None
        config_dir = files[0].parents[2]  # CONFIG_DIR/hydra/launcher/NAME.yaml
        if config_dir in self._presets.config_folders:
            return None
        text = f"your own launchers are used only from --config-dir, but this launcher is in {files[0]}"
        command = [*self._command[:1], "--config-dir", str(config_dir), *self._command[1:]]
        return Diagnostic(
            TRUST_CODE, text, f"{LAUNCHERS}={launcher}", f"if you trust it: {pasted.line(command)}"
        )


def _sweep_settings(
    launcher: str, sweeper: str, file_settings: Mapping[str, Any], folders: Mapping[str, str]
) -> SweepSettings:
    """Returns the sweep settings. `file_settings`: key without `hydra.` → the value that files set;
    `folders`: key without `hydra.` → the resolved folder."""
    prefix = f"{LAUNCHER}."
    launcher_settings = {
        key.removeprefix(prefix): value for key, value in file_settings.items() if key.startswith(prefix)
    }
    return SweepSettings(
        launcher,
        sweeper,
        search_settings={key: value for key, value in file_settings.items() if key in SEARCH_KEYS},
        launcher_settings=launcher_settings,
        params={str(key): str(value) for key, value in (file_settings.get(PARAMS_KEY) or {}).items()},
        dir=folders.get("sweep.dir"),
        subdir=folders.get("sweep.subdir"),
    )


def _set_job(config: DictConfig, robot_name: Any, job: JobIdentity) -> None:
    """Sets the robot's name and the job in `config`, and makes it the configuration that `${hydra:...}`
    reads, so that Hydra's folders can be resolved."""
    with open_dict(config):
        config.name = robot_name
        config.hydra.job.num, config.hydra.job.id = job.number, str(job.number)
        # The label separates the job's overrides by spaces, Hydra by commas.
        config.hydra.job.override_dirname = job.label.replace(" ", ",")
    HydraConfig.instance().set_config(config)


def search_path_override(folders: Iterable[Path]) -> list[str]:
    """Returns the override that adds folders to Hydra's search path, in a list; [] without folders."""
    entries = ",".join(quote_text(f"file://{folder}") for folder in folders)
    return [f"{SEARCHPATH_PREFIX}[{entries}]"] if entries else []


def quote_text(text: str) -> str:
    """Returns a text, quoted as a value in the grammar of Hydra's overrides."""
    escaped = text.replace("\\", "\\\\").replace("'", r"\'").replace("${", r"\${")
    return f"'{escaped}'"
