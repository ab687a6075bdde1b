"""Counts the calls made and billed, by key and calendar year: a count that Onshape itself does not give.

    ledger/<who>-<year>.json     one line of JSON a call: {"at", "endpoint", "status", "left"}

`who` is a hash of the access key. A line is appended whole or not at all, by any number of
processes; a line that a full disk cut short is skipped. Imports nothing heavy.
"""

import contextlib
import errno
import json
import os
import re
import stat
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

FOLDER = "ledger"
"""The ledger's folder in the cache folder."""

_FILE = re.compile(r"([0-9a-z]{1,16})-(\d{4})\.json")
_PLACES = re.compile(r"/(?:d|[wvm]|e|partid)/[^/]+")
_NAMES = {"assemblies": "assembly definition", "assemblies/massproperties": "assembly massproperties"}


def endpoint(request: str) -> str:
    """Returns the endpoint of a request, as the server's rate limits count it: "massproperties" (of part
    studios).

    The name comes from the path only, without its ids.
    """
    path = _PLACES.sub("", request.partition("?")[0]).strip("/")
    return _NAMES.get(path) or path.rpartition("/")[2]


def billed(status: int) -> bool:
    """Tells whether a reply with this status counts against the yearly quota."""
    return 200 <= status < 400


@dataclass(frozen=True, slots=True)
class Year:
    """The calls of a key in a calendar year (UTC)."""

    who: str
    """A name that does not reveal the key."""

    year: int
    calls: Mapping[str, int]
    """The billed calls by endpoint."""

    exhausted: bool
    """Whether the quota ended (402)."""

    @property
    def counted(self) -> int:
        """The number of billed calls."""
        return sum(self.calls.values())


class Ledger:
    """The record of the calls of a key, safe between threads and processes. `who`: a name that does not
    reveal the key, `Credentials.who`.

    `year`: the year to count; by default the year of each call.
    """

    def __init__(self, folder: Path, who: str, year: int | None = None) -> None:
        self._folder = folder
        self._who = who
        self._year = year

    def note(self, kind: str, status: int, left: int | None = None) -> str:
        """Records a billed reply, or the reply that reports a used-up quota (402).

        `left`: calls left in the window of this endpoint. If the ledger cannot be written, the call is not
        counted, but the reply is kept; returns the reason in words, "" if the call was counted.
        """
        if not billed(status) and status != 402:
            return ""
        entry: dict[str, Any] = {"at": int(time.time()), "endpoint": kind, "status": status}
        if left is not None:
            entry["left"] = left
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            _append(self._path(), json.dumps(entry, separators=(",", ":")).encode() + b"\n")
        except OSError as error:
            return f"the ledger {self._path()} cannot be written: {error.strerror or error}"
        return ""

    def counted(self) -> int:
        """Returns the number of billed calls of the year so far."""
        return self.read().counted

    def read(self) -> Year:
        """Returns the year so far."""
        return _read(self._path(), self._who, self._this_year())

    def _this_year(self) -> int:
        return self._year if self._year is not None else time.gmtime().tm_year

    def _path(self) -> Path:
        return self._folder / f"{self._who}-{self._this_year()}.json"


def years(folder: Path) -> list[Year]:
    """Returns the counts of all ledgers in `folder`, by key and year."""
    if not folder.is_dir():
        return []
    files = ((path, _FILE.fullmatch(path.name)) for path in sorted(folder.iterdir()))
    return [_read(path, match[1], int(match[2])) for path, match in files if match]


def _read(path: Path, who: str, year: int) -> Year:
    calls: Counter[str] = Counter()
    exhausted = False
    for entry in _entries(path):
        status, kind = entry.get("status"), entry.get("endpoint")
        if isinstance(status, int) and isinstance(kind, str):
            if billed(status):
                calls[kind] += 1
            exhausted = status == 402
    return Year(who, year, dict(sorted(calls.items())), exhausted)


def _entries(path: Path) -> Iterator[dict[str, Any]]:
    try:
        lines = path.read_bytes().splitlines()
    except OSError:
        return
    for line in lines:
        try:
            entry = json.loads(line)
        except (RecursionError, ValueError):
            continue
        if isinstance(entry, dict):
            yield entry


def _append(path: Path, line: bytes) -> None:
    """Adds a line in one write at the file's end, under its lock if the system has locks.

    The kernel moves to the end and writes as one step on a local disk; over a network it needs the lock,
    which ends with the process however that ends.
    """
    handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o600)
    try:
        with contextlib.suppress(OSError, AttributeError):  # not on every system
            _close_to_others(handle, path.parent.parent)
        with contextlib.suppress(ImportError, OSError):
            # Late: POSIX only.
            import fcntl

            fcntl.flock(handle, fcntl.LOCK_EX)
        if os.fstat(handle).st_size:
            os.lseek(handle, -1, os.SEEK_END)
            if os.read(handle, 1) != b"\n":
                line = b"\n" + line
        if os.write(handle, line) < len(line):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    finally:
        os.close(handle)


def _close_to_others(handle: int, cache: Path) -> None:
    """Lets only the user read the ledger, and the group if the cache folder is shared with it."""
    mode = 0o660 if cache.stat().st_mode & stat.S_IWGRP else 0o600
    if stat.S_IMODE(os.fstat(handle).st_mode) != mode:
        os.fchmod(handle, mode)
