"""One holder at a time, among all threads and processes that use the same lock file."""

import contextlib
import os
from collections.abc import Callable, Iterator
from pathlib import Path

PATIENCE = 2.0
"""Wait [s] for a lock after which the user is told that there is one."""


@contextlib.contextmanager
def held(path: Path, waiting: Callable[[], None]) -> Iterator[None]:
    """Holds the lock `path`, whose folder must be there; `waiting` is called once if it is not free soon.

    OSError where the file cannot be made or written, or where its file system has no locks.
    """
    import filelock

    # filelock tries for ever where the file cannot be made: that must be found out here.
    os.close(os.open(path, os.O_RDWR | os.O_CREAT, 0o666))
    lock = filelock.FileLock(path)
    try:
        try:
            lock.acquire(timeout=PATIENCE)
        except filelock.Timeout:
            waiting()
            lock.acquire()
    except NotImplementedError as error:
        raise OSError(str(error)) from error
    try:
        yield
    finally:
        lock.release()
