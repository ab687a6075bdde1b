"""Reads files that an untrusted file names: only regular files, and only up to a size.

A pipe, a socket or a device may block for ever or never end, and so may what a kernel shows as a file
of no length.
"""

import errno
import os
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from typing import BinaryIO

from linkwright.stages.robot.errors import ConfigError

NOT_REGULAR = "it is a device, a pipe or a socket, and only regular files are read"

_PIECE = 1 << 20


class FileTooLarge(Exception):
    """A file is larger than what is read; `size` [bytes]."""

    def __init__(self, size: int) -> None:
        super().__init__(size)
        self.size = size


def is_file(path: Path) -> bool:
    """Whether there is a regular file; False too for a name that no file can have."""
    return _is(path, stat.S_ISREG)


def is_special(path: Path) -> bool:
    """Whether the path exists and is neither a file nor a folder."""
    return _is(path, lambda mode: not stat.S_ISREG(mode) and not stat.S_ISDIR(mode))


def is_endless(path: Path) -> bool:
    """Whether reading the path to its end could block or never finish."""
    if is_special(path):
        return True
    try:
        # The kernel's own file systems have no blocks.
        return is_file(path) and not path.stat().st_size and not os.statvfs(path).f_blocks
    except (OSError, AttributeError):
        return False


def require(path: str, key: str, wanted: str, example: str) -> None:
    """ConfigError where there is no regular file at `path`, the value of `key`.

    `wanted` is what a file of its kind is, "a URDF is a file"; `example` a path of one.
    """
    place = Path(path)
    if is_file(place):
        return
    what = f"is a folder, and {wanted}" if place.is_dir() else "does not exist"
    if is_special(place):
        what = f"is not a regular file: {NOT_REGULAR}"
    raise ConfigError(
        f"{path} {what}", key, f"paths start from the working folder; give one such as {example}"
    )


def content(path: Path, most: int) -> bytes:
    """The content; OSError where it is not a readable regular file, FileTooLarge beyond `most` bytes."""
    with _opened(path, most) as (file, size):
        return file.read(size)


def digest(path: Path, most: int) -> str:
    """The SHA-256 of what a file holds, in little memory; raises as `content` does."""
    whole = sha256()
    with _opened(path, most) as (file, size):
        while size > 0 and (piece := file.read(min(size, _PIECE))):
            whole.update(piece)
            size -= len(piece)
    return whole.hexdigest()


@contextmanager
def _opened(path: Path, most: int) -> Iterator[tuple[BinaryIO, int]]:
    """The file and its size, as the system reports it."""
    # A pipe without a writer would block here, and a terminal take us over.
    flags = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0) | getattr(os, "O_BINARY", 0)
    if is_special(path):
        raise OSError(errno.EINVAL, NOT_REGULAR)
    with open(os.open(path, os.O_RDONLY | flags), "rb") as file:
        found = os.fstat(file.fileno())
        if not stat.S_ISREG(found.st_mode):
            kind = errno.EISDIR if stat.S_ISDIR(found.st_mode) else errno.EINVAL
            raise OSError(kind, os.strerror(kind) if kind == errno.EISDIR else NOT_REGULAR)
        if found.st_size > most:
            raise FileTooLarge(found.st_size)
        yield file, found.st_size


def _is(path: Path, kind: Callable[[int], bool]) -> bool:
    try:
        return kind(path.stat().st_mode)
    except (OSError, ValueError):  # a name that no file can have
        return False
