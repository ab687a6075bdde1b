"""Runs code that reads untrusted input in guest processes, within limits.

A guest is a module with a function `answer(request: bytes) -> bytes`. Its process runs in Python's isolated
mode with the libraries of this process, only the environment variables that it is given, no terminal, and no
input but its requests; a crash does not affect this process. The guest and its children are ended when they
exceed a limit of time or memory, and when this process is interrupted or ends.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from typing import IO

from linkwright.stages.robot.errors import ConfigError, LinkwrightError, SourceError
from linkwright.stages.robot.system import process_usage

_MAIN = Path(__file__).with_name("guestmain.py")
_PACKAGE = str(Path(__file__).parents[3])
"""The folder that holds `stages`."""

_LOADER_VARIABLES = ("LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH", "DYLD_FALLBACK_LIBRARY_PATH")
"""Variables without which Python may not start; a guest does not see them."""

_WINDOWS_VARIABLES = ("SYSTEMROOT", "SYSTEMDRIVE", "TEMP", "TMP")

_ERRORS: Mapping[str, type[LinkwrightError]] = {"SourceError": SourceError, "ConfigError": ConfigError}
_REPLY_KINDS = (b"R", b"E")
"""First byte of a reply, and of an error."""

_HEADER_SIZE = 9
"""Number of bytes before a reply: its kind and its length."""

_CHECK_INTERVAL = 0.05
"""The interval of checks of a guest's time and memory [s]."""

_PS_CHECK_INTERVAL = 0.5
"""The same interval where each check starts the program `ps` [s]."""

_PATIENCE = 5.0
"""Longest time [s] that a guest may take to end, and by which its own timer outlasts our limit."""

_MAX_KEPT_MEMORY = 0.25
"""Largest share of the memory limit that a process may use after a reply; above it, it is not used again."""

_MAX_LINE_LENGTH = 200
_MAX_TEXT_LENGTH = 2000

ONE_THREAD = dict.fromkeys(
    (
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "BLIS_NUM_THREADS",
        "VECLIB_MAXIMUM_THREADS",
        "NUMEXPR_NUM_THREADS",
    ),
    "1",
)
"""Variables for a guest that computes: more threads gain nothing, and the order of their sums is not ours."""


@dataclass(frozen=True, slots=True)
class Bounds:
    """Limits of a guest: time [s], resident memory and the length of its reply [bytes].

    The time is that of the wall clock. For a guest that only computes it is processor time instead, with
    `wall_time_factor` times as much wall time, so that a busy machine gives the same results. If a system
    does not show the memory of a process (Windows), time alone is bounded.
    """

    seconds: float
    memory: int
    reply: int
    wall_time_factor: float = 1.0


class Ended(Exception):
    """A guest ended without a reply; the text follows its name in a sentence: "took longer than 60 s"."""


class _BrokenProcess(Ended):
    """An end of a guest that an earlier request may have caused."""


class Guest:
    """A process that answers request after request, of one thread at a time.

    It starts with the first request, and again after each that it does not survive; its owner closes it. It
    also ends when another thread sets `halt`.
    """

    def __init__(
        self, module: str, bounds: Bounds, environ: Mapping[str, str], halt: threading.Event | None = None
    ) -> None:
        self._module, self._bounds, self._halt = module, bounds, halt
        self._environ = {**_own_variables(_WINDOWS_VARIABLES), **environ}
        self._process: _Process | None = None

    def ask(self, request: bytes) -> bytes:
        """Returns the reply of `module` to `request`, in a process with the variables `environ` and, on
        Windows, the few that the system needs.

        Raises the guest's own SourceError or ConfigError, and Ended if there is no complete reply, also
        because another thread sets `halt`.
        """
        is_reused = self._process is not None
        try:
            return self._answer(request)
        except _BrokenProcess:
            if not is_reused:
                raise
        # An earlier request may have broken the process: each has the same result whatever came before it.
        return self._answer(request)

    def _answer(self, request: bytes) -> bytes:
        self._process = process = self._process or _Process(self._module, self._environ, self._bounds)
        try:
            reply = process.reply(request, self._halt)
        except BaseException:
            self.close()
            raise
        if process.resident() > _MAX_KEPT_MEMORY * self._bounds.memory:
            self.close()
        return reply

    def close(self) -> None:
        """Ends the process with all that it started; no process is left behind."""
        if self._process is not None:
            self._process.end()
            self._process = None


def ask(
    module: str,
    request: bytes,
    bounds: Bounds,
    environ: Mapping[str, str],
    halt: threading.Event | None = None,
) -> bytes:
    """Returns the reply of a guest that gets only this request."""
    with contextlib.closing(Guest(module, bounds, environ, halt)) as guest:
        return guest.ask(request)


class _Process:
    """A process, with a thread for each of its three streams."""

    def __init__(self, module: str, environ: Mapping[str, str], bounds: Bounds) -> None:
        self._bounds = bounds
        self._output = bytearray()
        self._error_output = bytearray()
        self._replied = threading.Event()
        self._requests: SimpleQueue[bytes] = SimpleQueue()
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-I", "-X", "utf8", str(_MAIN)],
                env={**_own_variables(_LOADER_VARIABLES), **environ},
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                bufsize=0,
                start_new_session=True,
            )
        except OSError as error:
            raise Ended(f"could not be started ({error.strerror or type(error).__name__})") from None
        head = {
            "module": module,
            "package": _PACKAGE,
            "path": _libraries(),
            "seconds": bounds.wall_time_factor * bounds.seconds + _PATIENCE,
            "parent": os.getpid(),
            "environ": sorted(environ),
        }
        self._requests.put(json.dumps(head).encode() + b"\n")
        self._start_thread(self._send)
        self._start_thread(self._read_output)
        self._error_reader = self._start_thread(self._read_errors)

    def reply(self, request: bytes, halt: threading.Event | None) -> bytes:
        """Returns the guest's reply. Raises its own error, and Ended if there is no complete reply."""
        if self._output:
            raise _BrokenProcess("replied before it was asked")
        started, computed_before = time.monotonic(), process_usage.processor_time(self._process.pid, 0.0)
        self._requests.put(len(request).to_bytes(8, "big") + request)
        interval = _CHECK_INTERVAL if process_usage.has_memory_files() else _PS_CHECK_INTERVAL
        while not self._replied.wait(interval):
            if halt is not None and halt.is_set():
                raise Ended("was interrupted")
            if self._counted_time(time.monotonic() - started, computed_before) > self._bounds.seconds:
                raise Ended(f"took longer than {self._bounds.seconds:g} s")
            if self.resident() > self._bounds.memory:
                raise _BrokenProcess(f"needed more than {self._bounds.memory / 1e9:.3g} GB of memory")
        kind, length = bytes(self._output[:1]), int.from_bytes(self._output[1:_HEADER_SIZE], "big")
        body = bytes(self._output[_HEADER_SIZE:])
        if len(body) > self._bounds.reply:
            raise Ended(f"made more than {self._bounds.reply / 1e6:.3g} MB")
        if kind not in _REPLY_KINDS or len(body) != length:
            raise _BrokenProcess(self._explain_end())
        if kind == b"E":
            raise _error(body)
        self._replied.clear()
        self._output.clear()
        self._error_output.clear()
        return body

    def resident(self) -> int:
        """Returns the resident memory of the process [bytes]."""
        return process_usage.resident_memory(self._process.pid)

    def _counted_time(self, passed: float, computed_before: float) -> float:
        """Returns the time [s] that counts of the wall time `passed`; `computed_before`: the processor time
        at its beginning."""
        if self._bounds.wall_time_factor == 1.0:
            return passed
        computed = process_usage.processor_time(self._process.pid, computed_before + passed) - computed_before
        return max(passed / self._bounds.wall_time_factor, min(computed, passed))

    def end(self) -> None:
        """Kills the process with all that it started, and waits for its end."""
        self._requests.put(b"")
        with contextlib.suppress(OSError):
            if hasattr(os, "killpg"):
                os.killpg(self._process.pid, signal.SIGKILL)
            else:
                self._process.kill()
        self._process.wait()

    def _start_thread(self, work: Callable[[], None]) -> threading.Thread:
        thread = threading.Thread(target=work, name="guest", daemon=True)
        thread.start()
        return thread

    def _send(self) -> None:
        """Sends the requests in the queue, until an empty request."""
        with contextlib.suppress(OSError), _stream(self._process.stdin) as stream:
            while rest := memoryview(self._requests.get()):
                while rest:
                    rest = rest[stream.write(rest) :]

    def _read_output(self) -> None:
        with contextlib.suppress(OSError), _stream(self._process.stdout) as stream:
            max_size = self._bounds.reply + _HEADER_SIZE
            while len(self._output) <= max_size and (piece := stream.read(1 << 20)):
                self._output += piece
                if self._is_complete():
                    self._replied.set()
        self._replied.set()

    def _is_complete(self) -> bool:
        """Tells whether the output holds a whole reply, or does not begin as a reply."""
        if self._output[:1] not in _REPLY_KINDS:
            return True
        return len(self._output) >= _HEADER_SIZE + int.from_bytes(self._output[1:_HEADER_SIZE], "big")

    def _read_errors(self) -> None:
        """Keeps the end of the guest's other output."""
        with contextlib.suppress(OSError), _stream(self._process.stderr) as stream:
            while piece := stream.read(1 << 16):
                self._error_output[:] = (self._error_output + piece)[-4096:]

    def _explain_end(self) -> str:
        """Ends the input, waits for the end of the process, and returns how it ended, in words."""
        self._requests.put(b"")
        self._error_reader.join(_PATIENCE)
        try:
            status = self._process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            return "gave no reply"
        if status < 0:
            name = signal.Signals(-status).name if -status in list(signal.Signals) else str(-status)
            # `pipeline.checking.guest` bounds its processor time by ITIMER_PROF, which sends SIGPROF.
            if name == "SIGPROF":
                return "used more processor time than the sizes of its files explain"
            return f"crashed ({name})"
        lines = self._error_output.decode("utf-8", "replace").strip().splitlines()
        return f"failed ({lines[-1][:_MAX_LINE_LENGTH]})" if lines else f"ended with status {status}"


def _stream(pipe: IO[bytes] | None) -> IO[bytes]:
    assert pipe is not None
    return pipe


def _own_variables(names: Iterable[str]) -> dict[str, str]:
    """Returns the variables of this process with these names."""
    return {name: os.environ[name] for name in names if name in os.environ}


def _libraries() -> list[str]:
    """Returns the library path of this process, without the working folder and the script's folder."""
    left_out = {os.path.abspath(""), os.path.dirname(os.path.abspath(sys.argv[0]))}  # noqa: PTH100, PTH120
    folders = [os.path.abspath(place) for place in sys.path if place]  # noqa: PTH100
    return list(dict.fromkeys(place for place in folders if place not in left_out))


def _error(body: bytes) -> LinkwrightError:
    """Returns the error that a guest reports. Raises Ended if the report is invalid."""
    try:
        fields = json.loads(body)
        kind = _ERRORS[fields["kind"]]
        message, where, hint = (str(fields[name])[:_MAX_TEXT_LENGTH] for name in ("message", "where", "hint"))
    except (ValueError, KeyError, TypeError, RecursionError):
        raise Ended("reported an invalid error") from None
    return kind(message, where, hint)
