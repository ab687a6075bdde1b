"""Tracks the server's rate limits: the calls left of each kind, and the wait if none is left.

The limits are per endpoint. A wait delays all calls of its kind in all threads, and
the total wait stays within `source.max_wait`.
"""

import time
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime
from threading import Event, Lock


class RateLimits:
    """The rate limits of a server, as its replies report them. `max_wait` [s] limits the total wait."""

    def __init__(self, max_wait: float, stopped: Event) -> None:
        self._max_wait = max_wait
        self._stopped = stopped
        self._lock = Lock()
        self._closed_until: dict[str, float] = {}
        self._until = 0.0
        self.waited = 0.0
        """Total wait so far [s]; concurrent waits count once."""
        self.calls_left: dict[str, int] = {}
        """Calls left by endpoint, where the server reports them (`X-Rate-Limit-Remaining`)."""

    def note(self, endpoint: str, calls_left: int | None) -> None:
        """Records the calls left that a reply reports."""
        if calls_left is not None:
            with self._lock:
                self.calls_left[endpoint] = calls_left

    def close(self, endpoint: str, seconds: float) -> bool:
        """Delays calls of this kind by `seconds`; returns False if that exceeds the allowed wait."""
        now = time.monotonic()
        with self._lock:
            until = max(self._until, now + seconds)
            extra_wait = until - max(self._until, now)
            if self.waited + extra_wait > self._max_wait:
                return False
            self.waited += extra_wait
            self._until = until
            self._closed_until[endpoint] = max(self._closed_until.get(endpoint, 0.0), now + seconds)
            return True

    def wait(self, endpoint: str, *, stoppable: bool = True) -> None:
        """Waits until a call of this kind may be made; if `stoppable`, also ends when all calls were
        stopped."""
        stopped = self._stopped if stoppable else Event()
        while not stopped.is_set():
            with self._lock:
                seconds = self._closed_until.get(endpoint, 0.0) - time.monotonic()
            if seconds <= 0:
                return
            stopped.wait(seconds)


def remaining_calls(headers: Mapping[str, str]) -> int | None:
    """Returns the calls left for the endpoint that replied, if the server reports them."""
    text = headers.get("X-Rate-Limit-Remaining", "").strip()
    return int(text) if text.isascii() and text.isdigit() and len(text) < 10 else None


def retry_after(headers: Mapping[str, str], now: Callable[[], float] = time.time) -> float | None:
    """Returns the time to wait [s], from seconds or an HTTP date; None without such a header.

    A date is compared with the server's own clock if the server sends it (`Date`).
    """
    text = headers.get("Retry-After", "").strip()
    if text.isascii() and text.isdigit() and len(text) < 10:
        return float(text)
    then = date(text)
    if then is None:
        return None
    server_time = date(headers.get("Date", ""))
    return max(0.0, then - (now() if server_time is None else server_time))


def date(text: str) -> float | None:
    """Returns an HTTP date as seconds since 1970; None if it is not a date."""
    try:
        moment = parsedate_to_datetime(text)
    except (ValueError, TypeError, IndexError, OverflowError):
        return None
    aware: datetime = moment if moment.tzinfo else moment.replace(tzinfo=UTC)
    return aware.timestamp()
