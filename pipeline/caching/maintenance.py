"""Maintains the cache folder: summarises its content, frees space, and finds corrupt files.

It is safe while builds use the folder: recently used files stay, and reading a record or storing a blob again
updates its time. At worst a result is made or fetched twice.
"""

import contextlib
import json
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from linkwright.pipeline.caching.shared import UNREACHABLE_ERRORS, now, with_retries
from linkwright.pipeline.caching.store import digest_of
from linkwright.pipeline.errors import CacheError, reason
from linkwright.pipeline.lock import drop

MIN_AGE = 3600.0
"""Age [s] below which no file is removed, since a running build may use it."""

COSTLY_STAGES = ("reply", "fact")
"""Stages whose records cost API calls to make again; these are removed last."""


@dataclass(frozen=True, slots=True)
class Record:
    """A record in the cache folder."""

    path: Path
    size: int
    """Length of its file [bytes]."""
    used: float
    """Time of its last use [s]."""
    stage: str
    outputs: tuple[str, ...]
    """Digests of the blobs that it names."""

    @property
    def is_costly(self) -> bool:
        """Tells whether making the result again costs API calls."""
        return self.stage in COSTLY_STAGES


@dataclass(frozen=True, slots=True)
class CacheSummary:
    """The content of the cache folder."""

    size: int
    """Length of all blobs and records together [bytes]."""
    blobs: int
    records: int
    replies: int


@dataclass(frozen=True, slots=True)
class Clearing:
    """The result of freeing space."""

    records: int
    """The number of removed records."""
    paid: int
    """The number of removed records that cost API calls to make again."""
    blobs: int
    """The number of removed blobs."""
    freed: int
    """Length of the removed files [bytes]."""
    size: int
    """Length of the remaining files [bytes]."""


@dataclass(frozen=True, slots=True)
class Verification:
    """The result of verifying the cache."""

    blobs: int
    """The number of blobs that were read."""
    broken: tuple[str, ...]
    """Digests of the corrupt blobs, which were removed."""
    records: int
    """The number of removed records, which named corrupt or missing blobs."""
    paid: int
    """The number of removed records that cost API calls to make again."""


def summary(root: Path) -> CacheSummary:
    """Counts the content of the folder, which may not exist yet."""
    blobs, records = dict(_blobs(root)), list(_records(root))
    return CacheSummary(
        size=sum(blobs.values()) + sum(record.size for record in records),
        blobs=len(blobs),
        records=len(records),
        replies=sum(record.stage == "reply" for record in records),
    )


def collect(root: Path, max_size: int) -> Clearing:
    """Removes files until blobs and records take at most `max_size` bytes, or only recent files are left.

    It first removes blobs without a record, then the records used longest ago, with the blobs that only they
    name; records that cost API calls come last.
    """
    sizes, records = dict(_blobs(root)), list(_records(root))
    use_counts = Counter(digest for record in records for digest in set(record.outputs))
    size = sum(record.size for record in records) + sum(sizes.get(digest, 0) for digest in use_counts)
    removed_records = []
    latest_use = _now(root) - MIN_AGE
    for record in sorted(records, key=lambda record: (record.is_costly, record.used, record.path)):
        if size <= max_size:
            break
        if record.used > latest_use:
            continue
        removed_records.append(record)
        size -= record.size
        for digest in set(record.outputs):
            use_counts[digest] -= 1
            if not use_counts[digest]:
                size -= sizes.get(digest, 0)
    for record in removed_records:
        _remove(record.path)
    removed_blobs = [
        digest for digest in sizes if not use_counts[digest] and _remove_old(_blob(root, digest), latest_use)
    ]
    drop_locks(root / "locks")
    freed = sum(record.size for record in removed_records) + sum(sizes[digest] for digest in removed_blobs)
    paid = sum(record.is_costly for record in removed_records)
    remaining = sum(sizes.values()) + sum(record.size for record in records) - freed
    return Clearing(len(removed_records), paid, len(removed_blobs), freed, remaining)


def drop_locks(folder: Path) -> int:
    """Removes the unused lock files in a folder; returns their number."""
    return sum(drop(path) for path in folder.glob("*.lock"))


def verify(root: Path) -> Verification:
    """Reads every blob; removes blobs with a wrong digest, and records that name missing blobs."""
    sizes = dict(_blobs(root))
    broken = tuple(digest for digest in sorted(sizes) if not _is_intact(_blob(root, digest)))
    for digest in broken:
        _remove(_blob(root, digest))
    intact = sizes.keys() - broken
    # A blob that was stored meanwhile is not in the list, but it exists.
    broken_records = [
        record
        for record in _records(root)
        if any(digest not in intact and not _blob(root, digest).exists() for digest in record.outputs)
    ]
    for record in broken_records:
        _remove(record.path)
    return Verification(
        len(sizes), broken, len(broken_records), sum(record.is_costly for record in broken_records)
    )


def _blobs(root: Path) -> Iterator[tuple[str, int]]:
    """Yields the digest and the length [bytes] of each blob."""
    for path in (root / "cas").glob("??/*"):
        with contextlib.suppress(OSError):
            yield path.name, path.stat().st_size


def _blob(root: Path, digest: str) -> Path:
    return root / "cas" / digest[:2] / digest


def _records(root: Path) -> Iterator[Record]:
    """Yields all records; an unreadable record names no blobs and counts as never used."""
    for path in (root / "ac").glob("??/*.json"):
        try:
            status = path.stat()
            data = with_retries(path.read_bytes)
        except OSError as error:
            if error.errno in UNREACHABLE_ERRORS:
                # The blobs that it names would look unused.
                msg = f"a file of the cache cannot be read: {reason(error)}"
                hint = "run it again when the disk or the server is back"
                raise CacheError(msg, str(path), hint) from error
            continue
        try:
            record = json.loads(data)
            outputs = tuple(str(digest) for digest in record["outputs"].values())
            yield Record(path, status.st_size, status.st_mtime, str(record["stage"]), outputs)
        except (ValueError, KeyError, RecursionError, TypeError, AttributeError):
            yield Record(path, status.st_size, 0.0, "unreadable", ())


def _is_intact(path: Path) -> bool:
    """Tells whether the content matches the name; a file that vanished meanwhile counts as intact."""
    try:
        return with_retries(lambda: digest_of(path)) == path.name
    except FileNotFoundError:
        return True
    except OSError:
        return False


def _now(root: Path) -> float:
    """Returns the current time [s] by the clock that dates the cache's files, or by this host's clock if the
    cache cannot be written."""
    try:
        return now(root / "tmp")
    except OSError:
        return time.time()


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
