"""Defines retries: the temporary failures, the numbers of attempts, and the waits between them."""

import functools
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import stamina
from stamina.instrumentation import RetryDetails, set_on_retry_hooks

from linkwright.stages.robot.errors import SourceError

Kind = Literal["free", "billed"]
"""The kind of a failed attempt, by its cost: a reply that begins with 200 is billed however it ends."""


@dataclass(frozen=True, slots=True)
class Patience:
    """The numbers and times of retries of failed calls. Times in seconds."""

    max_wait: float = 120.0
    """Longest total wait that the server may ask for (`Retry-After`)."""

    attempts: int = 3
    """Attempts of a call that fails without being billed (5xx, no connection, no answer)."""

    billed: int = 2
    """Attempts of a call if its reply is billed but unusable (cut short, late, invalid)."""

    refusals: int = 8
    """Attempts of a call that the server's rate limit refuses (429)."""

    first_wait: float = 1.0
    """Wait before the second attempt; doubled each time."""

    longest_wait: float = 30.0
    """Largest wait that the doubling reaches."""

    jitter: float = 1.0
    """Up to this much is added at random, so that several callers do not come back at once."""

    connect: float = 30.0
    """Time limit for connecting to the server."""

    read: float = 300.0
    """Time limit for each pause in a reply; the server may compute large assemblies for minutes."""

    whole: float = 900.0
    """Time limit for a whole reply: 16 MB at 20 kB/s."""


class TemporaryFailure(Exception):
    """The error for a failure that may be temporary. `error`: the error to raise if it persists."""

    def __init__(self, error: SourceError, kind: Kind, progress: Callable[[str], None]) -> None:
        super().__init__(error.message)
        self.error = error
        self.kind: Kind = kind
        self.progress = progress


def persist(once: Callable[[], bytes], patience: Patience) -> bytes:
    """Returns the result of `once`, retried while it raises `TemporaryFailure` and `patience` allows.

    Raises the last failure's own error, with the number of attempts; any other error at once.
    """
    _install_hook()
    limits = {"free": patience.attempts, "billed": patience.billed}
    failures: Counter[Kind] = Counter()

    def must_retry(error: Exception) -> bool:
        if not isinstance(error, TemporaryFailure):
            return False
        failures[error.kind] += 1
        return failures[error.kind] < limits[error.kind]

    caller = stamina.RetryingCaller(
        attempts=sum(limits.values()),
        timeout=None,
        wait_initial=patience.first_wait,
        wait_max=patience.longest_wait,
        wait_jitter=patience.jitter,
    )
    try:
        return caller(must_retry, once)
    except TemporaryFailure as last:
        error, times = last.error, failures.total()
        message = error.message if times == 1 else f"{error.message}; tried {times} times"
        raise type(error)(message, error.where, error.hint) from last.__cause__


@functools.cache
def _install_hook() -> None:
    """Replaces the library's own logging of retries, which would write past the display."""
    set_on_retry_hooks([_announce])


def _announce(details: RetryDetails) -> None:
    """Reports a coming attempt."""
    if isinstance(details.caused_by, TemporaryFailure):
        error = details.caused_by.error
        details.caused_by.progress(f"{error.message}; trying again in {details.wait_for:.0f} s")
