"""Shows the progress of long downloads a few times a second."""

import time
from collections.abc import Callable
from threading import Lock

_MIN_SHOWN = 1_000_000
"""Size below which a download is not shown [bytes]."""

_MIN_INTERVAL = 0.2
"""Shortest time between two lines [s]."""


class DownloadProgress:
    """A counter of received bytes, in any thread, which passes a line about them to `transient`."""

    def __init__(self, transient: Callable[[str], None]) -> None:
        self._transient = transient
        self._lock = Lock()
        self._size, self._shown = 0, 0.0

    def add(self, size: int) -> None:
        """Counts a piece of a reply [bytes]."""
        with self._lock:
            self._size += size
            now = time.monotonic()
            if self._size < _MIN_SHOWN or now - self._shown < _MIN_INTERVAL:
                return
            self._shown = now
            self._transient(f"{self._size / 1e6:.1f} MB received")
