"""Imports the modules of later stages in a thread while the fetch stage waits for the network."""

import contextlib
from collections.abc import Iterable
from importlib import import_module
from threading import Event, Lock, Thread


class Ahead:
    """Imports `modules` in a thread, which the first `start` starts."""

    def __init__(self, modules: Iterable[str]) -> None:
        self._modules = tuple(modules)
        self._thread: Thread | None = None
        self._lock = Lock()
        self.ending = Event()

    def start(self) -> None:
        """Starts the thread once; returns immediately."""
        with self._lock:
            if self._thread is None:
                self._thread = Thread(target=self._run, name="imports", daemon=True)
                self._thread.start()

    def wait(self) -> None:
        """Waits until the imports end, so that none runs during a stage."""
        if self._thread is not None:
            self._thread.join()

    def __enter__(self) -> "Ahead":
        return self

    def __exit__(self, *_: object) -> None:
        """Begins no further import, and waits for the one that runs.

        For a build that fails: a process that ends while a library is being loaded may crash.
        """
        self.ending.set()
        self.wait()

    def _run(self) -> None:
        for module in self._modules:
            if self.ending.is_set():
                return
            # The stage that needs the module reports the error.
            with contextlib.suppress(Exception):
                import_module(module)
