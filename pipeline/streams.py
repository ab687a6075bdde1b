"""Standard output and standard error, whose reader may leave before the end: `linkwright --help | head -1`.

What nobody reads any more is dropped in silence. The command goes on, since a build is worth its calls
and its files whoever watches it, and its exit status is that of what it did.
"""

import contextlib
import io
import os
import sys
from typing import Any


class _StreamFile(io.FileIO):
    """A stream's file, which takes all that is written once it cannot be written any more.

    `lost`: why that is, "" where only its reader has left.
    """

    lost = ""

    def write(self, data: Any) -> int:
        try:
            return super().write(data) or 0
        except OSError as error:
            if not isinstance(error, BrokenPipeError):
                self.lost = error.strerror or type(error).__name__
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.fileno())
            os.close(nowhere)
            return memoryview(data).nbytes


def patient() -> None:
    """Makes the standard streams of this process take what cannot be written any more."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        # Others are in the place of ours where somebody captures them, and none at all without a terminal.
        if not isinstance(stream, io.TextIOWrapper):
            continue
        if not isinstance(getattr(stream.buffer, "raw", stream.buffer), io.FileIO):
            continue
        with contextlib.suppress(OSError):
            file = _StreamFile(stream.fileno(), "w", closefd=False)
            made = io.TextIOWrapper(
                io.BufferedWriter(file),
                encoding=stream.encoding,
                errors=stream.errors,
                line_buffering=stream.line_buffering or stream.write_through,
            )
            setattr(sys, name, made)


def flushed() -> str:
    """Writes what is held back of the standard output; why it was not written whole, "" where it was."""
    if sys.stdout is None:
        return ""
    try:
        sys.stdout.flush()
    except OSError as error:
        return error.strerror or type(error).__name__
    file = getattr(getattr(sys.stdout, "buffer", None), "raw", None)
    return file.lost if isinstance(file, _StreamFile) else ""
