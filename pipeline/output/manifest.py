"""The manifest of a folder: which files in it are linkwright's.

`.linkwright.json` lists each file that was written to the folder and the SHA-256 of its bytes. It is
written first, so that after a kill linkwright's files can be distinguished from other files. Folders of
version 0.1 have no manifest: there `report.json` lists the robot's files.
"""

import hashlib
import json
import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Literal

from linkwright.pipeline.lock import FOLDER as LOCKS

NAME = ".linkwright.json"
STAGED = f"{NAME}.tmp"

MARK = "linkwright-files"
"""The key that identifies a manifest."""

REPORT = "linkwright-report"
"""The key in `report.json` that identifies the folder of a build."""

SWEEP = "linkwright-sweep"
"""The key in `summary.json` that identifies the folder of a sweep."""

DOCUMENTS = ("report.json", "report.html", "config.yaml", "build.log")
"""The documents about a build, beside the files of the robot."""

Digests = Mapping[str, str | None]
"""SHA-256 by path below the folder, with forward slashes; None: any content."""

_CHUNK = 1 << 20


@dataclass(frozen=True, slots=True)
class Entry:
    """An entry of a folder that linkwright did not write: a file, a link, or a whole folder.

    `kind`: foreign, or changed (the path of a file of linkwright, with other content).
    """

    path: str
    kind: Literal["foreign", "changed"]

    @property
    def foreign(self) -> bool:
        return self.kind == "foreign"


class DigestReader:
    """Digests of files; an unchanged file is read once."""

    def __init__(self) -> None:
        self._known: dict[tuple[int, ...], str] = {}

    def is_same(self, file: os.DirEntry[str], digest: str | None) -> bool:
        """Whether the entry is a file with this digest, also after a change of its line ends."""
        if not file.is_file(follow_symlinks=False):
            return False
        if digest is None:
            return True
        try:
            status = file.stat(follow_symlinks=False)
            key = (status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns)
            if key not in self._known:
                with open(file.path, "rb") as opened:
                    self._known[key] = hashlib.file_digest(opened, "sha256").hexdigest()
            if self._known[key] == digest:
                return True
            with open(file.path, "rb") as opened:
                return _with_plain_line_ends(opened) == digest
        except OSError:
            return False


def _with_plain_line_ends(file: BinaryIO) -> str:
    """The digest of a file with its line ends converted to line feeds."""
    digest, kept = hashlib.sha256(), b""
    while chunk := file.read(_CHUNK):
        chunk = kept + chunk
        kept = chunk[-1:] if chunk.endswith(b"\r") else b""
        digest.update(chunk[: len(chunk) - len(kept)].replace(b"\r\n", b"\n"))
    digest.update(kept)
    return digest.hexdigest()


def write(folder: Path, digests: Digests) -> None:
    """Writes the manifest of a folder atomically."""
    staged = folder / STAGED
    staged.write_text(json.dumps({MARK: 1, "files": dict(sorted(digests.items()))}, indent=1) + "\n")
    staged.replace(folder / NAME)


def keep(folder: Path, digests: Digests) -> None:
    """Writes the manifest of a folder without a manifest."""
    if not (folder / NAME).is_file():
        write(folder, digests)


def ours(folder: Path) -> Digests | None:
    """The files that linkwright wrote into the folder; None without a manifest or a report."""
    manifest = _json(folder / NAME)
    if MARK in manifest and isinstance(manifest.get("files"), dict):
        return _paths(manifest["files"])
    report = _json(folder / "report.json")
    if REPORT in report:
        outputs = report.get("outputs")
        return {**_paths(outputs if isinstance(outputs, dict) else {}), **dict.fromkeys(DOCUMENTS)}
    return None


def is_build(folder: Path) -> bool:
    """Whether the folder is the output of a build, by its `report.json`."""
    return REPORT in _json(folder / "report.json")


def is_sweep(folder: Path) -> bool:
    """Whether the folder is the output of a sweep, by its `summary.json`."""
    return SWEEP in _json(folder / "summary.json")


def is_of_others(folder: Path) -> bool:
    """Whether the folder holds anything, and is neither the output of a build nor that of a sweep.

    OSError where it cannot be read. What builds may leave in a folder does not count: locks, and a manifest
    that a kill kept from its name.
    """
    if not folder.is_dir() or ours(folder) is not None or is_sweep(folder):
        return False
    with os.scandir(folder) as found:
        return any(entry.name not in (LOCKS, STAGED) for entry in found)


def is_folder(path: Path) -> bool:
    """Whether the path is a folder, and not a link to a folder."""
    return path.is_dir() and not path.is_symlink()


def others(
    folder: Path, own: Digests, coming: Iterable[str] = (), reader: DigestReader | None = None
) -> Iterator[Entry]:
    """The foreign and changed files in the folder, by path. A folder without `own` or `coming` files is a
    single entry. Follows no link and opens no foreign file."""
    reader = reader or DigestReader()
    for path, entry in _leaves(folder, parents([*own, *coming])):
        if path in own:
            if not reader.is_same(entry, own[path]):
                yield Entry(path, "changed")
        elif path not in (NAME, STAGED) or not entry.is_file(follow_symlinks=False):
            yield Entry(path, "foreign")


def parents(paths: Iterable[str]) -> set[str]:
    """All parent folders of the paths, without the top folder."""
    found: set[str] = set()
    for path in paths:
        parent = path.rpartition("/")[0]
        while parent and parent not in found:
            found.add(parent)
            parent = parent.rpartition("/")[0]
    return found


def clear(folder: Path, own: Collection[str], within: Callable[[str], bool] = lambda _: True) -> None:
    """Removes the `own` files and the manifest, then empty folders (those `within`, and the top folder).
    Other files stay."""
    _clear(folder, own, within, "")
    for name in (STAGED, NAME):
        (folder / name).unlink(missing_ok=True)
    _remove_if_empty(folder)


def clear_but_mark(folder: Path, own: Collection[str], within: Callable[[str], bool]) -> None:
    """As `clear`, but where other files stay, so does a manifest: the folder is still linkwright's."""
    _clear(folder, own, within, "")
    with os.scandir(folder) as found:
        others = any(entry.name not in (STAGED, NAME) for entry in found)
    if not others:
        clear(folder, ())
    elif ours(folder) != {}:
        write(folder, {})


def _clear(folder: Path, own: Collection[str], within: Callable[[str], bool], base: str) -> None:
    with os.scandir(folder) as found:
        entries = sorted(found, key=lambda entry: entry.name)
    for entry in entries:
        path = f"{base}{entry.name}"
        if entry.is_dir(follow_symlinks=False):
            if within(path):
                _clear(Path(entry.path), own, within, f"{path}/")
                _remove_if_empty(Path(entry.path))
        elif path in own:
            os.unlink(entry.path)  # noqa: PTH108


def _remove_if_empty(folder: Path) -> None:
    with os.scandir(folder) as found:
        empty = next(found, None) is None
    if empty:
        folder.rmdir()


def _leaves(folder: Path, inside: set[str], base: str = "") -> Iterator[tuple[str, os.DirEntry[str]]]:
    """The entries of the folder, with the content of the subfolders that are in `inside`."""
    with os.scandir(folder) as found:
        entries = sorted(found, key=lambda entry: entry.name)
    for entry in entries:
        path = f"{base}{entry.name}"
        if path in inside and entry.is_dir(follow_symlinks=False):
            yield from _leaves(Path(entry.path), inside, f"{path}/")
        else:
            yield path, entry


def builds_in(folder: Path) -> Iterator[Path]:
    """Builds and sweeps at the folder or below it, also those that are being written."""
    for top, below, files in os.walk(folder):
        place = Path(top)
        if NAME in files or is_build(place) or is_sweep(place):
            below.clear()
            yield place
        below[:] = sorted(name for name in below if name != LOCKS)


def _json(file: Path) -> dict[str, Any]:
    """The mapping in a JSON file; {} without such a file."""
    try:
        # A pipe or a device of that name would block.
        found = json.loads(file.read_bytes()) if file.is_file() and not file.is_symlink() else None
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def _paths(files: Mapping[str, Any]) -> dict[str, str | None]:
    """The entries of a manifest whose paths are below the folder; a user may have changed the manifest."""
    found = {}
    for path, digest in files.items():
        if not {"", ".", ".."}.intersection(path.split("/")):
            found[path] = digest if isinstance(digest, str) else None
    return found
