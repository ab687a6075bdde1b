"""Ends a command with exit status 130 after Ctrl-C, wherever it comes.

Python raises KeyboardInterrupt between any two instructions, and so also where it is lost: in a `__del__` or
a callback, where Python only prints it, and below a library that makes another error of it. So a command
records that Ctrl-C came, asks at each step of a build (`check`), and treats each later error as its result
(`is_cause_of`). Some compiled libraries crash where their first import is interrupted (orjson, as of 3.13.0),
so Ctrl-C waits until such an import ends. In a program that imports linkwright the signals are that
program's.
"""

import _thread
import contextlib
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from importlib.machinery import ExtensionFileLoader
from types import FrameType

STATUS = 130
"""The exit status of a command that Ctrl-C ended."""

MESSAGE = "error: interrupted"

FINISHED = (0, 3)
"""The exit statuses of a command that finished its work."""

WATCH_INTERVAL = 0.1
"""Interval [s] at which the watcher checks whether the sweep is over."""

RETRY_INTERVAL = 0.01
"""Time [s] after which a Ctrl-C during the import of a compiled module is raised again."""

COMPILED_IMPORTS = (ExtensionFileLoader.create_module.__code__, ExtensionFileLoader.exec_module.__code__)
"""The code that runs while Python imports a compiled module."""

_CAME = threading.Event()


def command(run: Callable[[], int]) -> int:
    """Runs a command, the last thing that this process does; returns its exit status.

    A command that finished although Ctrl-C came has its own status, and its output says that it finished.
    """
    try:
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, _handle_signal)
        status = run()
        # The status is final: to end the process now would contradict its output.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        print(MESSAGE, file=sys.stderr)
        return STATUS
    return STATUS if _CAME.is_set() and status not in FINISHED else status


def _handle_signal(number: int, frame: FrameType | None) -> None:
    """Records Ctrl-C, and raises KeyboardInterrupt now, or later if a compiled module is being imported."""
    _CAME.set()
    if not _in_compiled_import(frame):
        raise KeyboardInterrupt
    timer = threading.Timer(RETRY_INTERVAL, _thread.interrupt_main)
    timer.daemon = True
    timer.start()


def _in_compiled_import(frame: FrameType | None) -> bool:
    """Tells whether a frame belongs to the first import of a compiled module."""
    while frame is not None:
        if frame.f_code in COMPILED_IMPORTS:
            return True
        frame = frame.f_back
    return False


def has_come() -> bool:
    """Tells whether the user has pressed Ctrl-C."""
    return _CAME.is_set()


def check() -> None:
    """Raises KeyboardInterrupt again if Ctrl-C came and was lost.

    Call it before a step begins, and before a result is stored: the lost exception may have left the result
    incomplete. Do not call it while cleaning up.
    """
    if _CAME.is_set():
        raise KeyboardInterrupt


def is_cause_of(error: BaseException | None) -> bool:
    """Tells whether Ctrl-C is the cause of an error."""
    # An error that is raised again from what it caused is its own context: the chain may be a ring.
    visited: set[int] = set()
    while error is not None and id(error) not in visited and not _CAME.is_set():
        if isinstance(error, KeyboardInterrupt):
            return True
        visited.add(id(error))
        error = error.__cause__ or error.__context__
    return _CAME.is_set()


@contextlib.contextmanager
def kept_from_workers() -> Iterator[None]:
    """Keeps Ctrl-C from processes that start in the block; here it still raises KeyboardInterrupt.

    The terminal sends the signal to all processes, and each worker would print a traceback. Child processes
    inherit a blocked signal, so it is blocked here, and a thread waits for it.
    """
    if not hasattr(signal, "pthread_sigmask") or threading.current_thread() is not threading.main_thread():
        yield
        return
    ended = threading.Event()

    def watch() -> None:
        while not ended.wait(WATCH_INTERVAL):
            if signal.SIGINT in signal.sigpending():
                signal.sigwait({signal.SIGINT})
                _thread.interrupt_main()

    old_mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    watcher = threading.Thread(target=watch, name="interrupt", daemon=True)
    watcher.start()
    try:
        yield
    finally:
        ended.set()
        watcher.join()
        signal.pthread_sigmask(signal.SIG_SETMASK, old_mask)
