"""Reads and writes the manifest of a folder, which tells linkwright's files from others.

`.linkwright.json` lists each file that was written to the folder and the SHA-256 of its bytes. It is
written first, so that linkwright's files can be told from others even after a kill. Folders of
version 0.1 have no manifest: there `report.json` lists the robot's files.
"""

import hashlib
import json
import os
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Literal

from linkwright.pipeline.caching.shared import UNREACHABLE_ERRORS, with_retries
from linkwright.pipeline.lock import FOLDER as LOCKS
from linkwright.pipeline.output.replacing import replace

NAME = ".linkwright.json"
TEMPORARY_NAME = re.compile(rf"{re.escape(NAME)}(\.[0-9a-f]{{8}})?\.tmp")
"""Matches the temporary names of manifests, under which a kill may leave them."""

MARK_KEY = "linkwright-files"
"""The key that identifies a manifest."""

REPORT_KEY = "linkwright-report"
"""The key in `report.json` that identifies the folder of a build."""

SWEEP_KEY = "linkwright-sweep"
"""The key in `summary.json` that identifies the folder of a sweep."""

DOCUMENTS = ("report.json", "report.html", "config.yaml", "build.log")
"""The documents about a build, beside the files of the robot."""

Digests = Mapping[str, str | None]
"""SHA-256 by path below the folder, with forward slashes; None: any content."""

_CHUNK_BYTES = 1 << 20


@dataclass(frozen=True, slots=True)
class Entry:
    """An entry of a folder that linkwright did not write as it is: a file, a link, or a whole folder."""

    path: str
    kind: Literal["foreign", "changed"]
    """foreign: not written by linkwright; changed: written by linkwright, with different content."""

    @property
    def is_foreign(self) -> bool:
        """Tells whether linkwright did not write the entry."""
        return self.kind == "foreign"


class DigestReader:
    """Computes digests of files; an unchanged file is read only once."""

    def __init__(self) -> None:
        self._known: dict[tuple[int, ...], str] = {}

    def is_same(self, file: os.DirEntry[str], digest: str | None) -> bool:
        """Tells whether the entry is a file with this digest, perhaps only after its line ends become line
        feeds."""
        if not file.is_file(follow_symlinks=False):
            return False
        if digest is None:
            return True
        try:
            status = file.stat(follow_symlinks=False)
            key = (status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns)
            if key not in self._known:
                with open(file.path, "rb") as stream:
                    self._known[key] = hashlib.file_digest(stream, "sha256").hexdigest()
            if self._known[key] == digest:
                return True
            with open(file.path, "rb") as stream:
                return _digest_with_line_feeds(stream) == digest
        except OSError as error:
            if error.errno in UNREACHABLE_ERRORS:
                raise
            return False


def _digest_with_line_feeds(file: BinaryIO) -> str:
    """Returns the digest of a file with its line ends converted to line feeds."""
    digest, carry = hashlib.sha256(), b""
    while chunk := file.read(_CHUNK_BYTES):
        chunk = carry + chunk
        carry = chunk[-1:] if chunk.endswith(b"\r") else b""
        digest.update(chunk[: len(chunk) - len(carry)].replace(b"\r\n", b"\n"))
    digest.update(carry)
    return digest.hexdigest()


def write(folder: Path, digests: Digests) -> None:
    """Writes the manifest of a folder atomically, over the remains of a write that was killed. Only a single
    process may write into the folder at a time."""
    staged = folder / f"{NAME}.tmp"
    staged.write_bytes(_text(digests))
    staged.replace(folder / NAME)


def write_shared(folder: Path, digests: Digests) -> None:
    """Writes the manifest of a folder into which several hosts write at once."""
    replace(folder / NAME, _text(digests))


def _text(digests: Digests) -> bytes:
    return (json.dumps({MARK_KEY: 1, "files": dict(sorted(digests.items()))}, indent=1) + "\n").encode()


def write_if_missing(folder: Path, digests: Digests) -> None:
    """Writes the manifest of a folder that has none yet."""
    if not (folder / NAME).is_file():
        write(folder, digests)


def written_files(folder: Path) -> Digests | None:
    """Returns the files that linkwright wrote into the folder; None without a manifest or a report."""
    manifest = _json(folder / NAME)
    if MARK_KEY in manifest and isinstance(manifest.get("files"), dict):
        return _paths(manifest["files"])
    report = _json(folder / "report.json")
    if REPORT_KEY in report:
        outputs = report.get("outputs")
        return {**_paths(outputs if isinstance(outputs, dict) else {}), **dict.fromkeys(DOCUMENTS)}
    return None


def is_build(folder: Path) -> bool:
    """Tells whether the folder is the output of a build, by its `report.json`."""
    return REPORT_KEY in _json(folder / "report.json")


def is_sweep(folder: Path) -> bool:
    """Tells whether the folder is the output of a sweep, by its `summary.json`."""
    return SWEEP_KEY in _json(folder / "summary.json")


def is_foreign(folder: Path) -> bool:
    """Tells whether the folder is not empty, and is the output neither of a build nor of a sweep.

    Locks do not count, and neither do manifests that a killed build left under a temporary name. Raises
    OSError if the folder cannot be read.
    """
    if not folder.is_dir() or written_files(folder) is not None or is_sweep(folder):
        return False
    with os.scandir(folder) as scanned:
        return any(entry.name != LOCKS and not TEMPORARY_NAME.fullmatch(entry.name) for entry in scanned)


def is_folder(path: Path) -> bool:
    """Tells whether the path is a folder, and not a link to a folder."""
    return path.is_dir() and not path.is_symlink()


def foreign_or_changed(
    folder: Path, own: Digests, coming: Iterable[str] = (), reader: DigestReader | None = None
) -> Iterator[Entry]:
    """Yields the foreign and changed files in the folder, by path. A folder without `own` or `coming` files
    is a single entry. Follows no link and opens no foreign file."""
    reader = reader or DigestReader()
    for path, entry in _leaves(folder, parents([*own, *coming])):
        if path in own:
            if not reader.is_same(entry, own[path]):
                yield Entry(path, "changed")
        elif not _is_manifest(path) or not entry.is_file(follow_symlinks=False):
            yield Entry(path, "foreign")


def parents(paths: Iterable[str]) -> set[str]:
    """Returns all parent folders of the paths, without the top folder."""
    folders: set[str] = set()
    for path in paths:
        parent = path.rpartition("/")[0]
        while parent and parent not in folders:
            folders.add(parent)
            parent = parent.rpartition("/")[0]
    return folders


def clear(folder: Path, own: Collection[str], within: Callable[[str], bool] = lambda _: True) -> None:
    """Removes the `own` files and the manifest, then empty folders: those for whose path `within` is true,
    and the top folder. Other files stay."""
    _clear(folder, own, within, "")
    with os.scandir(folder) as scanned:
        manifests = sorted((entry.name for entry in scanned if _is_manifest(entry.name)), reverse=True)
    for name in manifests:
        (folder / name).unlink(missing_ok=True)
    _remove_if_empty(folder)


def clear_but_mark(folder: Path, own: Collection[str], within: Callable[[str], bool]) -> None:
    """Clears as `clear` does, but if other files stay, so does a manifest: the folder is still
    linkwright's."""
    _clear(folder, own, within, "")
    with os.scandir(folder) as scanned:
        has_other_files = any(not _is_manifest(entry.name) for entry in scanned)
    if not has_other_files:
        clear(folder, ())
    elif written_files(folder) != {}:
        write(folder, {})


def _clear(folder: Path, own: Collection[str], within: Callable[[str], bool], base: str) -> None:
    with os.scandir(folder) as scanned:
        entries = sorted(scanned, key=lambda entry: entry.name)
    for entry in entries:
        path = f"{base}{entry.name}"
        if entry.is_dir(follow_symlinks=False):
            if within(path):
                _clear(Path(entry.path), own, within, f"{path}/")
                _remove_if_empty(Path(entry.path))
        elif path in own:
            os.unlink(entry.path)  # noqa: PTH108


def _remove_if_empty(folder: Path) -> None:
    with os.scandir(folder) as scanned:
        is_empty = next(scanned, None) is None
    if is_empty:
        folder.rmdir()


def _leaves(folder: Path, inside: set[str], base: str = "") -> Iterator[tuple[str, os.DirEntry[str]]]:
    """Yields the entries of the folder, with the content of the subfolders that are in `inside`."""
    with os.scandir(folder) as scanned:
        entries = sorted(scanned, key=lambda entry: entry.name)
    for entry in entries:
        path = f"{base}{entry.name}"
        if path in inside and entry.is_dir(follow_symlinks=False):
            yield from _leaves(Path(entry.path), inside, f"{path}/")
        else:
            yield path, entry


def builds_in(folder: Path) -> Iterator[Path]:
    """Yields the folders of builds and sweeps at or below a folder, including unfinished ones."""
    for top, subfolders, files in os.walk(folder):
        path = Path(top)
        if NAME in files or is_build(path) or is_sweep(path):
            subfolders.clear()
            yield path
        subfolders[:] = sorted(name for name in subfolders if name != LOCKS)


def _is_manifest(name: str) -> bool:
    return name == NAME or TEMPORARY_NAME.fullmatch(name) is not None


def _json(file: Path) -> dict[str, Any]:
    """Returns the mapping in a JSON file; {} if there is none. Raises OSError if the file system is out of
    reach."""
    try:
        # A pipe or a device of that name would block.
        data = with_retries(lambda: file.read_bytes() if file.is_file() and not file.is_symlink() else b"")
        content = json.loads(data)
    except OSError as error:
        if error.errno in UNREACHABLE_ERRORS:
            raise
        return {}
    except (ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}


def _paths(files: Mapping[str, Any]) -> dict[str, str | None]:
    """Returns the entries of a manifest whose paths are below the folder; a user may have changed the
    manifest."""
    paths = {}
    for path, digest in files.items():
        if not {"", ".", ".."}.intersection(path.split("/")):
            paths[path] = digest if isinstance(digest, str) else None
    return paths
