"""Handles a file system that hosts share: it has its own clock, and may be out of reach for a while."""

import errno
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")

_UNREACHABLE_NAMES = ("EIO", "ESTALE", "ETIMEDOUT", "EHOSTDOWN", "EHOSTUNREACH", "ENOTCONN", "EREMOTEIO")

UNREACHABLE_ERRORS = frozenset(getattr(errno, name) for name in _UNREACHABLE_NAMES if hasattr(errno, name))
"""Numbers of the errors of a file system that is out of reach: the file may still exist."""

PAUSES = (0.0, 0.5, 2.0, 8.0)
"""Waits [s] before further attempts. The first is 0: a file that another host replaced during a read can be
opened again at once."""


def with_retries(act: Callable[[], T]) -> T:
    """Returns the result of `act`. While the file system is out of reach, `act` is tried again after each of
    `PAUSES`; then the OSError is raised."""
    for pause in PAUSES:
        try:
            return act()
        except OSError as error:
            if error.errno not in UNREACHABLE_ERRORS:
                raise
        time.sleep(pause)
    return act()


def now(folder: Path) -> float:
    """Returns the current time [s] by the clock that dates a folder's files. It may be a file server's clock,
    which differs from this host's. Raises OSError if the folder cannot be written."""
    os.utime(folder)
    return folder.stat().st_mtime
