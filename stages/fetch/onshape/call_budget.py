"""The call budget: how many API calls a build may make (`source.max_calls`).

Onshape has a yearly quota of calls, so a build reports the number of calls before it makes them, and
makes none where the user allows fewer.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

from linkwright.stages.robot.errors import SourceError
from linkwright.stages.robot.text.plural import count


class Budget:
    """The calls that one build may make, repeated requests included. Safe to use from several threads.

    A call takes its slot before it is made, so that concurrent calls cannot exceed the budget
    together.
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
        """Returns a slot and counts what the call cost, in one step: no thread may see it counted twice."""
        with self._lock:
            self._open -= 1
            self.made += calls


class CallSlot:
    """One call's slot in a budget, charged once."""

    def __init__(self, budget: Budget) -> None:
        self._budget: Budget | None = budget

    def charge(self, calls: int) -> None:
        """Counts the `calls` that this call cost; a second charge changes nothing."""
        budget, self._budget = self._budget, None
        if budget is not None:
            budget.charge(calls)


def allow(more: int, made: int, limit: int) -> None:
    """SourceError where `more` calls besides those `made` would be more than `limit`."""
    if made + more <= limit:
        return
    needs = f"made {count(made, 'call')} and needs {more} more" if made else f"needs {count(more, 'call')}"
    msg = f"this build {needs}, but source.max_calls is {limit}"
    kept = "; what was fetched is kept" if made else ""
    hint = f"set source.max_calls={made + more} or more{kept}"
    raise SourceError(msg, "source.max_calls", hint)
