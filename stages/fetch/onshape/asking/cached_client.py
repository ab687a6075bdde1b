"""Answers requests from cached replies first, then from the server: each reply is billed once, also among
several processes."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from threading import Lock
from typing import Any

from linkwright.stages.fetch.onshape.api.http_errors import Declined
from linkwright.stages.fetch.onshape.api.threads import run_all
from linkwright.stages.fetch.onshape.asking.session import ReplyCheck, Session
from linkwright.stages.fetch.onshape.call_budget import allow
from linkwright.stages.fetch.onshape.replies.store import ReplyStore
from linkwright.stages.fetch.onshape.requests import API, api, describe, is_definition
from linkwright.stages.fetch.source import SweepState
from linkwright.stages.robot.errors import NotFound, Offline, ProtocolError
from linkwright.stages.robot.text.plural import count

RefusalErrors = dict[str, NotFound | Declined]
"""Request → the error that refused it."""

_MAX_NAMED = 3
"""Largest number of missing requests that an error names."""


class CachedClient:
    """A client that answers requests, from cached replies first.

    `offline`: no call is made; `refresh`: replies that earlier builds cached are fetched again; `max_calls`:
    the largest number of calls of a build; `sweep`: the state that the fetches of a sweep share.
    """

    def __init__(
        self,
        session: Session,
        replies: ReplyStore,
        *,
        offline: bool,
        refresh: bool,
        max_calls: int,
        sweep: SweepState | None = None,
    ) -> None:
        self._session = session
        self._replies = replies
        self._refresh = refresh
        self._max_calls = max_calls
        self._lock = Lock()
        self._sweep_requests = sweep.asked if sweep else set()
        self._refetched: set[str] = set()
        self._checks: dict[str, ReplyCheck] = {}
        self._checked: set[str] = set()
        self.offline = offline
        self.saved = 0
        """Calls that cached replies saved."""
        self.sweep = sweep
        self.undisturbed: Callable[[], AbstractContextManager[None]] = nullcontext
        """A context in which the workspace has its users' values: no build has changed its variables."""
        self.while_waiting: Callable[[], None] = lambda: None
        """Called, perhaps several times, before replies are requested for the first time."""

    def lookup(self, request: str) -> bytes | None:
        """Returns the cached reply to a pinned request, or None; a reply without its required content counts
        as None."""
        with self._lock:
            if (self._refresh or request in self._refetched) and request not in self._sweep_requests:
                return None
            body = self._replies.get(request)
        check = None if request in self._checked else self._checks.get(request)
        if body is None or check is None:
            return body
        try:
            check(body)
        except ProtocolError:
            return None
        self._checked.add(request)
        return body

    def require(self, request: str, check: ReplyCheck) -> None:
        """Requires that the reply to a request fulfils `check`; otherwise it is neither used nor cached."""
        self._checks[request] = check

    def keep(self, request: str, body: bytes) -> None:
        """Caches the reply to a pinned request; for a definition also the API version."""
        with self._lock:
            self._sweep_requests.add(request)
            if is_definition(request):
                self._replies.remember(f"{request}#api", {"api": api(request)})
            self._replies.put(request, body)

    def api(self, request: str) -> str:
        """Returns the API version of the cached reply to a request for a definition."""
        return str(self.recall(f"{request}#api").get("api", API))

    def refetch(self, requests: Iterable[str]) -> None:
        """Makes this build fetch these requests again, although replies are cached."""
        with self._lock:
            self._refetched.update(requests)

    def count_saved(self, calls: int) -> None:
        """Records that cached replies saved `calls`."""
        with self._lock:
            self.saved += calls

    @property
    def calls_made(self) -> int:
        """The calls made so far that count against the quota."""
        return self._session.calls

    def allow(self, more: int) -> None:
        """Raises SourceError if `more` further calls exceed the budget of the build."""
        allow(more, self._session.calls, self._max_calls, self.sweep.made if self.sweep else None)

    @property
    def may_call(self) -> bool:
        """Whether this build may call the server: it is not offline, and there is a key."""
        return not self.offline and self._session.has_key()

    def affords(self, more: int) -> bool:
        """Tells whether `more` further calls are within the budget of the build."""
        earlier_calls = self.sweep.made if self.sweep else 0
        return earlier_calls + self._session.calls + more <= self._max_calls

    def uncached_reply(self, request: str) -> bytes:
        """Fetches, and does not cache, the reply to a request whose reply changes with time."""
        self._require_online([request])
        self.allow(1)
        return self._session.ask(request)

    def reply(self, request: str) -> bytes:
        """Returns the reply to a pinned request: cached, or else fetched and cached."""
        return self.all([request])[request]

    def all(self, needed: Sequence[str], refused: RefusalErrors | None = None) -> dict[str, bytes]:
        """Returns the replies to pinned requests, made a few at a time.

        After a failure no further call begins, but running calls are finished and cached, since they are
        billed. Of several failures the first in order is raised. With `refused`, failures of a single request
        are stored there, and the replies that arrived are returned.
        """
        lookup = {request: self.lookup(request) for request in needed}
        bodies = {request: body for request, body in lookup.items() if body is not None}
        missing = [request for request in needed if request not in bodies]
        self.count_saved(sum(request not in self._sweep_requests for request in bodies))
        if not missing:
            return bodies
        self._require_online(missing)
        self.allow(len(missing))
        self._session.ready()
        self.while_waiting()
        try:
            futures = run_all([partial(self._once, request) for request in missing], self._session.at_once)
        except BaseException:
            # Interrupted: no call is repeated, and no call waits for its turn.
            self._session.stop()
            raise
        for request, future in zip(missing, futures, strict=True):
            if future.cancelled():
                continue
            error = future.exception()
            if error is None:
                bodies[request] = future.result()
            elif refused is not None and isinstance(error, NotFound | Declined):
                refused[request] = error
            else:
                raise error
        return bodies

    def recall(self, subject: str) -> Mapping[str, Any]:
        """Returns the record stored for a subject; empty if there is none."""
        with self._lock:
            return self._replies.recall(subject) or {}

    def remember(self, subject: str, fact: Mapping[str, Any]) -> None:
        """Stores a record for a subject."""
        with self._lock:
            self._replies.remember(subject, fact)

    def lock(self, subject: str) -> AbstractContextManager[None]:
        """Returns a lock for each subject: one build at a time."""
        return self._replies.lock(subject)

    def _once(self, request: str) -> bytes:
        """Returns the reply to a request that another build may be fetching at the same time."""
        with self.lock(request):
            body = self.lookup(request)
            if body is not None:
                self.count_saved(1)
                return body
            body = self._session.ask(request, self._checks.get(request))
            self.keep(request, body)
            return body

    def _require_online(self, missing: Sequence[str]) -> None:
        if not self.offline:
            return
        names = [describe(request) for request in missing[:_MAX_NAMED]]
        if len(missing) > _MAX_NAMED:
            names[-1] += f" and {len(missing) - _MAX_NAMED} more"
        replies = "reply is" if len(missing) == 1 else "replies are"
        msg = f"{len(missing)} {replies} not in the cache: {', '.join(names)}"
        hint = f"build once with source.offline=false ({count(len(missing), 'call')}), or from a bundle"
        raise Offline(msg, "source.offline", hint)
