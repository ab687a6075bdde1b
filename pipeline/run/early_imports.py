"""Imports the modules of later stages in a thread while the fetch stage waits for the network."""

import contextlib
from collections.abc import Iterable, Mapping
from importlib import import_module
from threading import Event, Lock, Thread


class EarlyImports:
    """Imports the modules of the stages in a thread, stage after stage, from the first `start` on."""

    def __init__(self, modules: Mapping[str, Iterable[str]]) -> None:
        self._modules = {stage: tuple(names) for stage, names in modules.items()}
        self._imported = {stage: Event() for stage in modules}
        self._thread: Thread | None = None
        self._lock = Lock()
        self.ending = Event()

    def start(self) -> None:
        """Starts the thread once; returns immediately."""
        with self._lock:
            if self._thread is None:
                self._thread = Thread(target=self._run, name="imports", daemon=True)
                self._thread.start()

    def wait(self, stage: str) -> None:
        """Waits until the modules of a stage are imported, so that two threads never import the same module.
        The modules of later stages are imported while the stage runs."""
        if self._thread is not None:
            self._imported[stage].wait()

    def __enter__(self) -> "EarlyImports":
        return self

    def __exit__(self, *_: object) -> None:
        """Begins no further import, and waits for the running import.

        This matters for builds that fail: a process that ends while it loads a library may crash.
        """
        self.ending.set()
        if self._thread is not None:
            self._thread.join()

    def _run(self) -> None:
        for stage, modules in self._modules.items():
            for module in modules:
                if self.ending.is_set():
                    break
                # The stage that needs the module reports the error.
                with contextlib.suppress(Exception):
                    import_module(module)
            self._imported[stage].set()
