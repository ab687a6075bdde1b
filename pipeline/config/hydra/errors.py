"""Translates errors of Hydra and OmegaConf to diagnostics about the user's files."""

from collections.abc import Callable
from typing import Any

import yaml
from hydra.errors import HydraException, MissingConfigException
from omegaconf import DictConfig
from omegaconf.errors import OmegaConfBaseException

from linkwright.pipeline.config.files import yaml_file
from linkwright.pipeline.config.files.reach import OutsideError, outside_problem
from linkwright.pipeline.config.files.trust import forbidden_key_problem
from linkwright.pipeline.config.files.yaml_file import RefusedError
from linkwright.pipeline.config.hydra.words import COMPOSITION_RULES, translate
from linkwright.pipeline.config.messages import GLOBAL
from linkwright.pipeline.config.presets import GROUPS, Presets
from linkwright.pipeline.errors import Diagnostic
from linkwright.stages.robot.system.install import install

LAUNCHERS, SWEEPERS = "hydra/launcher", "hydra/sweeper"

PLUG_IN_PACKAGES = {
    "joblib": ("hydra-joblib-launcher", "joblib"),
    "submitit_slurm": ("hydra-submitit-launcher", "submitit"),
    "submitit_local": ("hydra-submitit-launcher", "submitit"),
    "ray": ("hydra-ray-launcher", "ray"),
    "optuna": ("hydra-optuna-sweeper", "optuna"),
}
"""Launchers and sweepers of Hydra's plug-ins → the package to install, and its extra."""

_HEADER_HINT = f"the first line of a robot's file must be: {GLOBAL}"


def composition_problem(error: Exception, presets: Presets) -> Diagnostic:
    """Returns the diagnostic for an error of Hydra's composition; raises other errors, which are bugs."""
    for kinds, handler in _HANDLERS:
        if isinstance(error, kinds):
            return handler(error, presets)
    raise error


def plug_in_problem(option: str, group: str = LAUNCHERS) -> Diagnostic:
    """Returns the problem of a launcher or sweeper whose plug-in is not installed."""
    kind = group.removeprefix("hydra/")
    text = f"the {kind} {option} needs a plug-in of Hydra that is not installed"
    return Diagnostic("E-OPTION", text, f"{group}={option}", install(*PLUG_IN_PACKAGES[option]))


_YAML_HINTS = {
    "a tab": "replace the tab by spaces: YAML allows no tabs in front of a key",
    "could not find expected ':'": "write `key: value`, with a space after the colon",
    "expected <block end>": "let all keys of a mapping begin in the same column",
}
"""Words in the problem of a YAML file → the hint."""


def _yaml_problem(error: Any, presets: Presets) -> Diagnostic:
    problem = yaml_file.problem(error)
    general_hint = "check quotes, colons and indentation there"
    hint = next((hint for words, hint in _YAML_HINTS.items() if words in problem), general_hint)
    hint = error.hint if isinstance(error, RefusedError) else hint
    return Diagnostic("E-YAML", problem, yaml_file.where(error), hint)


def _missing_file_problem(error: Any, presets: Presets) -> Diagnostic:
    if not error.missing_cfg_file:
        return _other_problem(error, presets)
    group, _, option = error.missing_cfg_file.rpartition("/")
    if group in (LAUNCHERS, SWEEPERS):
        if option in PLUG_IN_PACKAGES:
            return plug_in_problem(option, group)
        options = ", ".join(error.options or ("basic", *presets.options(group)))
        text = f"there is no {group.removeprefix('hydra/')} {option}"
        return Diagnostic("E-OPTION", text, f"{group}={option}", f"options: {options}")
    diagnostic = presets.unknown(group, option)
    if group.startswith("hydra/") and error.options:
        return Diagnostic(
            diagnostic.code, diagnostic.message, diagnostic.where, f"options: {', '.join(error.options)}"
        )
    return diagnostic


def _outside_problem(error: Any, presets: Presets) -> Diagnostic:
    return outside_problem(error.path, "the defaults lists, or the command line")


def _encoding_problem(error: Any, presets: Presets) -> Diagnostic:
    return Diagnostic("E-YAML", "not UTF-8 text", str(presets.not_utf8() or ""), "save it as UTF-8")


def _depth_problem(error: Any, presets: Presets) -> Diagnostic:
    return Diagnostic("E-OVERRIDE", "nested too deeply", "", "check the brackets on the command line")


def _other_problem(error: Any, presets: Presets) -> Diagnostic:
    if "hydra.searchpath" in str(error):
        return forbidden_key_problem("searchpath")
    if "@robot." in str(error):
        return Diagnostic("E-KEY", "its defaults list chooses options below `robot`", "robot", _HEADER_HINT)
    causes = [str(cause) for cause in (error, error.__cause__) if cause is not None]
    # The known keys of the node in which OmegaConf does not know a key: the settings to suggest.
    node = getattr(error.__cause__, "parent_node", None)
    settings = (
        [str(key) for key in node if not str(key).startswith("_")] if isinstance(node, DictConfig) else []
    )
    words = translate("\n".join(causes), COMPOSITION_RULES, [*GROUPS, *presets.own_groups()], settings)
    if words is not None:
        return Diagnostic("E-OVERRIDE", *words)
    lines = [line for line in "\n".join(causes).splitlines() if line.strip() and "append to your" not in line]
    hint = "check the defaults lists of your files; linkwright --info defaults-tree shows those in use"
    return Diagnostic("E-OVERRIDE", f"cannot be composed: {' '.join(lines[:2])}", "", hint)


def _read_problem(error: Any, presets: Presets) -> Diagnostic:
    text = f"cannot be read: {error.strerror or error}"
    return Diagnostic("E-YAML", text, str(error.filename or ""), "check the file and its folder")


_HANDLERS: tuple[tuple[tuple[type[Exception], ...], Callable[[Any, Presets], Diagnostic]], ...] = (
    ((OutsideError,), _outside_problem),
    ((yaml.YAMLError,), _yaml_problem),
    ((MissingConfigException,), _missing_file_problem),
    ((UnicodeDecodeError,), _encoding_problem),
    ((RecursionError,), _depth_problem),
    ((HydraException, OmegaConfBaseException, ValueError), _other_problem),
    ((OSError,), _read_problem),
)
"""Types of errors → the handler that makes the diagnostic; the first match is used."""
