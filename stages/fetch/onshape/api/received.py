"""Shows the progress of long downloads a few times a second."""

import time
from collections.abc import Callable
from threading import Lock

_LONG = 1_000_000
"""Smaller downloads are not shown [bytes]."""

_INTERVAL = 0.2
"""The least time between two lines [s]."""


class Received:
    """Counts received bytes, in any thread, and passes a line about them to `transient`."""

    def __init__(self, transient: Callable[[str], None]) -> None:
        self._transient = transient
        self._lock = Lock()
        self._size, self._shown = 0, 0.0

    def add(self, size: int) -> None:
        """Counts a piece of a reply [bytes]."""
        with self._lock:
            self._size += size
            now = time.monotonic()
            if self._size < _LONG or now - self._shown < _INTERVAL:
                return
            self._shown = now
            self._transient(f"{self._size / 1e6:.1f} MB received")
