"""Translates errors of Hydra and OmegaConf to diagnostics about the user's files."""

from collections.abc import Callable
from typing import Any

import yaml
from hydra.errors import HydraException, MissingConfigException
from omegaconf import DictConfig
from omegaconf.errors import OmegaConfBaseException

from linkwright.pipeline.config.files import yaml_file
from linkwright.pipeline.config.files.reach import OutsideError, outside
from linkwright.pipeline.config.files.trust import forbidden_key
from linkwright.pipeline.config.files.yaml_file import RefusedError
from linkwright.pipeline.config.hydra.words import COMPOSING, in_words
from linkwright.pipeline.config.messages import GLOBAL
from linkwright.pipeline.config.presets import GROUPS, Presets
from linkwright.pipeline.errors import Diagnostic
from linkwright.stages.robot.system.install import install

LAUNCHERS, SWEEPERS = "hydra/launcher", "hydra/sweeper"

PLUG_INS = {
    "joblib": ("hydra-joblib-launcher", "joblib"),
    "submitit_slurm": ("hydra-submitit-launcher", "submitit"),
    "submitit_local": ("hydra-submitit-launcher", "submitit"),
    "ray": ("hydra-ray-launcher", "ray"),
    "optuna": ("hydra-optuna-sweeper", "optuna"),
}
"""Launchers and sweepers of Hydra's plug-ins → the package to install, and its extra."""

HEADER = f"the first line of a robot's file must be: {GLOBAL}"


def explained(error: Exception, presets: Presets) -> Diagnostic:
    """Returns the diagnostic for an error of Hydra's composition; raises other errors, which are bugs."""
    for kinds, handler in _HANDLERS:
        if isinstance(error, kinds):
            return handler(error, presets)
    raise error


def needs_plug_in(option: str, group: str = LAUNCHERS) -> Diagnostic:
    """Returns the problem of a launcher or sweeper whose plug-in is not installed."""
    kind = group.removeprefix("hydra/")
    text = f"the {kind} {option} needs a plug-in of Hydra that is not installed"
    return Diagnostic("E-OPTION", text, f"{group}={option}", install(*PLUG_INS[option]))


_YAML_HINTS = {
    "a tab": "replace the tab by spaces: YAML allows no tabs in front of a key",
    "could not find expected ':'": "write `key: value`, with a space after the colon",
    "expected <block end>": "let all keys of a mapping begin in the same column",
}
"""Problem of a YAML file → what to do."""


def _not_yaml(error: Any, presets: Presets) -> Diagnostic:
    problem = yaml_file.problem(error)
    general = "check quotes, colons and indentation there"
    hint = next((hint for words, hint in _YAML_HINTS.items() if words in problem), general)
    hint = error.hint if isinstance(error, RefusedError) else hint
    return Diagnostic("E-YAML", problem, yaml_file.where(error), hint)


def _no_such_file(error: Any, presets: Presets) -> Diagnostic:
    if not error.missing_cfg_file:
        return _not_composed(error, presets)
    group, _, option = error.missing_cfg_file.rpartition("/")
    if group in (LAUNCHERS, SWEEPERS):
        if option in PLUG_INS:
            return needs_plug_in(option, group)
        options = ", ".join(error.options or ("basic", *presets.options(group)))
        text = f"there is no {group.removeprefix('hydra/')} {option}"
        return Diagnostic("E-OPTION", text, f"{group}={option}", f"options: {options}")
    diagnostic = presets.unknown(group, option)
    if group.startswith("hydra/") and error.options:
        return Diagnostic(
            diagnostic.code, diagnostic.message, diagnostic.where, f"options: {', '.join(error.options)}"
        )
    return diagnostic


def _outside(error: Any, presets: Presets) -> Diagnostic:
    return outside(error.path, "the defaults lists, or the command line")


def _not_utf8(error: Any, presets: Presets) -> Diagnostic:
    return Diagnostic("E-YAML", "not UTF-8 text", str(presets.not_utf8() or ""), "save it as UTF-8")


def _too_deep(error: Any, presets: Presets) -> Diagnostic:
    return Diagnostic("E-OVERRIDE", "nested too deeply", "", "check the brackets on the command line")


def _not_composed(error: Any, presets: Presets) -> Diagnostic:
    if "hydra.searchpath" in str(error):
        return forbidden_key("searchpath")
    if "@robot." in str(error):
        return Diagnostic("E-KEY", "its defaults list chooses options below `robot`", "robot", HEADER)
    causes = [str(cause) for cause in (error, error.__cause__) if cause is not None]
    # What OmegaConf knows where it does not know a key.
    node = getattr(error.__cause__, "parent_node", None)
    settings = (
        [str(key) for key in node if not str(key).startswith("_")] if isinstance(node, DictConfig) else []
    )
    words = in_words("\n".join(causes), COMPOSING, [*GROUPS, *presets.own_groups()], settings)
    if words is not None:
        return Diagnostic("E-OVERRIDE", *words)
    lines = [line for line in "\n".join(causes).splitlines() if line.strip() and "append to your" not in line]
    hint = "check the defaults lists of your files; linkwright --info defaults-tree shows those in use"
    return Diagnostic("E-OVERRIDE", f"cannot be composed: {' '.join(lines[:2])}", "", hint)


def _not_readable(error: Any, presets: Presets) -> Diagnostic:
    text = f"cannot be read: {error.strerror or error}"
    return Diagnostic("E-YAML", text, str(error.filename or ""), "check the file and its folder")


_HANDLERS: tuple[tuple[tuple[type[Exception], ...], Callable[[Any, Presets], Diagnostic]], ...] = (
    ((OutsideError,), _outside),
    ((yaml.YAMLError,), _not_yaml),
    ((MissingConfigException,), _no_such_file),
    ((UnicodeDecodeError,), _not_utf8),
    ((RecursionError,), _too_deep),
    ((HydraException, OmegaConfBaseException, ValueError), _not_composed),
    ((OSError,), _not_readable),
)
"""Types of errors → the handler that makes the diagnostic; the first match is used."""
