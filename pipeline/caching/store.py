"""Stores blobs by digest and records by key, as plain files that any number of processes share.

    cas/ab/<sha256>     blobs, mode 0444
    ac/ab/<key>.json    records, which name blobs
    locks/<key>.lock    locks against doing the same work twice
    tmp/                files that are being written

Every file is written under `tmp/` and published by `os.replace`, blobs before the record that names them; so
a kill at any moment leaves only complete files. Locks only save work: without working locks (some network
filesystems) work may be done twice, with the same result. A file system that is out of reach is an error,
never a miss: making a missing result again may cost API calls.
"""

import contextlib
import hashlib
import json
import os
import secrets
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import Any, TypeVar

from linkwright.pipeline.caching import disk_space
from linkwright.pipeline.caching.shared import UNREACHABLE_ERRORS, now, with_retries
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.errors import DISK_FULL_TEXTS, CacheError, OutputError, reason
from linkwright.pipeline.lock import acquired

MAX_TEMPORARY_AGE = 24 * 3600.0
"""Age [s] above which a file in `tmp/` counts as left by a killed process."""


T = TypeVar("T")


def digest_of(path: Path) -> str:
    """Returns the SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def write_tree(folder: Path, files: Mapping[str, bytes]) -> None:
    """Writes files by relative path into a folder, and creates the folder if needed."""
    folder.mkdir(parents=True, exist_ok=True)
    created = {folder}
    for name in sorted(files):
        path = PurePosixPath(name)
        if path.is_absolute() or ".." in path.parts:
            msg = f"{name!r} is not a path inside a build"
            raise OutputError(msg, where=str(folder), hint="clear the cache folder and build again")
        target = folder / path
        if target.parent not in created:
            target.parent.mkdir(parents=True, exist_ok=True)
            created.add(target.parent)
        target.write_bytes(files[name])


class Store:
    """A store in the folder `root`, which is created if needed; raises CacheError if it cannot be written."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self._cas, self._ac, self._tmp = root / "cas", root / "ac", root / "tmp"
        self._locks = root / "locks"
        self._intact: set[str] = set()
        with self._cache_errors("written"):
            for folder in (self._cas, self._ac, self._tmp, self._locks):
                folder.mkdir(parents=True, exist_ok=True)
            self._write(self._tmp / f"probe-{secrets.token_hex(4)}", b"").unlink(missing_ok=True)
        self._remove_leftovers()

    def put(self, data: bytes) -> str:
        """Stores a blob; returns its digest."""
        digest = sha256(data)
        path = self._blob(digest)
        if self.get(digest) is not None:
            # A garbage collection that runs now must not take an old blob that is about to be named again.
            with contextlib.suppress(OSError):
                os.utime(path)
            return digest
        with self._cache_errors("written"):
            self._write(path, data, mode=0o444)
        return digest

    def get(self, digest: str) -> bytes | None:
        """Returns the blob, or None if it is missing or corrupt."""
        data = self._read(self._blob(digest).read_bytes)
        return data if data is not None and sha256(data) == digest else None

    def size(self, digest: str) -> int:
        """Returns the length of a blob [bytes]; -1 if it is missing."""
        status = self._read(self._blob(digest).stat)
        return -1 if status is None else status.st_size

    def intact(self, digest: str, size: int) -> bool:
        """Tells whether the blob exists, is `size` bytes long and intact; reads it once in each run."""
        if self.size(digest) != size:
            return False
        if digest not in self._intact:
            if self._read(lambda: digest_of(self._blob(digest))) != digest:
                return False
            self._intact.add(digest)
        return True

    def record(self, key: str) -> dict[str, Any] | None:
        """Returns the record under `key`, or None if it is missing or not JSON."""
        path = self._record(key)
        try:
            record = json.loads(self._read(path.read_bytes) or b"")
        except (RecursionError, ValueError):
            return None
        with contextlib.suppress(OSError):
            os.utime(path)
        return record if isinstance(record, dict) else None

    def publish(self, key: str, record: dict[str, Any]) -> None:
        """Stores a record; the blobs that it names must already be stored."""
        with self._cache_errors("written"):
            self._write(self._record(key), json.dumps(record, indent=1).encode())

    @contextlib.contextmanager
    def lock(self, key: str, on_wait: Callable[[], None] = lambda: None) -> Iterator[None]:
        """Acquires the lock of `key`; a thread may own the locks of several keys.

        `on_wait` is called once if another process keeps the lock for long.
        """
        with contextlib.ExitStack() as stack:
            # Without locks (some network filesystems) the work may be done twice, with the same result.
            with contextlib.suppress(OSError):
                stack.enter_context(acquired(self._locks / f"{key}.lock", on_wait))
            yield

    @contextlib.contextmanager
    def scratch(self, files: Mapping[str, bytes] | None = None) -> Iterator[Path]:
        """Creates a private folder with `files`, and removes it at the end."""
        with self._cache_errors("written"):
            folder = Path(tempfile.mkdtemp(prefix="scratch-", dir=self._tmp))
        try:
            with self._cache_errors("written"):
                write_tree(folder, files or {})
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    @contextlib.contextmanager
    def room(self, size: int) -> Iterator[None]:
        """Reserves `size` bytes of the disk while the block runs; raises CacheError if there is no space."""
        with contextlib.ExitStack() as stack:
            with self._cache_errors("written"):
                stack.enter_context(disk_space.reserved(self._tmp, size))
            yield

    def _blob(self, digest: str) -> Path:
        return self._cas / digest[:2] / digest

    def _record(self, key: str) -> Path:
        return self._ac / key[:2] / f"{key}.json"

    def _read(self, act: Callable[[], T]) -> T | None:
        """Returns the result of `act`, or None if its file is missing. Raises CacheError if the file system
        is out of reach."""
        with self._cache_errors("read"):
            try:
                return with_retries(act)
            except OSError as error:
                if error.errno in UNREACHABLE_ERRORS:
                    raise
                return None

    def _write(self, path: Path, data: bytes, mode: int = 0o644) -> Path:
        """Writes a file atomically."""
        try:
            return with_retries(lambda: self._write_once(path, data, mode))
        except FileNotFoundError:
            # Either a server's reply to the rename was lost, or another host cleaned up.
            return with_retries(lambda: self._write_once(path, data, mode))

    def _write_once(self, path: Path, data: bytes, mode: int) -> Path:
        handle, name = tempfile.mkstemp(dir=self._tmp)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
            os.chmod(name, mode)  # noqa: PTH101
            path.parent.mkdir(exist_ok=True)
            os.replace(name, path)  # noqa: PTH105
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(name)  # noqa: PTH108
            raise
        return path

    def _remove_leftovers(self) -> None:
        """Removes the files of killed processes from `tmp/`."""
        with contextlib.suppress(OSError):
            limit = now(self._tmp) - MAX_TEMPORARY_AGE
            for entry in self._tmp.iterdir():
                with contextlib.suppress(OSError):
                    if entry.stat().st_mtime > limit:
                        continue
                    if entry.is_dir():
                        shutil.rmtree(entry, ignore_errors=True)
                    else:
                        entry.unlink()

    @contextlib.contextmanager
    def _cache_errors(self, participle: str) -> Iterator[None]:
        """Turns an OSError into a CacheError that names the folder; `participle`: "read" or "written"."""
        try:
            yield
        except OSError as error:
            msg = f"the cache folder cannot be {participle}: {reason(error)}"
            hint = "choose another with cache.dir=FOLDER or LINKWRIGHT_CACHE, or build with cache.mode=bypass"
            if error.errno in UNREACHABLE_ERRORS:
                hint = "run it again when it is back; linkwright cache verify finds what a disk has lost"
            if error.errno in DISK_FULL_TEXTS:
                hint = (
                    "free space there, for example with linkwright cache gc --max-size 1G, or choose another "
                    "folder with cache.dir=FOLDER or LINKWRIGHT_CACHE"
                )
            raise CacheError(msg, where=str(self.root), hint=hint) from error
