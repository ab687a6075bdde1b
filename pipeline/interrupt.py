"""Ctrl-C during a sweep in many processes ends this one, which ends the others."""

import _thread
import contextlib
import signal
import threading
from collections.abc import Iterator

LOOK = 0.1
"""Interval [s] at which the watcher checks whether the sweep is over."""


@contextlib.contextmanager
def kept_from_workers() -> Iterator[None]:
    """Processes started inside do not receive Ctrl-C; in this process it still raises KeyboardInterrupt.

    The terminal sends the signal to all processes, and each worker would print a traceback. Child processes
    inherit a blocked signal, so it is blocked here, and a thread waits for it.
    """
    if not hasattr(signal, "pthread_sigmask") or threading.current_thread() is not threading.main_thread():
        yield
        return
    over = threading.Event()

    def watch() -> None:
        while not over.wait(LOOK):
            if signal.SIGINT in signal.sigpending():
                signal.sigwait({signal.SIGINT})
                _thread.interrupt_main()

    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    watcher = threading.Thread(target=watch, name="interrupt", daemon=True)
    watcher.start()
    try:
        yield
    finally:
        over.set()
        watcher.join()
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
