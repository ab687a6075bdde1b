"""Cached replies first, then the server: each reply is billed once, also among several processes."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from threading import Lock
from typing import Any

from linkwright.stages.fetch.onshape.api.http_errors import Declined
from linkwright.stages.fetch.onshape.api.threads import run_all
from linkwright.stages.fetch.onshape.asking.session import Promise, Session
from linkwright.stages.fetch.onshape.call_budget import allow
from linkwright.stages.fetch.onshape.replies.store import ReplyStore
from linkwright.stages.fetch.onshape.requests import API, api, describe, is_definition
from linkwright.stages.robot.errors import NotFound, Offline, ProtocolError
from linkwright.stages.robot.text.plural import count

Refused = dict[str, NotFound | Declined]

_MOST_NAMED = 3


class CachedClient:
    """Gives replies to requests, the cached ones first.

    `offline`: no call is made; `refresh`: replies that earlier builds cached are fetched again;
    `max_calls`: the largest number of calls of one build.
    """

    def __init__(
        self, session: Session, replies: ReplyStore, *, offline: bool, refresh: bool, max_calls: int
    ) -> None:
        self._session = session
        self._replies = replies
        self._refresh = refresh
        self._max_calls = max_calls
        self._lock = Lock()
        self._asked: set[str] = set()
        self._doubted: set[str] = set()
        self._promises: dict[str, Promise] = {}
        self._checked: set[str] = set()
        self.offline = offline
        self.saved = 0
        """Calls that cached replies saved."""
        self.began: float | None = None
        """The start of a sweep: the state of a workspace that one job found since then is valid for all its
        jobs."""
        self.undisturbed: Callable[[], AbstractContextManager[None]] = nullcontext
        """A context in which the workspace has its users' values: no build has changed its variables."""
        self.while_waiting: Callable[[], None] = lambda: None
        """Called, perhaps several times, before replies are requested for the first time."""

    def kept(self, request: str) -> bytes | None:
        """The cached reply to a pinned request, or None; a reply without its required content counts as
        None."""
        with self._lock:
            if (self._refresh or request in self._doubted) and request not in self._asked:
                return None
            body = self._replies.get(request)
        promise = None if request in self._checked else self._promises.get(request)
        if body is None or promise is None:
            return body
        try:
            promise(body)
        except ProtocolError:
            return None
        self._checked.add(request)
        return body

    def require(self, request: str, promise: Promise) -> None:
        """Requires that the reply to a request fulfils `promise`; otherwise it is neither used nor cached."""
        self._promises[request] = promise

    def keep(self, request: str, body: bytes) -> None:
        """Caches the reply to a pinned request; for a definition also the API version."""
        with self._lock:
            self._asked.add(request)
            if is_definition(request):
                self._replies.remember(f"{request}#api", {"api": api(request)})
            self._replies.put(request, body)

    def api(self, request: str) -> str:
        """The API version of the cached reply to a request for a definition."""
        return str(self.recall(f"{request}#api").get("api", API))

    def doubt(self, requests: Iterable[str]) -> None:
        """Makes this build fetch these again, although replies are cached."""
        with self._lock:
            self._doubted.update(requests)

    def spare(self, calls: int) -> None:
        """Records that cached replies saved `calls`."""
        with self._lock:
            self.saved += calls

    @property
    def made(self) -> int:
        """Calls made so far that count against the quota."""
        return self._session.calls

    def allow(self, more: int) -> None:
        """SourceError where `more` further calls exceed the budget of the build."""
        allow(more, self._session.calls, self._max_calls)

    @property
    def may_call(self) -> bool:
        """Whether this build may call the server: it is not offline, and there is a key."""
        return not self.offline and self._session.has_key()

    def affords(self, more: int) -> bool:
        """Whether `more` further calls are within the budget of the build."""
        return self._session.calls + more <= self._max_calls

    def now(self, request: str) -> bytes:
        """The reply to a request whose reply changes with time: fetched, not cached."""
        self._reachable([request])
        self.allow(1)
        return self._session.ask(request)

    def one(self, request: str) -> bytes:
        """The reply to a pinned request: cached, else fetched and cached."""
        return self.all([request])[request]

    def all(self, wanted: Sequence[str], refused: Refused | None = None) -> dict[str, bytes]:
        """The replies to pinned requests, a few calls at a time.

        After a failure no further call begins, but running calls are finished and cached, since
        they are billed. Of several failures the first in order is raised. Where `refused` is given,
        failures of a single request are stored there, and the replies that arrived are returned.
        """
        found = {request: self.kept(request) for request in wanted}
        bodies = {request: body for request, body in found.items() if body is not None}
        missing = [request for request in wanted if request not in bodies]
        self.spare(sum(request not in self._asked for request in bodies))
        if not missing:
            return bodies
        self._reachable(missing)
        self.allow(len(missing))
        self._session.ready()
        self.while_waiting()
        try:
            futures = run_all([partial(self._once, request) for request in missing], self._session.at_once)
        except BaseException:
            # Interrupted: nothing is asked again, and nothing waits for its turn.
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
        """The record stored for a subject; empty for none."""
        with self._lock:
            return self._replies.recall(subject) or {}

    def remember(self, subject: str, fact: Mapping[str, Any]) -> None:
        with self._lock:
            self._replies.remember(subject, fact)

    def alone(self, subject: str) -> AbstractContextManager[None]:
        """A lock for each subject: one build at a time."""
        return self._replies.alone(subject)

    def _once(self, request: str) -> bytes:
        """The reply to a request, which another build may be fetching at the same time."""
        with self.alone(request):
            body = self.kept(request)
            if body is not None:
                self.spare(1)
                return body
            body = self._session.ask(request, self._promises.get(request))
            self.keep(request, body)
            return body

    def _reachable(self, missing: Sequence[str]) -> None:
        if not self.offline:
            return
        names = [describe(request) for request in missing[:_MOST_NAMED]]
        if len(missing) > _MOST_NAMED:
            names[-1] += f" and {len(missing) - _MOST_NAMED} more"
        replies = "reply is" if len(missing) == 1 else "replies are"
        msg = f"{len(missing)} {replies} not in the cache: {', '.join(names)}"
        hint = f"build once with source.offline=false ({count(len(missing), 'call')}), or from a bundle"
        raise Offline(msg, "source.offline", hint)
