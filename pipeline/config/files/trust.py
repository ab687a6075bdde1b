"""Finds keys that a YAML file sets but must not set, because they could run code: files are data.

The check compares the composed tree, which includes all files, packages and interpolations, with the tree
that the command line alone composes.
"""

import json
import os
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from linkwright.pipeline import observed
from linkwright.pipeline.config.messages import shown
from linkwright.pipeline.key_path import Place, key_of
from linkwright.pipeline.terminal import pasted
from linkwright.stages.robot.errors import Diagnostic

TRUST_CODE = "E-TRUST"
"""Code of the problem of a key that only the command line may set."""

TRUST_VARIABLE = "LINKWRIGHT_TRUST"
"""Environment variable with the paths of files that may set what the command line may set."""

SAFE_VALUES: Mapping[str, Any] = {"source.trust": False, "plugins": []}
"""Keys that let code run → the only value that a file may set."""

TARGET_KEY = "_target_"
"""The key with which Hydra names code to run."""

_USER_CHECKS_PLACE, _OBJECTIVE_PLACE = ("validate", "checks"), ("objective",)
"""Places of the user's checks and of the objective, which may name code in the modules of `plugins`."""

_ALLOWED_KEYS_HINT = (
    "below hydra a file may set only sweeper.params, a search's n_trials, direction and sampler.seed, "
    "sweep.dir, sweep.subdir, and a launcher's numbers, partition, account, qos and time"
)
"""What a file may set below `hydra`, for hints."""

LAUNCHER, SWEEPER = "launcher", "sweeper"
"""The keys of the launcher and of the sweeper, below `hydra`."""

PARAMS_KEY = "sweeper.params"
"""The key of a sweep's overrides, below `hydra`."""

FOLDER_KEYS = ("sweep.dir", "sweep.subdir")
"""The keys of a sweep's folders, below `hydra`."""

BASIC_OPTION = "basic"
"""Option of Hydra's own launcher and of its own sweeper: they run a job for each combination of the listed
values, one after the other."""

SEARCH_KEYS = ("sweeper.n_trials", "sweeper.direction", "sweeper.sampler.seed")
"""Keys that a file may set for a search, in which a sweeper such as Optuna chooses the values."""

_DIRECTIONS = ("minimize", "maximize")

_TEXT_KEYS = ("partition", "account", "qos", "time")
"""Keys of a launcher that a file may set to a text."""

_SAFE_TEXT = re.compile(r"[\w.,:-]+", re.ASCII)
"""A text that is safe in a shell."""

_CLOSED_LAUNCHER_SECTIONS = ("init", "additional_parameters")
"""Sections of a launcher in which a file may set nothing: they name hosts (Ray) or options of another program
(Slurm)."""

_PREFIXES_SET_BY_HYDRA = ("overrides", "runtime.choices", "runtime.config_sources", "job.override_dirname")
"""Beginnings of keys, below `hydra`, that Hydra itself sets while it composes."""

_ABSENT = object()
"""The trusted value of a key that the command line's tree does not have."""


@dataclass(frozen=True, slots=True)
class SweepSettings:
    """The launcher and the sweeper, and the sweep settings that files set."""

    launcher: str = BASIC_OPTION
    """The option of hydra/launcher."""
    sweeper: str = BASIC_OPTION
    """The option of hydra/sweeper."""
    search_settings: Mapping[str, Any] = field(default_factory=dict)
    """The sweeper's settings that files set, by key below `hydra`."""
    launcher_settings: Mapping[str, Any] = field(default_factory=dict)
    """The launcher's settings that files set, by key below `hydra.launcher`."""
    params: Mapping[str, str] = field(default_factory=dict)
    """Key to sweep → its values, as in an override."""
    dir: str | None = None
    """The folder of the sweep; None if it is not set."""
    subdir: str | None = None
    """The folder of a job; None if it is not set."""


def compare_hydra_nodes(
    composed_node: Mapping[str, Any],
    trusted_node: Mapping[str, Any],
    resolve: Callable[[Place], Any],
    command: Sequence[str] = ("linkwright",),
) -> tuple[dict[str, Any], list[Diagnostic]]:
    """Compares the composed node `hydra` with the node that the command line alone composes.

    Returns the changed settings that a file may set, by key without `hydra.`, and a problem for each other
    change. The nodes contain unresolved interpolations; `resolve` returns the resolved value at a place.
    `command`: the words of the typed command, with which hints begin.
    """
    settings: dict[str, Any] = {}
    problems: dict[str, Diagnostic] = {}
    for place, composed_value, trusted_value in _differences(composed_node, trusted_node, ()):
        key = key_of(place)
        if key.startswith(_PREFIXES_SET_BY_HYDRA):
            continue
        # Only these are resolved here: folders are resolved later, for each job; others are refused.
        is_launcher_or_sweeper_key = place[0] in (LAUNCHER, SWEEPER) and trusted_value is not _ABSENT
        value = resolve(place) if key == PARAMS_KEY or is_launcher_or_sweeper_key else composed_value
        if _may_set(place, value, trusted_value):
            settings[key] = value
        else:
            # All changes within a section make a single problem.
            section = key_of(place[: 2 if place[0] in (LAUNCHER, SWEEPER, "job") else 1])
            hint = _launcher_hint(place, value, trusted_value, command)
            problems.setdefault(section, forbidden_key_problem(section, value, hint))
    return settings, list(problems.values())


def _may_set(place: Place, value: Any, trusted_value: Any) -> bool:
    """Tells whether a file may set the key at `place`, below `hydra`, to a value."""
    key = key_of(place)
    return (
        key == PARAMS_KEY
        or key in FOLDER_KEYS
        or _is_launcher_setting(place, value, trusted_value)
        or _is_search_setting(key, value)
    )


def _differences(composed: Any, trusted: Any, place: Place) -> Iterator[tuple[Place, Any, Any]]:
    """Yields (place, composed value, trusted value) for each difference between nested mappings. The composed
    value is None if only the trusted node has the key."""
    if isinstance(composed, Mapping) and isinstance(trusted, Mapping):
        for name in {**composed, **trusted}:
            yield from _differences(composed.get(name, _ABSENT), trusted.get(name, _ABSENT), (*place, name))
    # Types are compared too, since 1 == True and 1 == 1.0.
    elif type(composed) is not type(trusted) or composed != trusted:
        yield place, None if composed is _ABSENT else composed, trusted


def _is_launcher_setting(place: Place, value: Any, trusted_value: Any) -> bool:
    """Tells whether a file may set this key of the launcher: to a number where the command line's tree has a
    number or null, or to an allowed text that is safe in a shell."""
    if not _is_launcher_key(place, trusted_value) or {*place} & {*_CLOSED_LAUNCHER_SECTIONS}:
        return False
    if _is_number(value):
        return trusted_value is None or _is_number(trusted_value)
    return place[-1] in _TEXT_KEYS and isinstance(value, str) and bool(_SAFE_TEXT.fullmatch(value))


def _is_launcher_key(place: Place, trusted_value: Any) -> bool:
    """Tells whether the command line's tree has this key of the launcher, unless the key is Hydra's own."""
    return place[0] == LAUNCHER and trusted_value is not _ABSENT and not str(place[-1]).startswith("_")


def _is_search_setting(key: str, value: Any) -> bool:
    """Tells whether a file may set this key of a search, below `hydra`, to this value."""
    if key == "sweeper.direction":
        # A search with several objectives has a list of directions.
        return all(direction in _DIRECTIONS for direction in _as_list(value))
    return key in SEARCH_KEYS and _is_number(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _launcher_hint(place: Place, value: Any, trusted_value: Any, command: Sequence[str]) -> str:
    """Returns a hint to type a launcher's setting on the command line; "" if that is not allowed either."""
    fits_command_line = all(isinstance(item, str | int | float) for item in _as_list(value))
    if not fits_command_line or not _is_launcher_key(place, trusted_value):
        return ""
    return f"if you trust it: {pasted.line(command)} {override_text(f'hydra.{key_of(place)}', value)}"


def forbidden_key_problem(key: str, value: Any = None, hint: str = "") -> Diagnostic:
    """Returns the problem with a key of `hydra` that a file must not set."""
    suffix = "" if value is None else f" (given {shown(value)})"
    hint = hint or f"remove it: {_ALLOWED_KEYS_HINT}"
    return Diagnostic(TRUST_CODE, f"a file must not set this key{suffix}", f"hydra.{key}", hint)


def overridden_group_problems(contents: Iterable[Mapping[str, Any]]) -> Iterator[Diagnostic]:
    """Yields a problem for each group of Hydra that the defaults list of a file overrides, even if the
    override has no effect. The launcher and the sweeper are allowed."""
    for content in contents:
        defaults = content.get("defaults")
        if not isinstance(defaults, list):
            continue
        for entry in defaults:
            # An entry is `{group: option}`, or only a text.
            name = next(iter(entry), "") if isinstance(entry, Mapping) else entry
            group = str(name).removeprefix("optional ").removeprefix("override ").strip().lstrip("/")
            if group.startswith("hydra/") and group not in (f"hydra/{LAUNCHER}", f"hydra/{SWEEPER}"):
                yield forbidden_key_problem(group.partition("/")[2])


def forbidden_target_problems(tree: Any, command_text: str = "", place: Place = ()) -> Iterator[Diagnostic]:
    """Yields a problem for each forbidden `_target_` in a tree, which names code to run.

    The user's own checks and the objective may name code in the modules of the tree's `plugins`. `place`: the
    place of `tree` in the configuration; `command_text`: the typed command, with which hints begin.
    """
    plugins: Any = tree.get("plugins") if isinstance(tree, Mapping) else ()
    modules = [str(plugin) for plugin in plugins] if _is_list(plugins) else []
    return _target_problems(tree, modules, command_text, place)


def _target_problems(tree: Any, modules: list[str], command_text: str, place: Place) -> Iterator[Diagnostic]:
    """Yields the problems of `forbidden_target_problems`; `modules`: the names of the trusted modules."""
    pairs: Iterable[tuple[Any, Any]] = ()
    if isinstance(tree, Mapping):
        pairs = tree.items()
    elif isinstance(tree, list | tuple):
        pairs = enumerate(tree)
    for name, value in pairs:
        # Indices of lists stay numbers, keys of mappings become texts.
        inner_place = (*place, str(name) if isinstance(tree, Mapping) else name)
        if name != TARGET_KEY:
            yield from _target_problems(value, modules, command_text, inner_place)
        elif not _may_name_code(place):
            text = f"a configuration must not name code (given {shown(value)})"
            hint = "remove it: a robot's file is data and runs no code"
            yield Diagnostic(TRUST_CODE, text, key_of(inner_place), hint)
        elif isinstance(value, str) and not is_in_modules(value, modules):
            text = f"this names code in a module that is not trusted (given {shown(value)})"
            plugins_override = override_text("plugins", [value.partition(".")[0]])
            hint = f"if you trust it: {command_text} {plugins_override}"
            yield Diagnostic(TRUST_CODE, text, key_of(inner_place), hint)


def _may_name_code(place: Place) -> bool:
    """Tells whether the mapping at a place is the objective or one of the user's checks."""
    return place == _OBJECTIVE_PLACE or (place[:2] == _USER_CHECKS_PLACE and len(place) == 3)


def is_in_modules(target: str, modules: Iterable[str]) -> bool:
    """Tells whether the value of a `_target_` is in any of these modules or their submodules."""
    return any(target.startswith(f"{module}.") for module in modules)


def trust_problems(
    tree: Mapping[str, Any],
    typed_keys: Collection[str],
    files: Iterable[Path],
    environ: Mapping[str, str],
    command_text: str,
) -> list[Diagnostic]:
    """Returns a problem for each key that lets code run and that only a file sets.

    `typed_keys`: the keys that the command line sets; `files`: the user's own files in the composition;
    `command_text`: the typed command, with which hints begin.
    """
    values = {key: _value_at(tree, key, safe_value) for key, safe_value in SAFE_VALUES.items()}
    unsafe_keys = [key for key, value in values.items() if value != SAFE_VALUES[key]]
    untrusted_keys = [key for key in unsafe_keys if key not in typed_keys]
    if not untrusted_keys or are_trusted(files, environ):
        return []
    return [
        Diagnostic(
            TRUST_CODE,
            "this key must be set on the command line, since a file cannot trust itself "
            f"(given {shown(values[key])})",
            key,
            f"if you trust it: {command_text} {override_text(key, values[key])}",
        )
        for key in untrusted_keys
    ]


def _value_at(tree: Any, key: str, default: Any) -> Any:
    """Returns the value of a key, whose levels are separated by dots; `default` if the tree lacks it."""
    for name in key.split("."):
        if not isinstance(tree, Mapping) or name not in tree:
            return default
        tree = tree[name]
    return tree


def are_trusted(files: Iterable[Path], environ: Mapping[str, str]) -> bool:
    """Tells whether `LINKWRIGHT_TRUST` names all of these files; False if there are none."""
    paths = [path for path in environ.get(TRUST_VARIABLE, "").split(os.pathsep) if path]
    trusted_files = {observed.real_path(Path(path).expanduser()) for path in paths}
    real_files = set(map(observed.real_path, files))
    return bool(real_files) and real_files <= trusted_files


def override_text(key: str, value: Any) -> str:
    """Returns `key=value` as a user types it."""
    json_value: bool | str | list[str] = str(value)
    if isinstance(value, bool):
        json_value = value
    elif _is_list(value):
        json_value = [str(item) for item in value]
    # Hydra reads texts without quotation marks.
    text = json.dumps(json_value, ensure_ascii=False).replace('"', "")
    return pasted.word(f"{key}={text}")


def _as_list(value: Any) -> Sequence[Any]:
    """Returns a list or tuple unchanged, and any other value as the only item of a list."""
    return value if isinstance(value, list | tuple) else [value]


def _is_list(value: Any) -> bool:
    return isinstance(value, list | tuple)
