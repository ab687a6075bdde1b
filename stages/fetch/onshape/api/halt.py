"""Stops all calls of a client: after a stop no call begins."""

import threading

from linkwright.stages.robot.errors import Offline, QuotaExhausted, RateLimited


class Halt:
    """The stopped or running state of a client's calls; `stopped` is set with the first reason. Safe to use
    from several threads."""

    def __init__(self) -> None:
        self.stopped = threading.Event()
        self._lock = threading.Lock()
        self._reason: QuotaExhausted | RateLimited | Offline | None = None

    def stop(self, reason: QuotaExhausted | RateLimited | Offline) -> None:
        """Stops all calls; the first reason counts."""
        with self._lock:
            self._reason = self._reason or reason
        self.stopped.set()

    def check(self) -> None:
        """Raises the reason if all calls were stopped."""
        if self._reason is not None:
            raise type(self._reason)(self._reason.message, self._reason.where, self._reason.hint)
