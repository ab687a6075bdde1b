"""The plan of calls: how many a build still needs, and whether it may make them.

Onshape counts calls by the year, so a build reports what it is about to spend before it does, and
spends nothing where the user allows less.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

from stages.robot.errors import SourceError


class Budget:
    """What one build may spend, whatever has to be asked again. Safe to use from several threads.

    A call takes its slot before it is made, so that calls on their way at the same time cannot
    overdraw it together.
    """

    def __init__(self, limit: int | None) -> None:
        self.made = 0
        """Calls that count against the quota so far."""
        self._limit = limit
        self._open = 0
        self._lock = Lock()

    @contextmanager
    def slot(self, *, needed: bool = False) -> Iterator["CallSlot"]:
        """A slot for one call; SourceError where none is left, unless the call must be made (`needed`)."""
        with self._lock:
            if self._limit is not None and not needed:
                allow(self._open + 1, self.made, self._limit)
            self._open += 1
        slot = CallSlot(self)
        try:
            yield slot
        finally:
            slot.charge(0)

    def charge(self, calls: int) -> None:
        """Gives up a slot for what the call came to. Both at once: nobody may see it counted twice."""
        with self._lock:
            self._open -= 1
            self.made += calls


class CallSlot:
    """One call's slot in a budget, charged once."""

    def __init__(self, budget: Budget) -> None:
        self._budget: Budget | None = budget

    def charge(self, calls: int) -> None:
        """The call came to so many `calls`; a second charge changes nothing."""
        budget, self._budget = self._budget, None
        if budget is not None:
            budget.charge(calls)


def allow(more: int, made: int, limit: int) -> None:
    """SourceError where `more` calls besides those `made` would be more than `limit`."""
    if made + more <= limit:
        return
    needs = f"made {count(made, 'call')} and needs {more} more" if made else f"needs {count(more, 'call')}"
    msg = f"this build {needs}, but it may make {limit}"
    kept = "; what was fetched is kept" if made else ""
    hint = f"set source.max_calls={made + more} or more to allow it{kept}"
    raise SourceError(msg, "source.max_calls", hint)


def count(number: int, noun: str) -> str:
    """A number with its noun: "1 call", "2 calls"."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
