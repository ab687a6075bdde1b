"""Maintenance of the cache folder: its content, freeing space, and finding corrupt files.

Safe while builds use the folder: recently used files stay, and reading a record or storing a blob again
updates its time. At worst a result is made or fetched twice.
"""

import contextlib
import hashlib
import json
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from linkwright.pipeline.errors import CacheError
from linkwright.pipeline.lock import drop

SPARED = 3600.0
"""Age [s] below which no file is removed: a running build may use it."""

PAID = ("reply", "fact")
"""Records that cost API calls to make again: dropped last."""


@dataclass(frozen=True, slots=True)
class Record:
    """A record: its file and length [bytes], when it was last used, and the blobs that it names."""

    path: Path
    size: int
    used: float
    stage: str
    outputs: tuple[str, ...]

    @property
    def paid(self) -> bool:
        return self.stage in PAID


@dataclass(frozen=True, slots=True)
class CacheSummary:
    """The content of the cache folder. `size`: of blobs and records together [bytes]."""

    size: int
    blobs: int
    records: int
    replies: int


@dataclass(frozen=True, slots=True)
class Cleared:
    """The result of a collection: what was removed, and the remaining `size` [bytes]; `paid` of the `records`
    were replies, which cost API calls to fetch again."""

    records: int
    paid: int
    blobs: int
    freed: int
    size: int


@dataclass(frozen=True, slots=True)
class Verified:
    """The result of a check: the removed `broken` blobs by digest, and the number of removed `records` that
    named broken or missing blobs; `paid` of these were replies."""

    blobs: int
    broken: tuple[str, ...]
    records: int
    paid: int


def summary(root: Path) -> CacheSummary:
    """Counts the content of the folder, which may not exist yet."""
    blobs, records = dict(_blobs(root)), list(_records(root))
    return CacheSummary(
        size=sum(blobs.values()) + sum(record.size for record in records),
        blobs=len(blobs),
        records=len(records),
        replies=sum(record.stage == "reply" for record in records),
    )


def collect(root: Path, most: int) -> Cleared:
    """Removes files until blobs and records take at most `most` bytes, or only recent files are left.

    First blobs without a record, then the records used longest ago, with the blobs that only they name.
    Records that cost API calls are removed last.
    """
    sizes, records = dict(_blobs(root)), list(_records(root))
    named = Counter(digest for record in records for digest in set(record.outputs))
    size = sum(record.size for record in records) + sum(sizes.get(digest, 0) for digest in named)
    dropped = []
    limit = time.time() - SPARED
    for record in sorted(records, key=lambda record: (record.paid, record.used, record.path)):
        if size <= most:
            break
        if record.used > limit:
            continue
        dropped.append(record)
        size -= record.size
        for digest in set(record.outputs):
            named[digest] -= 1
            if not named[digest]:
                size -= sizes.get(digest, 0)
    for record in dropped:
        _remove(record.path)
    gone = [digest for digest in sizes if not named[digest] and _remove_old(_blob(root, digest), limit)]
    drop_locks(root / "locks")
    freed = sum(record.size for record in dropped) + sum(sizes[digest] for digest in gone)
    paid = sum(record.paid for record in dropped)
    left = sum(sizes.values()) + sum(record.size for record in records) - freed
    return Cleared(len(dropped), paid, len(gone), freed, left)


def drop_locks(folder: Path) -> int:
    """Removes the unused lock files in a folder; returns their number."""
    return sum(drop(path) for path in folder.glob("*.lock"))


def verify(root: Path) -> Verified:
    """Reads every blob; removes blobs with a wrong digest, and the records that name missing blobs."""
    sizes = dict(_blobs(root))
    broken = tuple(digest for digest in sorted(sizes) if not _whole(_blob(root, digest)))
    for digest in broken:
        _remove(_blob(root, digest))
    whole = sizes.keys() - broken
    # A blob that was stored meanwhile is not in the list, but it exists.
    idle = [
        record
        for record in _records(root)
        if any(digest not in whole and not _blob(root, digest).exists() for digest in record.outputs)
    ]
    for record in idle:
        _remove(record.path)
    return Verified(len(sizes), broken, len(idle), sum(record.paid for record in idle))


def _blobs(root: Path) -> Iterator[tuple[str, int]]:
    """Digest and length [bytes] of all blobs."""
    for path in (root / "cas").glob("??/*"):
        with contextlib.suppress(OSError):
            yield path.name, path.stat().st_size


def _blob(root: Path, digest: str) -> Path:
    return root / "cas" / digest[:2] / digest


def _records(root: Path) -> Iterator[Record]:
    """All records; an unreadable record names no blobs and counts as never used."""
    for path in (root / "ac").glob("??/*.json"):
        try:
            status = path.stat()
            data = path.read_bytes()
        except OSError:
            continue
        try:
            record = json.loads(data)
            outputs = tuple(str(digest) for digest in record["outputs"].values())
            yield Record(path, status.st_size, status.st_mtime, str(record["stage"]), outputs)
        except (ValueError, KeyError, RecursionError, TypeError, AttributeError):
            yield Record(path, status.st_size, 0.0, "unreadable", ())


def _whole(path: Path) -> bool:
    """Whether the content matches the name; a file that vanished meanwhile counts as intact."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest() == path.name
    except FileNotFoundError:
        return True
    except OSError:
        return False


def _remove_old(path: Path, limit: float) -> bool:
    """Removes a file that was not used since `limit`; returns whether it did."""
    try:
        if path.stat().st_mtime > limit:
            return False
    except OSError:
        return False
    return _remove(path)


def _remove(path: Path) -> bool:
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        msg = f"a file of the cache cannot be removed: {error.strerror or error}"
        raise CacheError(msg, str(path), "check who owns the cache folder") from error
    return True
