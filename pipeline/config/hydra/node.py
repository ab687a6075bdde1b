"""Reads Hydra's own configuration: launchers, sweep folders, and keys that a file must not set."""

from collections.abc import Iterable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig, open_dict

from linkwright.pipeline.config.files.trust import (
    CODE,
    FOLDERS,
    LAUNCHER,
    PARAMS,
    SEARCH,
    SweepSettings,
    compare_hydra_nodes,
)
from linkwright.pipeline.config.hydra.errors import LAUNCHERS, SWEEPERS, explained, needs_plug_in
from linkwright.pipeline.config.hydra.loader import SEARCHPATH, composed
from linkwright.pipeline.config.overrides import Override
from linkwright.pipeline.config.partial import Draft
from linkwright.pipeline.config.plain import as_written, at
from linkwright.pipeline.config.presets import Presets
from linkwright.pipeline.errors import Diagnostic
from linkwright.pipeline.terminal import pasted

RAY = "ray"
"""The launcher of Ray, an option that Linkwright ships."""


class HydraNode:
    """Hydra's own configuration (the node `hydra`) in the trees that a session composes."""

    def __init__(self, presets: Presets) -> None:
        self._presets = presets
        self._command: list[str] = []
        self._trusted_configs: dict[tuple[str, str], DictConfig] = {}
        """(launcher, sweeper) → the configuration that the command line alone composes."""
        self._trusted_nodes: dict[tuple[str, str], dict[str, Any]] = {}
        """(launcher, sweeper) → the node `hydra` of that configuration, with its interpolations."""
        self.typed_overrides: list[str] = []
        """The overrides of Hydra's own keys on the command line."""

    def set_overrides(self, overrides: Sequence[Override], command: Sequence[str]) -> list[Diagnostic]:
        """Stores the overrides of Hydra's own keys, unless they have problems, which it returns. `command`:
        the typed command, for hints."""
        self._command = list(command)
        self.typed_overrides = [override.hydra for override in overrides if override.for_hydra_itself]
        if not self.typed_overrides:
            return []
        try:
            # Composing shows whether the overrides are valid.
            self.trusted_config()
        # Hydra and OmegaConf raise errors of many types.
        except Exception as error:
            self.typed_overrides = []
            launchers = [override.values[0] for override in overrides if override.key == LAUNCHERS]
            problems = [self._launcher_problem(launcher) for launcher in launchers]
            return [problem for problem in problems if problem] or [explained(error, self._presets)]
        return []

    def typed_keys(self, keys: Iterable[str]) -> set[str]:
        """Returns the keys of Hydra, among these, that the command line sets."""
        # A prefix (`+`, `++`) may come before the key.
        return {key for key in keys if any(f"{key}=" in override for override in self.typed_overrides)}

    def trusted_config(self, launcher: str = "", sweeper: str = "") -> DictConfig:
        """Returns Hydra's configuration as the command line alone composes it, without the robot's file.
        Sweeps run under it. `launcher`, `sweeper`: options of hydra/launcher and hydra/sweeper; the user's
        own options are found only in folders given by `--config-dir`."""
        if (launcher, sweeper) not in self._trusted_configs:
            chosen = {LAUNCHERS: launcher, SWEEPERS: sweeper}
            options = [f"{group}={option}" for group, option in chosen.items() if option]
            arguments = [*options, *self.typed_overrides, *search_path_override(self._presets.given)]
            self._trusted_configs[launcher, sweeper], _ = composed(arguments)
        return self._trusted_configs[launcher, sweeper]

    def sweep_settings(
        self, config: DictConfig, draft: Draft, name: Any = None, job: tuple[int, str] | None = None
    ) -> SweepSettings:
        """Returns the sweep settings, and adds a problem for each key of Hydra that a file must not set.

        The folders are resolved for the robot `name` and a `job`, given by its number and label.
        """
        launcher, sweeper = (str(config.hydra.runtime.choices.get(group)) for group in (LAUNCHERS, SWEEPERS))
        # Linkwright ships the option `ray` itself, so it composes even if the plug-in is missing.
        if launcher == RAY and find_spec("hydra_plugins.hydra_ray_launcher") is None:
            draft.add(needs_plug_in(RAY))
        changed = self._set_by_files(config, (launcher, sweeper), draft) if self._presets.own else {}
        set_folders = [key for key in FOLDERS if key in changed or self.typed_keys([f"hydra.{key}"])]
        folders = _resolved_folders(config, set_folders, name, job, draft) if job is not None else {}
        prefix = f"{LAUNCHER}."
        return SweepSettings(
            launcher,
            sweeper,
            search={key: value for key, value in changed.items() if key in SEARCH},
            launcher_settings={
                key.removeprefix(prefix): value for key, value in changed.items() if key.startswith(prefix)
            },
            params={str(key): str(value) for key, value in (changed.get(PARAMS) or {}).items()},
            dir=folders.get("sweep.dir"),
            subdir=folders.get("sweep.subdir"),
        )

    def _set_by_files(self, config: DictConfig, options: tuple[str, str], draft: Draft) -> dict[str, Any]:
        """Returns the settings of Hydra that files set and may set, and adds a problem for each setting that
        they must not set. `options`: the launcher and the sweeper."""
        try:
            if options not in self._trusted_nodes:
                self._trusted_nodes[options] = as_written(self.trusted_config(*options).hydra)
        # Hydra and OmegaConf raise errors of many types.
        except Exception as error:
            draft.add(self._launcher_problem(options[0]) or explained(error, self._presets))
            return {}
        composed_node = as_written(config.hydra)
        searchpath = [f"file://{folder}" for folder in self._presets.own]
        trusted_config = {**self._trusted_nodes[options], "searchpath": searchpath}
        changed, problems = compare_hydra_nodes(
            composed_node,
            trusted_config,
            lambda place: at(config, ("hydra", *place), draft.problems),
            self._command,
        )
        # A key that could not be resolved has a problem already.
        places = {problem.where for problem in draft.problems}
        draft.problems += [problem for problem in problems if problem.where not in places]
        return changed

    def _launcher_problem(self, launcher: str) -> Diagnostic | None:
        """Returns a problem if a launcher is the user's own, but is not in a `--config-dir`."""
        files = self._presets.own_files([f"{LAUNCHERS}/{launcher}"])
        if not files:
            return None
        config_dir = files[0].parents[2]  # CONFIG_DIR/hydra/launcher/NAME.yaml
        if config_dir in self._presets.given:
            return None
        text = f"your own launchers are used only from --config-dir, but this launcher is in {files[0]}"
        command = [*self._command[:1], "--config-dir", str(config_dir), *self._command[1:]]
        return Diagnostic(CODE, text, f"{LAUNCHERS}={launcher}", f"if you trust it: {pasted.line(command)}")


def _resolved_folders(
    config: DictConfig, keys: Sequence[str], name: Any, job: tuple[int, str], draft: Draft
) -> dict[str, str]:
    """Returns the values of these keys below `hydra` for the robot `name` and a `job`, given by its number
    and label. Changes `config`."""
    number, label = job
    if not keys:
        return {}
    with open_dict(config):
        config.name = name
        config.hydra.job.num, config.hydra.job.id = number, str(number)
        config.hydra.job.override_dirname = label.replace(" ", ",")
    HydraConfig.instance().set_config(config)
    return {key: str(at(config, ("hydra", *key.split(".")), draft.problems)) for key in keys}


def search_path_override(folders: Iterable[Path]) -> list[str]:
    """Returns the override that adds these folders to Hydra's search path."""
    entries = ",".join(hydra_text(f"file://{folder}") for folder in folders)
    return [f"{SEARCHPATH}[{entries}]"] if entries else []


def hydra_text(text: str) -> str:
    """Quotes a text as a value in Hydra's override grammar."""
    escaped = text.replace("\\", "\\\\").replace("'", r"\'").replace("${", r"\${")
    return f"'{escaped}'"
