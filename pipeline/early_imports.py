"""Imports beside the network: what the later stages need is loaded while replies are on their way."""

import contextlib
from collections.abc import Iterable
from importlib import import_module
from threading import Lock, Thread


class Ahead:
    """Imports `modules` in a thread of its own, from the first `start` on."""

    def __init__(self, modules: Iterable[str]) -> None:
        self._modules = tuple(modules)
        self._thread: Thread | None = None
        self._lock = Lock()

    def start(self) -> None:
        """Begins, if that was not done before; returns at once."""
        with self._lock:
            if self._thread is None:
                self._thread = Thread(target=self._run, name="imports", daemon=True)
                self._thread.start()

    def wait(self) -> None:
        """Returns when everything that was begun is imported: no import runs beside a stage."""
        if self._thread is not None:
            self._thread.join()

    def _run(self) -> None:
        for module in self._modules:
            # Whoever needs the module hears what is wrong with it.
            with contextlib.suppress(Exception):
                import_module(module)
