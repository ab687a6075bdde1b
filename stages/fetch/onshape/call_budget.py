"""Limits the number of API calls that a build, or a whole sweep, may make (`source.max_calls`).

Onshape has a yearly quota of calls, so a build reports the number of calls before it makes them, and
makes none where the user allows fewer.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

from linkwright.stages.robot.errors import SourceError
from linkwright.stages.robot.text.plural import count


class Budget:
    """The calls that a build may make, repeated requests included. Safe to use from several threads.

    `before`: the calls that the sweep made before this build; None for a single build.

    A call takes its slot before it is made, so that concurrent calls cannot exceed the budget together.
    """

    def __init__(self, limit: int | None, before: int | None = None) -> None:
        self.made = 0
        """Calls that count against the quota so far."""
        self._limit = limit
        self._before = before
        self._open = 0
        self._lock = Lock()

    @contextmanager
    def slot(self, *, needed: bool = False) -> Iterator["CallSlot"]:
        """Yields a slot for a call. Raises SourceError if no call is left, unless the call must be made
        (`needed`)."""
        with self._lock:
            if self._limit is not None and not needed:
                allow(self._open + 1, self.made, self._limit, self._before)
            self._open += 1
        slot = CallSlot(self)
        try:
            yield slot
        finally:
            slot.charge(0)

    def charge(self, calls: int) -> None:
        """Returns a slot and counts the cost of the call, in one step: no thread may see it counted twice."""
        with self._lock:
            self._open -= 1
            self.made += calls


class CallSlot:
    """The slot of a call in a budget, charged once."""

    def __init__(self, budget: Budget) -> None:
        self._budget: Budget | None = budget

    def charge(self, calls: int) -> None:
        """Counts the `calls` that this call cost; a second charge changes nothing."""
        budget, self._budget = self._budget, None
        if budget is not None:
            budget.charge(calls)


def allow(more: int, made: int, limit: int, before: int | None = None) -> None:
    """Raises SourceError if `more` calls besides those `made` would be more than `limit`. `before`: as in
    `Budget`."""
    spender = "build" if before is None else "sweep"
    made += before or 0
    if made + more <= limit:
        return
    needs = f"made {count(made, 'call')} and needs {more} more" if made else f"needs {count(more, 'call')}"
    msg = f"this {spender} {needs}, but source.max_calls is {limit}"
    note = "; what was fetched is kept" if made else ""
    hint = f"set source.max_calls={made + more} or more{note}"
    raise SourceError(msg, "source.max_calls", hint)
