"""Finds keys that a YAML file sets but must not set, because they could run code: files are data.

The check compares the composed tree, which includes all files, packages and interpolations, with the tree
that the command line alone composes (`trusted_tree`).
"""

import json
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from linkwright.pipeline import observed
from linkwright.pipeline.config.messages import shown
from linkwright.pipeline.key_path import Place, key_of
from linkwright.pipeline.terminal import pasted
from linkwright.stages.robot.errors import Diagnostic

CODE = "E-TRUST"

VARIABLE = "LINKWRIGHT_TRUST"
"""Environment variable with the files that are trusted as much as the command line."""

SAFE_VALUES: Mapping[str, Any] = {"source.trust": False, "plugins": []}
"""Keys that let code run → the only value that a file may set."""

TARGET = "_target_"
"""The key with which Hydra names code to run."""

USER_CHECKS = ("validate", "checks")
"""Place of the user's checks, which may name code in the modules of `plugins`."""

OBJECTIVE = ("objective",)
"""Place of the objective, which may name code in these modules too."""

ALLOWED = (
    "below hydra a file may set only sweeper.params, a search's n_trials, direction and sampler.seed, "
    "sweep.dir, sweep.subdir, and a launcher's numbers, partition, account, qos and time"
)

LAUNCHER = "launcher"
SWEEPER = "sweeper"

PARAMS = "sweeper.params"
"""The key of a sweep's overrides, below `hydra`."""

FOLDERS = ("sweep.dir", "sweep.subdir")
"""The keys of a sweep's folders, below `hydra`."""

BASIC = "basic"
"""Name of Hydra's own launcher, and of its own sweeper: they run the jobs one after the other, one for each
combination of the listed values."""

SEARCH = ("sweeper.n_trials", "sweeper.direction", "sweeper.sampler.seed")
"""Keys of a search that a file may set: two numbers, and the direction."""

_DIRECTIONS = ("minimize", "maximize")

_TEXT_SETTINGS = ("partition", "account", "qos", "time")
"""Settings of a launcher that are texts and that a file may set."""

_SAFE_TEXT = re.compile(r"[\w.,:-]+", re.ASCII)
"""A text that is safe in a shell."""

_CLOSED_SECTIONS = ("init", "additional_parameters")
"""Sections of a launcher that name hosts (Ray's) or options of another program (Slurm's)."""

_SET_BY_HYDRA = ("overrides", "runtime.choices", "runtime.config_sources", "job.override_dirname")
"""Keys that Hydra itself sets while it composes."""

_ABSENT = object()
"""The trusted value of a key that the command line's tree does not have."""


@dataclass(frozen=True, slots=True)
class SweepSettings:
    """The sweep settings that files may set."""

    launcher: str = BASIC
    """The option of hydra/launcher."""
    sweeper: str = BASIC
    """The option of hydra/sweeper."""
    search: Mapping[str, Any] = field(default_factory=dict)
    """The sweeper's settings that files set, by key below `hydra`."""
    launcher_settings: Mapping[str, Any] = field(default_factory=dict)
    """The launcher's settings that files set, by key below `hydra.launcher`."""
    params: Mapping[str, str] = field(default_factory=dict)
    """The overrides to sweep: key → values."""
    dir: str | None = None
    """The folder of the sweep, None if not set."""
    subdir: str | None = None
    """The folder of a job, None if not set."""


def compare_hydra_nodes(
    composed: Mapping[str, Any],
    trusted_tree: Mapping[str, Any],
    resolve: Callable[[Place], Any],
    command: Sequence[str] = ("linkwright",),
) -> tuple[dict[str, Any], list[Diagnostic]]:
    """Compares the composed `hydra` node (`composed`) with that of the command line (`trusted_tree`).

    Returns the changed settings that a file may set, by key without `hydra.`, and a problem for each other
    change. The nodes contain unresolved interpolations; `resolve` returns the value at a path. `command`:
    the typed command, with which hints begin.
    """
    changed: dict[str, Any] = {}
    refused: dict[str, Diagnostic] = {}
    for place, composed_value, trusted_value in _differences(composed, trusted_tree, ()):
        key = key_of(place)
        if key.startswith(_SET_BY_HYDRA):
            continue
        is_resolved = key == PARAMS or (place[0] in (LAUNCHER, SWEEPER) and trusted_value is not _ABSENT)
        value = resolve(place) if is_resolved else composed_value
        if _may_set(place, value, trusted_value):
            changed[key] = value
        else:
            # All changes within a section are one problem.
            section = key_of(place[: 2 if place[0] in (LAUNCHER, SWEEPER, "job") else 1])
            hint = _launcher_hint(place, value, trusted_value, command)
            refused.setdefault(section, not_allowed(section, value, hint))
    return changed, list(refused.values())


def _may_set(place: Place, value: Any, trusted_value: Any) -> bool:
    """Tells whether a file may set the key at `place`, below `hydra`, to a value."""
    key = key_of(place)
    return (
        key == PARAMS
        or key in FOLDERS
        or _is_harmless(place, value, trusted_value)
        or _is_search_setting(key, value)
    )


def _differences(composed: Any, trusted_tree: Any, place: Place) -> Iterator[tuple[Place, Any, Any]]:
    """Yields (place, value, trusted value) for each difference between nested mappings."""
    if isinstance(composed, Mapping) and isinstance(trusted_tree, Mapping):
        for name in {**composed, **trusted_tree}:
            yield from _differences(
                composed.get(name, _ABSENT), trusted_tree.get(name, _ABSENT), (*place, name)
            )
    # The types too, since 1 == True and 1 == 1.0.
    elif type(composed) is not type(trusted_tree) or composed != trusted_tree:
        yield place, None if composed is _ABSENT else composed, trusted_tree


def _is_harmless(place: Place, value: Any, trusted_value: Any) -> bool:
    """Tells whether a file may set this key of the launcher: to a number where the command line's tree has a
    number or null, or to an allowed text that is safe in a shell."""
    if (
        place[0] != LAUNCHER
        or trusted_value is _ABSENT
        or str(place[-1]).startswith("_")
        or {*place} & {*_CLOSED_SECTIONS}
    ):
        return False
    if _is_number(value):
        return trusted_value is None or _is_number(trusted_value)
    return place[-1] in _TEXT_SETTINGS and isinstance(value, str) and bool(_SAFE_TEXT.fullmatch(value))


def _is_search_setting(key: str, value: Any) -> bool:
    """Tells whether this is a key of a search that a file may set to this value."""
    if key == "sweeper.direction":
        return all(word in _DIRECTIONS for word in (value if _is_list(value) else [value]))
    return key in SEARCH and _is_number(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _launcher_hint(place: Place, value: Any, trusted_value: Any, command: Sequence[str]) -> str:
    """Returns a hint to type a launcher's setting on the command line; "" if that is not allowed either."""
    items = value if _is_list(value) else [value]
    can_be_typed = all(isinstance(item, str | int | float) for item in items)
    if place[0] != LAUNCHER or trusted_value is _ABSENT or not can_be_typed or str(place[-1]).startswith("_"):
        return ""
    return f"if you trust it: {pasted.line(command)} {override(f'hydra.{key_of(place)}', value)}"


def not_allowed(key: str, value: Any = None, hint: str = "") -> Diagnostic:
    """Returns the problem with a key of `hydra` that a file must not set."""
    suffix = "" if value is None else f" (given {shown(value)})"
    hint = hint or f"remove it: {ALLOWED}"
    return Diagnostic(CODE, f"a file must not set this key{suffix}", f"hydra.{key}", hint)


def overridden_groups(contents: Iterable[Mapping[str, Any]]) -> Iterator[Diagnostic]:
    """Yields a problem for each group of Hydra that the defaults list of a file overrides, even if the
    override has no effect. The launcher and the sweeper are allowed."""
    for content in contents:
        defaults = content.get("defaults")
        if not isinstance(defaults, list):
            continue
        for entry in defaults:
            name = next(iter(entry), "") if isinstance(entry, Mapping) else entry
            group = str(name).removeprefix("optional ").removeprefix("override ").strip().lstrip("/")
            if group.startswith("hydra/") and group not in (f"hydra/{LAUNCHER}", f"hydra/{SWEEPER}"):
                yield not_allowed(group.partition("/")[2])


def forbidden_targets(tree: Any, command: str = "", place: Place = ()) -> Iterator[Diagnostic]:
    """Yields a problem for each `_target_` in a tree, since it names code to run. In the user's own checks
    and in the objective, code of trusted modules is allowed. `command`: the typed command, with which hints
    begin."""
    plugins: Any = tree.get("plugins") if isinstance(tree, Mapping) else ()
    names = [str(plugin) for plugin in plugins] if _is_list(plugins) else []
    return _forbidden_targets(tree, names, command, place)


def _forbidden_targets(tree: Any, plugins: Sequence[str], command: str, place: Place) -> Iterator[Diagnostic]:
    pairs: Iterable[tuple[Any, Any]] = ()
    if isinstance(tree, Mapping):
        pairs = tree.items()
    elif isinstance(tree, list | tuple):
        pairs = enumerate(tree)
    for name, value in pairs:
        # Indices of lists stay numbers, keys become texts.
        inner = (*place, name if isinstance(name, int) and not isinstance(tree, Mapping) else str(name))
        if name != TARGET:
            yield from _forbidden_targets(value, plugins, command, inner)
        elif place != OBJECTIVE and (place[:2] != USER_CHECKS or len(place) != 3):
            text = f"a configuration must not name code (given {shown(value)})"
            yield Diagnostic(CODE, text, key_of(inner), "remove it: a robot's file is data and runs no code")
        elif isinstance(value, str) and not is_in_modules(value, plugins):
            text = f"this names code in a module that is not trusted (given {shown(value)})"
            module = override("plugins", [value.partition(".")[0]])
            yield Diagnostic(CODE, text, key_of(inner), f"if you trust it: {command} {module}")


def is_in_modules(target: str, plugins: Iterable[str]) -> bool:
    """Tells whether a `_target_` is in one of these modules or their submodules."""
    return any(target.startswith(f"{plugin}.") for plugin in plugins)


def trust_problems(
    tree: Mapping[str, Any],
    typed: Iterable[str],
    files: Iterable[Path],
    environ: Mapping[str, str],
    command: str,
) -> list[Diagnostic]:
    """Returns a problem for each key that lets code run and that only a file sets.

    `typed`: the keys that the command line sets; `files`: the user's own files in the composition;
    `command`: the typed command, with which hints begin.
    """
    typed = set(typed)
    settings = {
        key: value for key, default in SAFE_VALUES.items() if (value := _at(tree, key, default)) != default
    }
    untrusted_keys = [key for key in settings if key not in typed]
    if not untrusted_keys or are_trusted(files, environ):
        return []
    return [
        Diagnostic(
            CODE,
            "this key must be set on the command line, since a file cannot trust itself "
            f"(given {shown(settings[key])})",
            key,
            f"if you trust it: {command} {override(key, settings[key])}",
        )
        for key in untrusted_keys
    ]


def _at(tree: Any, key: str, default: Any) -> Any:
    for name in key.split("."):
        if not isinstance(tree, Mapping) or name not in tree:
            return default
        tree = tree[name]
    return tree


def are_trusted(files: Iterable[Path], environ: Mapping[str, str]) -> bool:
    """Tells whether `LINKWRIGHT_TRUST` names all of these files; False if there are none."""
    texts = [text for text in environ.get(VARIABLE, "").split(os.pathsep) if text]
    trusted_files = {observed.real(Path(text).expanduser()) for text in texts}
    files = set(map(observed.real, files))
    return bool(files) and files <= trusted_files


def override(key: str, value: Any) -> str:
    """Returns `key=value` as a user types it."""
    plain: bool | str | list[str] = str(value)
    if isinstance(value, bool):
        plain = value
    elif _is_list(value):
        plain = [str(item) for item in value]
    # Hydra reads texts without quotation marks.
    text = json.dumps(plain, ensure_ascii=False).replace('"', "")
    return pasted.word(f"{key}={text}")


def _is_list(value: Any) -> bool:
    return isinstance(value, list | tuple)
