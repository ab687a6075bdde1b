"""Keys that a YAML file must not set, because they would run code: files are data.

The check compares the composed tree, after all files, packages and interpolations, with the tree of the
command line alone (`ours`).
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
"""The variable that names the files that are trusted like the command line."""

DEFAULTS: Mapping[str, Any] = {"source.trust": False, "plugins": []}
"""Keys that let code run, and the only value of each that a file may set."""

TARGET = "_target_"

ALLOWED = (
    "below hydra a file may set only sweeper.params, sweep.dir, sweep.subdir, and a launcher's numbers, "
    "partition and time"
)

LAUNCHER = "launcher"
PARAMS = "sweeper.params"
FOLDERS = ("sweep.dir", "sweep.subdir")

_WORDS = ("partition", "time")
_WORD = re.compile(r"[\w.,:-]+", re.ASCII)
_FILLED_IN = ("overrides", "runtime.choices", "runtime.config_sources", "job.override_dirname")
"""Keys that Hydra itself sets while it composes."""


@dataclass(frozen=True, slots=True)
class SweepSettings:
    """The sweep settings that files may set.

    `launcher`: the option of hydra/launcher; `numbers`: what they set of it; `params`: overrides, key →
    values; `dir` and `subdir`: folders of the sweep and of a job, None where they are not set.
    """

    launcher: str = "basic"
    numbers: Mapping[str, Any] = field(default_factory=dict)
    params: Mapping[str, str] = field(default_factory=dict)
    dir: str | None = None
    subdir: str | None = None


def listed(
    theirs: Mapping[str, Any], ours: Mapping[str, Any], resolved: Callable[[Place], Any]
) -> tuple[dict[str, Any], list[Diagnostic]]:
    """Compares two `hydra` nodes: returns the changed settings that a file may set, by key without `hydra.`,
    and a problem for each other change.

    The nodes are as written, with interpolations; `resolved` gives a setting's value.
    """
    changed: dict[str, Any] = {}
    refused: dict[str, Any] = {}
    for place, value, known in _differences(theirs, ours, ()):
        key = key_of(place)
        if key.startswith(_FILLED_IN):
            continue
        if key == PARAMS or (place[0] == LAUNCHER and known is not _ABSENT):
            value = resolved(place)
        if key == PARAMS or key in FOLDERS or _harmless(place, value, known):
            changed[key] = value
        else:
            # A whole section that was exchanged is one problem.
            refused.setdefault(key_of(place[: 2 if place[0] in (LAUNCHER, "sweeper", "job") else 1]), value)
    return changed, [not_allowed(key, value) for key, value in refused.items()]


_ABSENT = object()


def _differences(theirs: Any, ours: Any, place: Place) -> Iterator[tuple[Place, Any, Any]]:
    """Place, value and our value of each difference between nested mappings."""
    if isinstance(theirs, Mapping) and isinstance(ours, Mapping):
        for name in {**theirs, **ours}:
            yield from _differences(theirs.get(name, _ABSENT), ours.get(name, _ABSENT), (*place, name))
    # 1 == True, and 1 == 1.0.
    elif type(theirs) is not type(ours) or theirs != ours:
        yield place, None if theirs is _ABSENT else theirs, ours


def _harmless(place: Place, value: Any, known: Any) -> bool:
    """Whether a setting is a number of a launcher, or a word that is safe in a shell."""
    if place[0] != LAUNCHER or known is _ABSENT or str(place[-1]).startswith("_"):
        return False
    if _is_number(value):
        return known is None or _is_number(known)
    return place[-1] in _WORDS and isinstance(value, str) and bool(_WORD.fullmatch(value))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def not_allowed(key: str, value: Any = None) -> Diagnostic:
    """The problem of a key of `hydra` that a file may not set."""
    given = "" if value is None else f" (given {shown(value)})"
    return Diagnostic(CODE, f"a file must not set this key{given}", f"hydra.{key}", f"remove it: {ALLOWED}")


def overridden(contents: Iterable[Mapping[str, Any]]) -> Iterator[Diagnostic]:
    """A problem for each group of Hydra, except the launcher, that a file's defaults list overrides, even
    without effect."""
    for content in contents:
        defaults = content.get("defaults")
        for entry in defaults if isinstance(defaults, list) else ():
            name = next(iter(entry), "") if isinstance(entry, Mapping) else entry
            group = str(name).removeprefix("optional ").removeprefix("override ").strip().lstrip("/")
            if group.startswith("hydra/") and group != f"hydra/{LAUNCHER}":
                yield not_allowed(group.partition("/")[2])


OWN_CHECKS = ("validate", "checks")
"""The key whose entries may name code of a module that `plugins` names."""


def targets(tree: Any, command: str = "", place: Place = ()) -> Iterator[Diagnostic]:
    """A problem for each `_target_` in a tree, which would name code to run, but for those of the user's own
    checks that are of trusted modules. `command`: what was typed, to which the hint adds."""
    plugins: Any = tree.get("plugins") if isinstance(tree, Mapping) else ()
    return _targets(tree, [str(one) for one in plugins] if _is_list(plugins) else [], command, place)


def _targets(tree: Any, plugins: Sequence[str], command: str, place: Place) -> Iterator[Diagnostic]:
    pairs: Iterable[tuple[Any, Any]] = ()
    if isinstance(tree, Mapping):
        pairs = tree.items()
    elif isinstance(tree, list | tuple):
        pairs = enumerate(tree)
    for name, value in pairs:
        inner = (*place, name if isinstance(name, int) and not isinstance(tree, Mapping) else str(name))
        if name != TARGET:
            yield from _targets(value, plugins, command, inner)
        elif place[:2] != OWN_CHECKS or len(place) != 3:
            text = f"a configuration must not name code (given {shown(value)})"
            yield Diagnostic(CODE, text, key_of(inner), "remove it: a robot's file is data and runs no code")
        elif isinstance(value, str) and not covered(value, plugins):
            text = f"names code of a module that is not trusted (given {shown(value)})"
            module = override("plugins", [value.partition(".")[0]])
            yield Diagnostic(CODE, text, key_of(inner), f"if you trust it: {command} {module}")


def covered(target: str, plugins: Iterable[str]) -> bool:
    """Whether a `_target_` is of one of these modules, or of a module below it."""
    return any(target.startswith(f"{plugin}.") for plugin in plugins)


def untrusted(
    tree: Mapping[str, Any],
    typed: Iterable[str],
    files: Iterable[Path],
    environ: Mapping[str, str],
    command: str,
) -> list[Diagnostic]:
    """A problem for each key that lets code run and that only a file sets.

    `typed`: those of these keys that the command line gives; `files`: the user's own files that were
    composed; `command`: what was typed, to which the hint adds.
    """
    typed = set(typed)
    given = {key: value for key, default in DEFAULTS.items() if (value := _at(tree, key, default)) != default}
    wanting = [key for key in given if key not in typed]
    if not wanting or trusted(files, environ):
        return []
    return [
        Diagnostic(
            CODE,
            f"must be set on the command line: a file cannot trust itself (given {shown(given[key])})",
            key,
            f"if you trust it: {command} {override(key, given[key])}",
        )
        for key in wanting
    ]


def _at(tree: Any, key: str, default: Any) -> Any:
    for name in key.split("."):
        if not isinstance(tree, Mapping) or name not in tree:
            return default
        tree = tree[name]
    return tree


def trusted(files: Iterable[Path], environ: Mapping[str, str]) -> bool:
    """Whether the environment names all of these files, and there is at least one."""
    texts = [text for text in environ.get(VARIABLE, "").split(os.pathsep) if text]
    trusted = {observed.real(Path(text).expanduser()) for text in texts}
    files = set(map(observed.real, files))
    return bool(files) and files <= trusted


def override(key: str, value: Any) -> str:
    """`key=value` as a user types it."""
    plain = (
        value if isinstance(value, bool) else [str(one) for one in value] if _is_list(value) else str(value)
    )
    text = json.dumps(plain, ensure_ascii=False).replace('"', "")
    return pasted.word(f"{key}={text}")


def _is_list(value: Any) -> bool:
    return isinstance(value, list | tuple)
