"""Makes any use of the network an error, for results that must be the same everywhere."""

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from linkwright.pipeline.errors import Offline

_NETWORK_EVENTS = ("socket.connect", "socket.getaddrinfo", "socket.gethostbyname", "socket.sendto")
"""Python's audit events that show a use of the network."""


class _Watch:
    """Counts the threads inside `offline`. They share one audit hook, since Python cannot remove a hook."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._thread_count = 0
        self._has_hook = False

    def enter(self) -> None:
        with self._lock:
            self._thread_count += 1
            if not self._has_hook:
                sys.addaudithook(self._refuse_network)
                self._has_hook = True

    def leave(self) -> None:
        with self._lock:
            self._thread_count -= 1

    def _refuse_network(self, event: str, details: tuple[Any, ...]) -> None:
        if not self._thread_count or event not in _NETWORK_EVENTS:
            return
        # A local socket, such as that between processes, has a path for an address.
        address = details[1] if event in ("socket.connect", "socket.sendto") else details[:2]
        if isinstance(address, str | bytes):
            return
        place = ":".join(str(part) for part in address[:2] if part is not None)
        msg = "a snapshot is made without the network, and something reached for it"
        raise Offline(msg, place, "remove what uses the network, such as a plug-in")


_WATCH = _Watch()


@contextmanager
def offline() -> Iterator[None]:
    """Makes any use of the network, in any thread, raise an `Offline` error."""
    _WATCH.enter()
    try:
        yield
    finally:
        _WATCH.leave()
