"""Blobs by digest and records by key, on plain files that any number of processes share.

    cas/ab/<sha256>     blobs, mode 0444
    ac/ab/<key>.json    records, which name blobs
    locks/<key>.lock    locks against doing the same work twice
    tmp/                files that are being written

Every file is written under `tmp/` and published by `os.replace`, blobs before the record that names
them; so a kill at any moment leaves only complete files. Locks only save work: without working locks
(some network filesystems) work may be done twice, with the same result.
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

from linkwright.pipeline.caching import disk_space
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.errors import FULL, CacheError, OutputError, reason
from linkwright.pipeline.lock import acquired

STALE = 24 * 3600.0
"""Age [s] above which a file in `tmp/` must come from a killed process."""


def write_tree(folder: Path, files: Mapping[str, bytes]) -> None:
    """Writes files by relative path into a folder, and creates the folder if needed."""
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
    """The files under `root`, which is created if needed; CacheError where it cannot be written."""

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
        """Stores a blob; returns its digest."""
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
        """The blob, or None where it is missing or corrupt."""
        try:
            data = self._blob(digest).read_bytes()
        except OSError:
            return None
        return data if sha256(data) == digest else None

    def size(self, digest: str) -> int:
        """The length of a blob [bytes]; -1 where it is missing."""
        try:
            return self._blob(digest).stat().st_size
        except OSError:
            return -1

    def intact(self, digest: str, size: int) -> bool:
        """Whether the blob exists, is `size` bytes long and intact (read once in each run)."""
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
        """The record under `key`, or None where it is missing or not JSON."""
        path = self._record(key)
        try:
            record = json.loads(path.read_bytes())
        except (OSError, RecursionError, ValueError):
            return None
        with contextlib.suppress(OSError):
            os.utime(path)
        return record if isinstance(record, dict) else None

    def publish(self, key: str, record: dict[str, Any]) -> None:
        """Stores a record; the blobs that it names must already be stored."""
        with self._named("written"):
            self._write(self._record(key), json.dumps(record, indent=1).encode())

    @contextlib.contextmanager
    def lock(self, key: str, waiting: Callable[[], None] = lambda: None) -> Iterator[None]:
        """Acquires the lock of `key`; a thread may own the locks of several keys.

        `waiting` is called once if another process keeps the lock for long.
        """
        with contextlib.ExitStack() as stack:
            # Without locks (some network filesystems) the work may be done twice, with the same result.
            with contextlib.suppress(OSError):
                stack.enter_context(acquired(self._locks / f"{key}.lock", waiting))
            yield

    @contextlib.contextmanager
    def scratch(self, files: Mapping[str, bytes] | None = None) -> Iterator[Path]:
        """A private folder with `files`, removed at the end."""
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
        """Inside, `size` bytes of the disk are reserved; CacheError where the space is missing."""
        with contextlib.ExitStack() as stack:
            with self._named("written"):
                stack.enter_context(disk_space.reserved(self._tmp, size))
            yield

    def _blob(self, digest: str) -> Path:
        return self._cas / digest[:2] / digest

    def _record(self, key: str) -> Path:
        return self._ac / key[:2] / f"{key}.json"

    def _write(self, path: Path, data: bytes, mode: int = 0o644) -> Path:
        """Writes a file atomically."""
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
        """Removes the files of killed processes from `tmp/`."""
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
