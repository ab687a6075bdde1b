"""Files in an output folder that a build must not replace: it keeps them, or they stop the build."""

import os
import unicodedata
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.lock import FOLDER as LOCKS
from linkwright.pipeline.output import manifest
from linkwright.pipeline.output.location import ELSEWHERE
from linkwright.pipeline.output.manifest import DigestReader, Entry
from linkwright.stages.robot.text.printable import printable

REPLACED = ".replaced"
"""The suffix of the folder for files that were in the way."""

SHOWN = 12
"""Largest number of entries that a message lists."""


@dataclass(frozen=True, slots=True)
class Found:
    """The files in a folder that linkwright did not write, or that were changed, by path.

    `carried`: foreign files that the build keeps. `stopped`: files that stop the build, each with the
    reason; of these, the `stuck` files cannot be moved either.
    """

    carried: list[str] = field(default_factory=list)
    stopped: dict[str, str] = field(default_factory=dict)
    stuck: dict[str, str] = field(default_factory=dict)

    def against(self, overwrite: bool) -> dict[str, str]:
        """The files that stop a build with or without `overwrite`: path → reason."""
        return self.stuck if overwrite else self.stopped


def look(folder: Path, coming: Iterable[str], reader: DigestReader) -> Found:
    """Compares the folder with the `coming` files of a build and its manifest."""
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
    """ConfigError where the path is a file, the folder of a sweep, or a folder of others."""
    if os.path.lexists(folder) and not manifest.is_folder(folder):
        raise ConfigError(f"{folder} is a file", "output", ELSEWHERE)
    if manifest.is_sweep(folder):
        raise ConfigError(f"{folder} is the folder of a sweep", "output", ELSEWHERE)
    if manifest.is_of_others(folder):
        raise foreign(folder)


def foreign(folder: Path) -> ConfigError:
    """The refusal of a folder that is not empty and that no build made."""
    msg = f"{folder} is not empty, and no build made it: a build replaces its output folder"
    hint = "name a new or an empty folder, such as output=outputs/arm, or move what is in it elsewhere"
    return ConfigError(msg, "output", hint)


def why(entry: Entry) -> str:
    """The reason why an entry stops a build that writes a file to its path."""
    if entry.foreign:
        return "is not linkwright's, and the build writes a file to this path"
    return "was changed since it was built"


def message(folder: Path, stopped: Mapping[str, str]) -> str:
    """The message with a list of the files that stop a build."""
    lines = [f"    {printable(path)} {why}" for path, why in stopped.items()]
    more = [f"    and {len(lines) - SHOWN} more"] if len(lines) > SHOWN else []
    return "\n".join([f"{folder} has files that a build must not replace:", *lines[:SHOWN], *more])


def ways_out(folder: Path, found: Found | None = None) -> str:
    """The hint about files that stop a build."""
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
    """A function that gives equal results for two paths of one file in this folder."""
    name = manifest.NAME
    if (folder / name).exists() and (folder / name.upper()).exists():
        return lambda path: unicodedata.normalize("NFC", path).casefold()
    return lambda path: path


def _build_at(place: Path, folder: Path) -> Path | None:
    """The build or sweep that the entry `place` of `folder` is, contains or belongs to."""
    if manifest.is_folder(place):
        return next(manifest.builds_in(place), None)
    within = place.parent
    if within != folder and (
        place.name == manifest.NAME or manifest.is_build(within) or manifest.is_sweep(within)
    ):
        return within
    return None


def visible(paths: Iterable[str]) -> list[str]:
    """The paths without the folders of lock files."""
    return [path for path in paths if PurePosixPath(path).name != LOCKS]
