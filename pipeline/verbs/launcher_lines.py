"""Describes the launchers of sweeps, and their keys, for `linkwright explain`."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import linkwright.conf

_LAUNCHER_FOLDER = Path(linkwright.conf.__file__).parent / "hydra" / "launcher"
"""The folder with a file for each launcher."""

_LAUNCHER_KEY = re.compile(r"hydra[./]launcher([.=][\w.]+)?")
"""Matches the group of launchers, a launcher, or a key of a launcher, as a user may type it."""


class LauncherDescription(NamedTuple):
    """A launcher: how it is chosen, what it does, and its keys with their defaults."""

    title: str
    meaning: str
    keys: tuple[str, ...]


def launcher_lines(name: str) -> list[LauncherDescription]:
    """Returns the launchers for `hydra/launcher` (all), `hydra/launcher=slurm` (this) or
    `hydra.launcher.timeout_min` (those with this key); an empty list for any other text."""
    match = _LAUNCHER_KEY.fullmatch(name)
    if match is None:
        return []
    launchers = [_read(path) for path in sorted(_LAUNCHER_FOLDER.glob("*.yaml"))]
    # The group may be typed with a separator and nothing after it: `hydra.launcher.` names all launchers.
    separator, suffix = (match[1] or ".")[:1], (match[1] or "")[1:]
    if separator == "=":
        return [launcher for launcher in launchers if launcher.title.endswith(f"={suffix}")]
    key = f"hydra.launcher.{suffix}"
    chosen = [launcher._replace(keys=tuple(_matching_lines(launcher.keys, key))) for launcher in launchers]
    return [launcher for launcher in chosen if launcher.keys]


def _matching_lines(lines: tuple[str, ...], key: str) -> Iterator[str]:
    """Yields the lines about this key; all lines if `key` names no key below `hydra.launcher`."""
    names_a_key = key.rstrip(".") != "hydra.launcher"
    return (line for line in lines if not names_a_key or line.split("=")[0] == key)


def _read(path: Path) -> LauncherDescription:
    """Reads the file of a launcher as lines, not as YAML, since its comments describe the launcher and its
    keys."""
    comments, keys, parents = [], [], [""]
    # The first line is Hydra's `# @package`.
    for line in path.read_text(encoding="utf-8").splitlines()[1:]:
        if line.startswith("# "):
            comments.append(line[2:])
        # (indentation)(key):( value)( # meaning)
        match = re.fullmatch(r"( *)([a-z]\w*):(?: ([^#]*?))?(?: *# (.*))?", line)
        if match is None or match[2] == "defaults":
            continue
        # Two spaces for each level; `parents[0]` stands for `hydra.launcher`.
        depth = len(match[1]) // 2
        parents = [*parents[: depth + 1], match[2]]
        if match[3] is not None:
            key = ".".join(["hydra.launcher", *parents[1:]])
            keys.append(f"{key}={match[3]}" + (f"   {match[4]}" if match[4] else ""))
    return LauncherDescription(f"hydra/launcher={path.stem}", " ".join(comments), tuple(keys))
