"""A terminal, to type into as a user does."""

import io
import os
import pty
import re
import select
import signal
import time

PATIENCE = 30.0
"""Longest wait [s] for what must appear; a test fails then."""

ESCAPES = re.compile(rb"\x1b(\[[0-9;?]*[ -/]*[@-~]|\][^\x07\x1b]*(\x07|\x1b\\)|[()][A-Z0-9]|[=>78])")


class Screen(io.StringIO):
    """A stream that says that it is a terminal, and keeps what is written."""

    def isatty(self):
        return True


class Terminal:
    """A program in a pseudo terminal of 200 columns; what it shows, without escape sequences."""

    def __init__(self, arguments, here, environ):
        self._seen = b""
        self._pid, self._file = pty.fork()
        if self._pid == 0:
            os.chdir(here)
            os.execvpe(arguments[0], list(arguments), {**environ, "TERM": "xterm", "COLUMNS": "200"})

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.kill(self._pid, signal.SIGKILL)
        os.close(self._file)
        os.waitpid(self._pid, 0)

    def type(self, text):
        os.write(self._file, text.encode())

    def until(self, words):
        """Returns the text shown since the last call, up to these words; raises where they never come."""
        end = time.monotonic() + PATIENCE
        while words not in self._shown():
            assert time.monotonic() < end, f"{words!r} never came: {self._shown()!r}"
            if select.select([self._file], [], [], 0.1)[0]:
                try:
                    self._seen += os.read(self._file, 65536)
                except OSError:
                    break
        shown = self._shown()
        assert words in shown, f"{words!r} never came: {shown!r}"
        self._seen = b""
        return shown

    def _shown(self):
        plain = re.sub(rb"[\r\x07]", b"", ESCAPES.sub(b"", self._seen))
        return re.sub(rb".\x08", b"", plain).decode(errors="replace")
