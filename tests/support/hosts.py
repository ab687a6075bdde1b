"""Hosts that share a file system: processes, each with a name, a clock and locks of its own."""

import errno
import fcntl
import json
import os
import signal
import socket
import subprocess
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path

from tests.support.places import PROJECT

NUMBER = 7
"""The number of each host's process: containers have equal ones."""

COMMAND = "from linkwright.pipeline.cli import run; sys.exit(run(sys.argv[1:]))"


@dataclass(frozen=True, slots=True)
class Host:
    """`clock`: by how much it is ahead [s]; `locks`: `work`, the name of the error that each lock raises, or
    `shared`, which all get at once. At that touch of a file below `root` it `dies_at` by kill -9, or it
    `loses_at` the file system with the error `lost` for `away` [s]."""

    name: str
    clock: float = 0.0
    locks: str = "work"
    root: str = ""
    dies_at: int = 0
    loses_at: int = 0
    lost: str = "EIO"
    away: float = 0.0

    def start(self, code, *arguments, cwd, environ=os.environ):
        """Starts a process of this host, which runs `code`."""
        begin = f"import sys; from tests.support.hosts import become; become({json.dumps(asdict(self))!r})\n"
        return subprocess.Popen(
            [sys.executable, "-c", begin + code, *arguments],
            cwd=cwd,
            env={**environ, "PYTHONPATH": str(PROJECT)},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )


def become(text):
    """Makes this process that of a host."""
    host = Host(**json.loads(text))
    own, clock = os.getpid(), time.time
    socket.gethostname = lambda: host.name
    os.getpid = lambda: NUMBER
    time.time = lambda: clock() + host.clock
    if host.locks != "work":
        fcntl.flock = lambda *_: _lock(host.locks)
    if host.dies_at or host.loses_at:
        sys.addaudithook(_Trouble(host, own))


def _lock(kind):
    if kind != "shared":
        number = getattr(errno, kind)
        raise OSError(number, os.strerror(number))


class _Trouble:
    """The hook that kills a process, or takes the file system from it."""

    def __init__(self, host, process):
        self._host, self._process = host, process
        self._seen, self._until = 0, 0.0

    def __call__(self, event, arguments):
        if event != "open" and not event.startswith("os."):
            return
        if not (arguments and isinstance(arguments[0], str | Path) and self._host.root in str(arguments[0])):
            return
        self._seen += 1
        if self._seen == self._host.dies_at:
            os.kill(self._process, signal.SIGKILL)
        if self._seen == self._host.loses_at:
            self._until = time.monotonic() + self._host.away
        if time.monotonic() < self._until:
            number = getattr(errno, self._host.lost)
            raise OSError(number, os.strerror(number), str(arguments[0]))
