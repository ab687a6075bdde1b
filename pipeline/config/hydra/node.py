"""The node `hydra` of a tree: launchers, the folders of a sweep, and keys that a file must not set."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig, open_dict

from linkwright.pipeline.config.files.trust import CODE, FOLDERS, LAUNCHER, PARAMS, SweepSettings, listed
from linkwright.pipeline.config.hydra.errors import explained
from linkwright.pipeline.config.hydra.loader import SEARCHPATH, composed
from linkwright.pipeline.config.overrides import Override
from linkwright.pipeline.config.partial import Draft
from linkwright.pipeline.config.plain import as_written, at
from linkwright.pipeline.config.presets import Presets
from linkwright.pipeline.errors import Diagnostic
from linkwright.pipeline.terminal import pasted

GROUP = f"hydra/{LAUNCHER}"


class HydraNode:
    """The node `hydra` of every tree that is composed in a session.

    `typed`: the overrides of the command line that concern Hydra itself.
    """

    def __init__(self, presets: Presets) -> None:
        self._presets = presets
        self._command: list[str] = []
        self._ours: dict[str, DictConfig] = {}
        self.typed: list[str] = []

    def take(self, overrides: Sequence[Override], command: Sequence[str]) -> list[Diagnostic]:
        """Stores the overrides of a `command` that concern Hydra, and returns their problems."""
        self._command = list(command)
        self.typed = [override.hydra for override in overrides if override.for_hydra_itself]
        if not self.typed:
            return []
        try:
            self.ours()
        except Exception as error:
            self.typed = []
            launchers = [one.values[0] for one in overrides if one.key == GROUP]
            own = [self._of_ones_own(launcher) for launcher in launchers]
            return [problem for problem in own if problem] or [explained(error, self._presets)]
        return []

    def given(self, keys: Iterable[str]) -> set[str]:
        """Those of these keys of Hydra that the command line sets."""
        return {key for key in keys if any(f"{key}=" in one for one in self.typed)}

    def ours(self, launcher: str = "") -> DictConfig:
        """Hydra's configuration from the command line alone, without a robot's file: a sweep runs under
        it. `launcher`: an option of hydra/launcher; the user's launchers are only those in
        `--config-dir`."""
        if launcher not in self._ours:
            chosen = [f"{GROUP}={launcher}"] if launcher else []
            everything = [*chosen, *self.typed, *searching(self._presets.given)]
            self._ours[launcher], _ = composed(everything)
        return self._ours[launcher]

    def sweeping(
        self, config: DictConfig, draft: Draft, name: Any = None, job: tuple[int, str] | None = None
    ) -> SweepSettings:
        """The sweep settings; a key of Hydra that a file must not set is a problem.

        The folders are for the robot `name` in a `job`: its number and its label.
        """
        launcher = str(config.hydra.runtime.choices.get(GROUP))
        changed = self._set_by_files(config, launcher, draft) if self._presets.own else {}
        named = (key for key in FOLDERS if key in changed or self.given([f"hydra.{key}"]))
        folders: dict[str, str | None] = dict.fromkeys(named)
        if job is not None and folders:
            with open_dict(config):
                config.name = name
                config.hydra.job.num, config.hydra.job.id = job[0], str(job[0])
                config.hydra.job.override_dirname = job[1].replace(" ", ",")
            HydraConfig.instance().set_config(config)
            for key in folders:
                folders[key] = str(at(config, ("hydra", *key.split(".")), draft.problems))
        prefix = f"{LAUNCHER}."
        numbers = {key.removeprefix(prefix): one for key, one in changed.items() if key.startswith(prefix)}
        params = {str(key): str(one) for key, one in (changed.get(PARAMS) or {}).items()}
        return SweepSettings(launcher, numbers, params, *map(folders.get, FOLDERS))

    def _set_by_files(self, config: DictConfig, launcher: str, draft: Draft) -> dict[str, Any]:
        """The settings of Hydra in files, without those that files must not set."""
        try:
            ours = as_written(self.ours(launcher).hydra)
        except Exception as error:
            draft.add(self._of_ones_own(launcher) or explained(error, self._presets))
            return {}
        theirs = as_written(config.hydra)
        ours["searchpath"] = [f"file://{folder}" for folder in self._presets.own]
        changed, problems = listed(theirs, ours, lambda place: at(config, ("hydra", *place), draft.problems))
        known = {problem.where for problem in draft.problems}
        draft.problems += [problem for problem in problems if problem.where not in known]
        return changed

    def _of_ones_own(self, launcher: str) -> Diagnostic | None:
        """The problem of a launcher that exists only in the working folder."""
        files = self._presets.own_files([f"{GROUP}/{launcher}"])
        if not files or files[0].parents[2] in self._presets.given:
            return None
        text = f"your own launchers are used only from --config-dir, and this launcher is {files[0]}"
        command = [*self._command[:1], "--config-dir", str(files[0].parents[2]), *self._command[1:]]
        return Diagnostic(CODE, text, f"{GROUP}={launcher}", f"if you trust it: {pasted.line(command)}")


def searching(folders: Iterable[Path]) -> list[str]:
    """The override that adds these folders to Hydra's search path."""
    named = ",".join(hydra_text(f"file://{folder}") for folder in folders)
    return [f"{SEARCHPATH}[{named}]"] if named else []


def hydra_text(text: str) -> str:
    """`text` as a quoted value of Hydra's grammar."""
    escaped = text.replace("\\", "\\\\").replace("'", r"\'").replace("${", r"\${")
    return f"'{escaped}'"
