"""Checks the free space of a disk before expensive work, not after it."""

import contextlib
import errno
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

MIN_FREE_BYTES = 1_000_000
"""Free space that every build needs [bytes]."""

_CHUNK_BYTES = 1 << 20
_UNSUPPORTED_ERRORS = (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP)
"""Errors of file systems that cannot sync or allocate a file."""


@contextlib.contextmanager
def reserved(folder: Path, size: int) -> Iterator[None]:
    """Reserves `size` bytes on the disk of `folder` while the block runs; raises OSError if space is missing.

    A synced temporary file reserves them, since a file system may report free space that a server or a quota
    refuses. Where the system supports files without a name, a kill leaves nothing behind.
    """
    with tempfile.TemporaryFile(dir=folder, prefix="room-") as file:
        _reserve(file.fileno(), size)
        try:
            os.fsync(file.fileno())
        except OSError as error:
            if error.errno not in _UNSUPPORTED_ERRORS:
                raise
        yield


def _reserve(handle: int, size: int) -> None:
    """Allocates blocks for `size` bytes, without writing them where the system supports that."""
    if hasattr(os, "posix_fallocate"):
        try:
            os.posix_fallocate(handle, 0, size)
        except OSError as error:
            if error.errno not in _UNSUPPORTED_ERRORS:
                raise
        else:
            return
    while size > 0:
        # Random bytes, since some file systems compress.
        size -= os.write(handle, os.urandom(min(size, _CHUNK_BYTES)))
