"""Reads files that an untrusted file names: only regular files, and only up to a size.

Reading a pipe, a socket or a device may block or never end, and so may reading a file of the kernel, whose
length is zero.
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
from linkwright.stages.robot.text.globs import did_you_mean

NOT_REGULAR = "it is a device, a pipe or a socket, and only regular files are read"
"""The message about a path that is not a regular file."""

_CHUNK_SIZE = 1 << 20
"""Number of bytes that are read at a time for a digest."""


class FileTooLarge(Exception):
    """An error of a file whose `size` [bytes] is above the limit."""

    def __init__(self, size: int) -> None:
        super().__init__(size)
        self.size = size


def is_file(path: Path) -> bool:
    """Returns whether the path is that of a regular file, also through a link."""
    return _has_mode(path, stat.S_ISREG)


def is_special(path: Path) -> bool:
    """Returns whether the path exists and is neither a regular file nor a folder."""
    return _has_mode(path, lambda mode: not stat.S_ISREG(mode) and not stat.S_ISDIR(mode))


def is_endless(path: Path) -> bool:
    """Returns whether reading the path to its end may block or never end."""
    if is_special(path):
        return True
    try:
        # The kernel's own file systems have no blocks.
        return is_file(path) and not path.stat().st_size and not os.statvfs(path).f_blocks
    except (OSError, AttributeError):
        return False


def require(path: str, key: str, description: str, example: str) -> None:
    """Raises ConfigError if `path`, the value of `key`, is not the path of a regular file.

    `description`: the expected kind of file, such as "a URDF is a file". `example`: a path of such a file.
    """
    place = Path(path)
    if is_file(place):
        return
    problem = f"is a folder, and {description}" if place.is_dir() else "does not exist"
    if is_special(place):
        problem = f"is not a regular file: {NOT_REGULAR}"
    near = did_you_mean(place.name, _files_beside(place))
    hint = f"{near} paths start from the working folder; give one such as {example}".lstrip()
    raise ConfigError(f"{path} {problem}", key, hint)


def _files_beside(place: Path) -> list[str]:
    """Returns the names of the files in the folder of a path; [] if it cannot be listed."""
    try:
        return sorted(file.name for file in place.parent.iterdir() if is_file(file))
    except (OSError, ValueError):
        return []


def content(path: Path, max_size: int) -> bytes:
    """Returns the content of a file. Raises OSError if it is not a readable regular file, ValueError if no
    file can have its name, and FileTooLarge if it has more than `max_size` bytes."""
    with _open_file(path, max_size) as (file, size):
        return file.read(size)


def digest(path: Path, max_size: int) -> str:
    """Returns the SHA-256 of a file's content, with little memory; raises the same errors as `content`."""
    hasher = sha256()
    with _open_file(path, max_size) as (file, size):
        while size > 0 and (piece := file.read(min(size, _CHUNK_SIZE))):
            hasher.update(piece)
            size -= len(piece)
    return hasher.hexdigest()


@contextmanager
def _open_file(path: Path, max_size: int) -> Iterator[tuple[BinaryIO, int]]:
    """Yields a file that is open for reading, and its size [bytes]; raises the same errors as `content`."""
    # A pipe without a writer would block here, and a terminal would become ours.
    flags = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0) | getattr(os, "O_BINARY", 0)
    # Opening a device may already do something, so it is refused before.
    if is_special(path):
        raise OSError(errno.EINVAL, NOT_REGULAR)
    with open(os.open(path, os.O_RDONLY | flags), "rb") as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode):
            kind = errno.EISDIR if stat.S_ISDIR(status.st_mode) else errno.EINVAL
            raise OSError(kind, os.strerror(kind) if kind == errno.EISDIR else NOT_REGULAR)
        if status.st_size > max_size:
            raise FileTooLarge(status.st_size)
        yield file, status.st_size


def _has_mode(path: Path, matches: Callable[[int], bool]) -> bool:
    """Returns whether the mode of an existing path matches."""
    try:
        return matches(path.stat().st_mode)
    except (OSError, ValueError):  # ValueError: a name that no file can have
        return False
