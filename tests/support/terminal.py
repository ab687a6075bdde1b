"""A terminal, to type into as a user does."""

import os
import pty
import re
import select
import signal
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

PATIENCE = 30.0
"""Longest wait [s] for what must appear; a test fails then."""

ESCAPES = re.compile(rb"\x1b(\[[0-9;?]*[ -/]*[@-~]|\][^\x07\x1b]*(\x07|\x1b\\)|[()][A-Z0-9]|[=>78])")


class Terminal:
    """A program in a pseudo terminal of 200 columns; what it shows, without escape sequences."""

    def __init__(self, arguments: Sequence[str], here: Path, environ: Mapping[str, str]) -> None:
        self._seen = b""
        self._pid, self._file = pty.fork()
        if self._pid == 0:
            os.chdir(here)
            os.execvpe(arguments[0], list(arguments), {**environ, "TERM": "xterm", "COLUMNS": "200"})

    def __enter__(self) -> "Terminal":
        return self

    def __exit__(self, *_: object) -> None:
        os.kill(self._pid, signal.SIGKILL)
        os.close(self._file)
        os.waitpid(self._pid, 0)

    def type(self, text: str) -> None:
        os.write(self._file, text.encode())

    def until(self, words: str) -> str:
        """What is shown up to these words, from the last time on; AssertionError where they never come."""
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

    def _shown(self) -> str:
        plain = re.sub(rb"[\r\x07]", b"", ESCAPES.sub(b"", self._seen))
        return re.sub(rb".\x08", b"", plain).decode(errors="replace")
