"""Handles a file system that hosts share: it has its own clock, and may be out of reach for a while."""

import errno
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")

_NAMES = ("EIO", "ESTALE", "ETIMEDOUT", "EHOSTDOWN", "EHOSTUNREACH", "ENOTCONN", "EREMOTEIO")

LOST = frozenset(getattr(errno, name) for name in _NAMES if hasattr(errno, name))
"""Errors of a file system that is out of reach: they do not say that a file is missing."""

PAUSES = (0.0, 0.5, 2.0, 8.0)
"""The waits [s] before further attempts. The first wait is 0: a file that another host replaced while it was
read is there again when it is opened again."""


def patient(act: Callable[[], T]) -> T:
    """Returns the result of `act`. While the file system is out of reach, `act` is tried again after each of
    `PAUSES`; then the OSError is raised."""
    for pause in PAUSES:
        try:
            return act()
        except OSError as error:
            if error.errno not in LOST:
                raise
        time.sleep(pause)
    return act()


def now(folder: Path) -> float:
    """Returns the current time [s] of the clock by which a folder's files are dated: that of the file server,
    since the clocks of hosts differ. Raises OSError if the folder cannot be written."""
    os.utime(folder)
    return folder.stat().st_mtime
