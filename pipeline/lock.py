"""A lock file: one owner at a time, among all threads and processes that use the same file.

A lock file must not be unlinked while others wait for it: the old file and a new one at the same path
could each have an owner. So an owner checks that its file is still at the path, and only `drop`, which
acquires the lock first, removes a file.
"""

import contextlib
import os
import stat
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import filelock

if TYPE_CHECKING:
    from filelock import BaseFileLock

FOLDER = ".linkwright"
"""The hidden folder beside the outputs for their lock files."""

PATIENCE = 2.0
"""Time [s] after which a waiting build reports that it waits."""


@contextlib.contextmanager
def acquired(path: Path, waiting: Callable[[], None]) -> Iterator[None]:
    """Acquires the lock `path`, whose folder must exist; `waiting` is called once if it is not free soon.

    OSError where the file cannot be made or written, is a link, or where its file system has no locks.
    """
    lock, patience = None, PATIENCE
    while lock is None:
        try:
            lock = _acquire(path, patience)
        except filelock.Timeout:
            waiting()
            patience = -1.0
    try:
        yield
    finally:
        lock.release()


def place(target: Path) -> Path:
    """The lock file of an output folder."""
    return target.parent / FOLDER / f"{target.name}.lock"


def beside(target: Path) -> Path:
    """As `place`, and creates the folder of the lock file. OSError where that fails."""
    path = place(target)
    if path.parent.is_symlink():
        msg = f"{path.parent} is a link"
        raise NotADirectoryError(msg)
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def drop(path: Path) -> bool:
    """Removes a lock file if no process owns it; returns whether it did."""
    try:
        if not stat.S_ISREG(path.lstat().st_mode):
            return False
        lock = _acquire(path, 0.0)
    except (filelock.Timeout, OSError):
        return False
    if lock is None:
        return False
    try:
        path.unlink()
    except OSError:
        return False
    finally:
        lock.release()
    return True


def _acquire(path: Path, patience: float) -> "BaseFileLock | None":
    """Acquires the lock; None where its file was removed meanwhile.

    filelock.Timeout where it is not free within `patience` [s]; below zero it is waited for.
    """
    seen = _opened(path)
    try:
        status = os.fstat(seen)
        # The mode is the file's own, since some versions of filelock set it.
        lock = filelock.FileLock(path, timeout=patience, mode=stat.S_IMODE(status.st_mode))
        try:
            lock.acquire()
        except FileNotFoundError:
            return None
        except NotImplementedError as error:
            raise OSError(str(error)) from error
        # While `seen` is open, no other file has its number: if it lies there now, it did all the time.
        if _lies_at(path, status):
            return lock
        lock.release()
        return None
    finally:
        os.close(seen)


def _opened(path: Path) -> int:
    """Opens the lock file, and creates it if needed. OSError where filelock would retry forever: the file
    cannot be created, is a link, or its file system has no locks."""
    handle = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
    try:
        # Late: POSIX only.
        import fcntl
    except ImportError:
        return handle
    try:
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
        fcntl.flock(handle, fcntl.LOCK_UN)
    except BlockingIOError:
        pass
    except BaseException:
        os.close(handle)
        raise
    return handle


def _lies_at(path: Path, status: os.stat_result) -> bool:
    try:
        return os.path.samestat(status, path.lstat())
    except FileNotFoundError:
        return False
