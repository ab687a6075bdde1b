"""Acquires lock files: one owner at a time, among all threads and processes that use the same file.

A lock file must not be unlinked while others wait for it: the old file and a new one at the same path
could each have an owner. So an owner checks that its file is still at the path, and only `drop`, which
acquires the lock first, removes a file.
"""

import contextlib
import errno
import os
import stat
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import filelock

if TYPE_CHECKING:
    from filelock import BaseFileLock

FOLDER = ".linkwright"
"""Name of the hidden folder for lock files, beside the output folders."""

NO_LOCKS_ERRORS = (errno.ENOLCK, errno.ENOSYS, errno.ENOTSUP, errno.EOPNOTSUPP)
"""Errors of a file system without locks, such as some network file systems."""

PATIENCE = 2.0
"""Time [s] after which a waiting build reports that it waits."""


@contextlib.contextmanager
def acquired(path: Path, on_wait: Callable[[], None]) -> Iterator[None]:
    """Acquires the lock `path`, whose folder must exist; `on_wait` is called once if it is not free soon.

    Continues without the lock if the file system has no locks. Raises OSError if the file is a link, or
    cannot be created or written.
    """
    lock, patience = None, PATIENCE
    while lock is None:
        try:
            lock = _acquire(path, patience)
        except filelock.Timeout:
            on_wait()
            patience = -1.0
        except OSError as error:
            if error.errno not in NO_LOCKS_ERRORS:
                raise
            break
    try:
        yield
    finally:
        # If the server is gone, it has freed the lock, and the work is done anyway.
        with contextlib.suppress(OSError):
            if lock is not None:
                lock.release()


def lock_path(target: Path) -> Path:
    """Returns the path of the lock file of an output folder."""
    return target.parent / FOLDER / f"{target.name}.lock"


def beside(target: Path) -> Path:
    """Returns `lock_path` of an output folder, and creates the folder of the lock file. Raises OSError if
    that fails."""
    path = lock_path(target)
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
    """Acquires the lock; returns None if its file was removed meanwhile.

    Raises filelock.Timeout if the lock is not free within `patience` [s]; a negative value waits forever.
    """
    handle = _open(path)
    try:
        status = os.fstat(handle)
        # The mode is the file's own, since some versions of filelock set it.
        lock = filelock.FileLock(path, timeout=patience, mode=stat.S_IMODE(status.st_mode))
        try:
            lock.acquire()
        except FileNotFoundError:
            return None
        except NotImplementedError as error:
            raise OSError(errno.ENOSYS, str(error)) from error
        # While `handle` is open, its inode is not reused: if it is at the path now, it always was.
        if _is_at(path, status):
            return lock
        lock.release()
        return None
    finally:
        os.close(handle)


def _open(path: Path) -> int:
    """Opens the lock file, and creates it if needed. Raises OSError in the cases in which filelock would
    retry forever: the file cannot be created, is a link, or its file system has no locks."""
    handle = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
    try:
        # Imported late: exists only on POSIX systems.
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


def _is_at(path: Path, status: os.stat_result) -> bool:
    try:
        return os.path.samestat(status, path.lstat())
    except FileNotFoundError:
        return False
