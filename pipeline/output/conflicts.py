"""What in an output folder a build must leave alone: what it can carry over, and what is in its way."""

import os
import unicodedata
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from pipeline.errors import ConfigError
from pipeline.lock import FOLDER as LOCKS
from pipeline.output import manifest
from pipeline.output.location import ELSEWHERE
from pipeline.output.manifest import DigestReader, Entry
from stages.robot.printable import printable

REPLACED = ".replaced"
"""The suffix of the folder that takes what was in the way."""

SHOWN = 12
"""Largest number of entries that a message lists."""


@dataclass(frozen=True, slots=True)
class Found:
    """What in a folder is not as linkwright left it, by path.

    `carried`: foreign, and no matter. `stopped`: what a build cannot leave where it is, and why; of
    these, what is `stuck` cannot be moved either.
    """

    carried: list[str] = field(default_factory=list)
    stopped: dict[str, str] = field(default_factory=dict)
    stuck: dict[str, str] = field(default_factory=dict)

    def against(self, overwrite: bool) -> dict[str, str]:
        """What stops a build, that may `overwrite` or not: path → why."""
        return self.stuck if overwrite else self.stopped


def look(folder: Path, coming: Iterable[str], reader: DigestReader) -> Found:
    """What a build that writes the `coming` files, and the manifest, would meet in the folder."""
    found = Found()
    if not manifest.is_folder(folder):
        return found
    same = _same(folder)
    coming = list(coming)
    files = {same(path) for path in (*coming, manifest.NAME)}
    above = manifest.parents(files)
    for entry in manifest.others(folder, manifest.ours(folder) or {}, coming, reader):
        path, place = entry.path, folder / entry.path
        if place.is_mount() or (manifest.is_folder(place) and not os.access(place, os.W_OK)):
            found.stopped[path] = found.stuck[path] = "is not linkwright's, and cannot be moved"
        elif not entry.foreign or same(path) in files or same(path) in above:
            found.stopped[path] = why(entry)
        elif place.name != LOCKS and (build := _build_at(place, folder)):
            found.stopped[path] = f"is another build, or holds one ({build.relative_to(folder)})"
        else:
            found.carried.append(path)
    return found


def require_folder(folder: Path) -> None:
    """ConfigError where the place is taken by something else than a folder, or by a sweep."""
    if os.path.lexists(folder) and not manifest.is_folder(folder):
        raise ConfigError(f"{folder} is a file", "output", ELSEWHERE)
    if manifest.is_sweep(folder):
        raise ConfigError(f"{folder} is the folder of a sweep", "output", ELSEWHERE)


def why(entry: Entry) -> str:
    """Why something stops a build that writes a file there."""
    if entry.foreign:
        return "is not linkwright's, and the build writes a file to this path"
    return "was changed since it was built"


def message(folder: Path, stopped: Mapping[str, str]) -> str:
    """What stops a build, as a list."""
    lines = [f"    {printable(path)} {why}" for path, why in stopped.items()]
    more = [f"    and {len(lines) - SHOWN} more"] if len(lines) > SHOWN else []
    return "\n".join([f"{folder} has files that a build must not replace:", *lines[:SHOWN], *more])


def ways_out(folder: Path, found: Found | None = None) -> str:
    """What a user can do about it."""
    if found is not None and found.stuck:
        return "move it elsewhere, or build into another folder with output=FOLDER"
    return (
        f"move it elsewhere, or set overwrite=true, which moves it to {folder.name}{REPLACED}, "
        "or build into another folder with output=FOLDER"
    )


def listed(paths: Iterable[str]) -> str:
    """The first of the paths, and how many more there are."""
    every = [printable(path) for path in paths]
    more = f" and {len(every) - SHOWN} more" if len(every) > SHOWN else ""
    return ", ".join(every[:SHOWN]) + more


def _same(folder: Path) -> Callable[[str], str]:
    """What is the same for two paths that mean one file in this folder."""
    name = manifest.NAME
    if (folder / name).exists() and (folder / name.upper()).exists():
        return lambda path: unicodedata.normalize("NFC", path).casefold()
    return lambda path: path


def _build_at(place: Path, folder: Path) -> Path | None:
    """A build or a sweep that `place`, something in `folder`, is, holds or is a part of."""
    if manifest.is_folder(place):
        return next(manifest.builds_in(place), None)
    within = place.parent
    if within != folder and (
        place.name == manifest.NAME or manifest.is_build(within) or manifest.is_sweep(within)
    ):
        return within
    return None


def visible(paths: Iterable[str]) -> list[str]:
    """The paths without the folders of lock files, which nobody misses."""
    return [path for path in paths if PurePosixPath(path).name != LOCKS]
