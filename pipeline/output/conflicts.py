"""Finds files in an output folder that a build must not replace: it keeps them, or they stop the build."""

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

MAX_LISTED = 12
"""Largest number of entries that a message lists."""


@dataclass(frozen=True, slots=True)
class Conflicts:
    """The files in a folder that linkwright did not write, or that were changed, by path."""

    kept_paths: list[str] = field(default_factory=list)
    """Foreign files that the build keeps."""

    blockers: dict[str, str] = field(default_factory=dict)
    """Files that stop the build: path → reason."""

    immovable_blockers: dict[str, str] = field(default_factory=dict)
    """The files among `blockers` that cannot be moved either: path → reason."""

    def against(self, overwrite: bool) -> dict[str, str]:
        """Returns the files that stop a build with or without `overwrite`: path → reason."""
        return self.immovable_blockers if overwrite else self.blockers


def find_conflicts(folder: Path, coming: Iterable[str], reader: DigestReader) -> Conflicts:
    """Compares the folder with the `coming` files of a build and its manifest."""
    conflicts = Conflicts()
    if not manifest.is_folder(folder):
        return conflicts
    key = _path_key(folder)
    coming = list(coming)
    files = {key(path) for path in (*coming, manifest.NAME)}
    parent_folders = manifest.parents(files)
    for entry in manifest.foreign_or_changed(folder, manifest.written_files(folder) or {}, coming, reader):
        path, place = entry.path, folder / entry.path
        if place.is_mount() or (manifest.is_folder(place) and not os.access(place, os.W_OK)):
            conflicts.blockers[path] = conflicts.immovable_blockers[path] = (
                "is not linkwright's, and cannot be moved"
            )
        elif not entry.is_foreign or key(path) in files or key(path) in parent_folders:
            conflicts.blockers[path] = block_reason(entry)
        elif place.name != LOCKS and (build := _build_at(place, folder)):
            conflicts.blockers[path] = f"is another build, or holds one ({build.relative_to(folder)})"
        else:
            conflicts.kept_paths.append(path)
    return conflicts


def require_folder(folder: Path) -> None:
    """Raises ConfigError if the path is a file, the folder of a sweep, or a folder that no build made."""
    if os.path.lexists(folder) and not manifest.is_folder(folder):
        raise ConfigError(f"{folder} is a file", "output", ELSEWHERE)
    if manifest.is_sweep(folder):
        raise ConfigError(f"{folder} is the folder of a sweep", "output", ELSEWHERE)
    if manifest.is_foreign(folder):
        raise foreign_folder_error(folder)


def foreign_folder_error(folder: Path) -> ConfigError:
    """Returns the error about a folder that is not empty and that no build made."""
    msg = f"{folder} is not empty, and no build made it: a build replaces its output folder"
    hint = "name a new or an empty folder, such as output=outputs/arm, or move what is in it elsewhere"
    return ConfigError(msg, "output", hint)


def block_reason(entry: Entry) -> str:
    """Returns the reason why an entry stops a build that writes a file to its path."""
    if entry.is_foreign:
        return "is not linkwright's, and the build writes a file to this path"
    return "was changed since it was built"


def message(folder: Path, blockers: Mapping[str, str]) -> str:
    """Returns a message that lists the files that stop a build."""
    lines = [f"    {printable(path)} {reason}" for path, reason in blockers.items()]
    remainder = [f"    and {len(lines) - MAX_LISTED} more"] if len(lines) > MAX_LISTED else []
    return "\n".join([f"{folder} has files that a build must not replace:", *lines[:MAX_LISTED], *remainder])


def conflict_hint(folder: Path, conflicts: Conflicts | None = None) -> str:
    """Returns the hint about files that stop a build."""
    if conflicts is not None and conflicts.immovable_blockers:
        return "move it elsewhere, or build into another folder with output=FOLDER"
    return (
        f"move it elsewhere, or set overwrite=true, which moves it to {folder.name}{REPLACED}, "
        "or build into another folder with output=FOLDER"
    )


def path_list(paths: Iterable[str]) -> str:
    """Returns a text with the first paths, and the number of further paths."""
    texts = [printable(path) for path in paths]
    remainder = f" and {len(texts) - MAX_LISTED} more" if len(texts) > MAX_LISTED else ""
    return ", ".join(texts[:MAX_LISTED]) + remainder


def _path_key(folder: Path) -> Callable[[str], str]:
    """Returns a function with equal results for two paths of the same file in this folder."""
    # A file system without cases finds the manifest under its upper-case name, too.
    name = manifest.NAME
    if (folder / name).exists() and (folder / name.upper()).exists():
        return lambda path: unicodedata.normalize("NFC", path).casefold()
    return lambda path: path


def _build_at(place: Path, folder: Path) -> Path | None:
    """Returns the folder of a build or sweep at, below or just above `place`, an entry of `folder`; else
    None."""
    if manifest.is_folder(place):
        return next(manifest.builds_in(place), None)
    parent = place.parent
    if parent != folder and (
        place.name == manifest.NAME or manifest.is_build(parent) or manifest.is_sweep(parent)
    ):
        return parent
    return None


def without_locks(paths: Iterable[str]) -> list[str]:
    """Returns the paths without the folders of lock files."""
    return [path for path in paths if PurePosixPath(path).name != LOCKS]
