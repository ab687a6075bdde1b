"""Makes standard streams survive a reader that closes them early: `linkwright --help | head -1`.

Output to a closed pipe is dropped silently. The command continues, so that a build keeps its API calls
and its files, and the exit status is that of the build.
"""

import contextlib
import io
import os
import sys
from typing import Any


class _StreamFile(io.FileIO):
    """A stream's file that discards output after a write error.

    `write_error`: the reason of the error; "" if the reader closed the pipe.
    """

    write_error = ""

    def write(self, data: Any) -> int:
        try:
            return super().write(data) or 0
        except OSError as error:
            if not isinstance(error, BrokenPipeError):
                self.write_error = error.strerror or type(error).__name__
            null_device = os.open(os.devnull, os.O_WRONLY)
            os.dup2(null_device, self.fileno())
            os.close(null_device)
            return memoryview(data).nbytes


def survive_closed_pipes() -> None:
    """Makes the standard streams of this process discard output after a write error."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        # A test or a caller may have replaced the stream; without a terminal it may be None.
        if not isinstance(stream, io.TextIOWrapper):
            continue
        if not isinstance(getattr(stream.buffer, "raw", stream.buffer), io.FileIO):
            continue
        with contextlib.suppress(OSError):
            file = _StreamFile(stream.fileno(), "w", closefd=False)
            wrapper = io.TextIOWrapper(
                io.BufferedWriter(file),
                encoding=stream.encoding,
                errors=stream.errors,
                line_buffering=stream.line_buffering or stream.write_through,
            )
            setattr(sys, name, wrapper)


def flush() -> str:
    """Flushes the standard output; returns the reason of a write error, or ""."""
    if sys.stdout is None:
        return ""
    try:
        sys.stdout.flush()
    except OSError as error:
        return error.strerror or type(error).__name__
    file = getattr(getattr(sys.stdout, "buffer", None), "raw", None)
    return file.write_error if isinstance(file, _StreamFile) else ""
