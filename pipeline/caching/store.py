"""Blobs by digest and records by key, on plain files that any number of processes share.

    cas/ab/<sha256>     blobs, mode 0444
    ac/ab/<key>.json    records, which name blobs
    locks/<key>.lock    so that work is not done twice
    tmp/                what is being written

Every file is written under `tmp/` and published by `os.replace`, blobs before the record that names
them; so a kill at any moment leaves whole files only. Locks save work and carry no truth: where they
do not function (some network filesystems), work is done twice and the result is the same.
"""

import contextlib
import hashlib
import json
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from pipeline import disk_space
from pipeline.digest import sha256
from pipeline.errors import FULL, CacheError, OutputError, reason
from pipeline.lock import held

STALE = 24 * 3600.0
"""Age [s] beyond which a file in `tmp/` was left by a process that was killed."""


def write_tree(folder: Path, files: Mapping[str, bytes]) -> None:
    """Writes files by relative path into a folder, which is made if need be."""
    folder.mkdir(parents=True, exist_ok=True)
    made = {folder}
    for name in sorted(files):
        path = PurePosixPath(name)
        if path.is_absolute() or ".." in path.parts:
            msg = f"{name!r} is no path inside a build"
            raise OutputError(msg, where=str(folder), hint="clear the cache folder and build again")
        target = folder / path
        if target.parent not in made:
            target.parent.mkdir(parents=True, exist_ok=True)
            made.add(target.parent)
        target.write_bytes(files[name])


class Store:
    """The files under `root`, which is made if need be; CacheError where it cannot be written."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self._cas, self._ac, self._tmp = root / "cas", root / "ac", root / "tmp"
        self._locks = root / "locks"
        self._intact: set[str] = set()
        with self._named("written"):
            for folder in (self._cas, self._ac, self._tmp, self._locks):
                folder.mkdir(parents=True, exist_ok=True)
            self._write(self._tmp / f"probe-{os.getpid()}", b"").unlink(missing_ok=True)
        self._sweep()

    def put(self, data: bytes) -> str:
        """Keeps a blob; its digest."""
        digest = sha256(data)
        path = self._blob(digest)
        if self.get(digest) is not None:
            # A garbage collection that runs now must not take an old blob that is about to be named again.
            with contextlib.suppress(OSError):
                os.utime(path)
            return digest
        with self._named("written"):
            self._write(path, data, mode=0o444)
        return digest

    def get(self, digest: str) -> bytes | None:
        """The blob, or None where it is missing or its bytes are not those of its digest."""
        try:
            data = self._blob(digest).read_bytes()
        except OSError:
            return None
        return data if sha256(data) == digest else None

    def size(self, digest: str) -> int:
        """The length of a blob that is there [bytes]; -1, which fits none, where it is missing."""
        try:
            return self._blob(digest).stat().st_size
        except OSError:
            return -1

    def intact(self, digest: str, size: int) -> bool:
        """Whether the blob is there, `size` bytes long and unharmed (its bytes are read once a run)."""
        try:
            if self._blob(digest).stat().st_size != size:
                return False
            if digest not in self._intact:
                with self._blob(digest).open("rb") as file:
                    if hashlib.file_digest(file, "sha256").hexdigest() != digest:
                        return False
                self._intact.add(digest)
        except OSError:
            return False
        return True

    def record(self, key: str) -> dict[str, Any] | None:
        """The record under `key`, or None where there is none or it is not JSON."""
        path = self._record(key)
        try:
            record = json.loads(path.read_bytes())
        except (OSError, RecursionError, ValueError):
            return None
        with contextlib.suppress(OSError):
            os.utime(path)
        return record if isinstance(record, dict) else None

    def publish(self, key: str, record: dict[str, Any]) -> None:
        """Files a record; the blobs that it names must be there already."""
        with self._named("written"):
            self._write(self._record(key), json.dumps(record, indent=1).encode())

    @contextlib.contextmanager
    def lock(self, key: str, waiting: Callable[[], None] = lambda: None) -> Iterator[None]:
        """Holds the one lock of `key`; holding those of other keys meanwhile is safe.

        `waiting` is called once if another process holds it for long.
        """
        with contextlib.ExitStack() as stack:
            # No locks here (some network filesystems): the work may be done twice, to the same end.
            with contextlib.suppress(OSError):
                stack.enter_context(held(self._locks / f"{key}.lock", waiting))
            yield

    @contextlib.contextmanager
    def scratch(self, files: Mapping[str, bytes] | None = None) -> Iterator[Path]:
        """A folder of one's own that holds `files`, removed at the end."""
        with self._named("written"):
            folder = Path(tempfile.mkdtemp(prefix="scratch-", dir=self._tmp))
        try:
            with self._named("written"):
                write_tree(folder, files or {})
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    @contextlib.contextmanager
    def room(self, size: int) -> Iterator[None]:
        """Inside, so many bytes of the disk are taken; CacheError where there are not as many."""
        with contextlib.ExitStack() as stack:
            with self._named("written"):
                stack.enter_context(disk_space.taken(self._tmp, size))
            yield

    def _blob(self, digest: str) -> Path:
        return self._cas / digest[:2] / digest

    def _record(self, key: str) -> Path:
        return self._ac / key[:2] / f"{key}.json"

    def _write(self, path: Path, data: bytes, mode: int = 0o644) -> Path:
        """Writes the whole file or nothing."""
        handle, name = tempfile.mkstemp(dir=self._tmp)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
            os.chmod(name, mode)  # noqa: PTH101
            try:
                os.replace(name, path)  # noqa: PTH105
            except FileNotFoundError:
                path.parent.mkdir(exist_ok=True)
                os.replace(name, path)  # noqa: PTH105
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(name)  # noqa: PTH108
            raise
        return path

    def _sweep(self) -> None:
        """Removes what killed processes left in `tmp/`."""
        with contextlib.suppress(OSError):
            for entry in self._tmp.iterdir():
                with contextlib.suppress(OSError):
                    if time.time() - entry.stat().st_mtime < STALE:
                        continue
                    if entry.is_dir():
                        shutil.rmtree(entry, ignore_errors=True)
                    else:
                        entry.unlink()

    @contextlib.contextmanager
    def _named(self, done: str) -> Iterator[None]:
        """An OSError becomes a CacheError that names the folder."""
        try:
            yield
        except OSError as error:
            msg = f"the cache folder cannot be {done}: {reason(error)}"
            hint = "choose another with cache.dir=FOLDER or LINKWRIGHT_CACHE, or build with cache.mode=bypass"
            if error.errno in FULL:
                hint = (
                    "free space there, for example with linkwright cache gc --max-size 1G, or choose another "
                    "folder with cache.dir=FOLDER or LINKWRIGHT_CACHE"
                )
            raise CacheError(msg, where=str(self.root), hint=hint) from error
