"""Room on a disk: found out before work that costs, not after it."""

import contextlib
import errno
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

LEAST = 1_000_000
"""Bytes that any build needs."""

_CHUNK = 1 << 20
_UNSUPPORTED = (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP)


@contextlib.contextmanager
def taken(folder: Path, size: int) -> Iterator[None]:
    """Inside, `size` bytes of the disk that `folder` is on are taken, and that is known to the disk
    itself: a file system may promise what a server or a quota refuses. OSError where there are not as
    many. Leaves nothing, also after a kill, where files without a name are known."""
    with tempfile.TemporaryFile(dir=folder, prefix="room-") as file:
        _reserve(file.fileno(), size)
        try:
            os.fsync(file.fileno())
        except OSError as error:
            if error.errno not in _UNSUPPORTED:
                raise
        yield


def _reserve(handle: int, size: int) -> None:
    """Takes blocks for `size` bytes, without writing them where the system can."""
    if hasattr(os, "posix_fallocate"):
        try:
            os.posix_fallocate(handle, 0, size)
        except OSError as error:
            if error.errno not in _UNSUPPORTED:
                raise
        else:
            return
    while size > 0:
        # What cannot be made smaller: some file systems would.
        size -= os.write(handle, os.urandom(min(size, _CHUNK)))
