"""Calls the Onshape API over HTTP: authenticates, counts and retries calls, a few at a time.

It decides how to treat each failure. A temporary failure (5xx, a reply cut short or late) is
retried; after a rate limit (429) it waits; a used-up quota (402) stops all calls at once;
every other refusal raises an error.
"""

import contextlib
import functools
import json
import tempfile
import threading
from collections.abc import Callable, Mapping
from types import TracebackType
from urllib.parse import urlsplit

from linkwright.stages.fetch.onshape import reply_sizes
from linkwright.stages.fetch.onshape.api import redirects, retries
from linkwright.stages.fetch.onshape.api.call import ApiCall
from linkwright.stages.fetch.onshape.api.credentials import Credentials
from linkwright.stages.fetch.onshape.api.halt import Halt
from linkwright.stages.fetch.onshape.api.http_errors import (
    no_reply,
    rate_limited,
    refusal,
    too_large,
    web_page,
    wrongly_packed,
)
from linkwright.stages.fetch.onshape.api.ledger import Ledger, billed, endpoint
from linkwright.stages.fetch.onshape.api.rate_limits import RateLimits, remaining_calls, retry_after
from linkwright.stages.fetch.onshape.api.received import DownloadProgress
from linkwright.stages.fetch.onshape.api.retries import Patience, TemporaryFailure
from linkwright.stages.fetch.onshape.api.transport import (
    AT_ONCE,
    HttpReply,
    NoReply,
    ReplyTooLarge,
    UnexpectedEncoding,
    Wire,
)
from linkwright.stages.fetch.onshape.call_budget import Budget, CallSlot
from linkwright.stages.fetch.onshape.requests import JSON, api, describe, is_definition
from linkwright.stages.fetch.onshape.url import AssemblyUrl
from linkwright.stages.robot.errors import Offline, ProtocolError, QuotaExhausted, SourceError

__all__ = ["AT_ONCE", "JSON", "Client"]

_PAGE = b"<"
_FACT_HEADERS = {"X-Api-Version": "api", "On-Version": "release"}
_PATIENCE = Patience()


class Client:
    """The caller of a host's API: a context manager, safe to use from several threads.

    `ledger` records billed calls; `progress` gets a line whenever the user has to wait, and `transient` a
    line about the bytes received so far; `budget` limits the billed calls, retries included.
    """

    def __init__(
        self,
        url: AssemblyUrl,
        credentials: Credentials,
        *,
        patience: Patience = _PATIENCE,
        ledger: Ledger | None = None,
        progress: Callable[[str], None] = lambda _: None,
        budget: Budget | None = None,
        transient: Callable[[str], None] = lambda _: None,
    ) -> None:
        self.host = urlsplit(url.origin).netloc
        self.server_facts: dict[str, str] = {}
        """The server's report about itself: `api`, the version that it serves, `definition_api`, that of
        definitions, and its `release`."""
        self._origin = url.origin
        self._origins: dict[str, str] = {}
        self._credentials = credentials
        self._patience = patience
        self._ledger = ledger
        self._uncounted = False
        self._progress = progress
        self._lock = threading.Lock()
        self._budget = budget or Budget(None)
        self._halt = Halt()
        self._windows = RateLimits(patience.max_wait, self._halt.stopped)
        self._wire = Wire(patience, loopback=url.loopback, arrived=DownloadProgress(transient).add)

    def __enter__(self) -> "Client":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._wire.close()

    @property
    def calls(self) -> int:
        """The calls so far that count against the quota: every 2xx and 3xx."""
        return self._budget.made

    @property
    def left(self) -> Mapping[str, int]:
        """The calls left in the server's windows, by endpoint, if it reports them."""
        return dict(self._windows.calls_left)

    @property
    def waited(self) -> float:
        """Seconds waited at the server's request."""
        return self._windows.waited

    def get(self, request: str, accept: str = JSON, check: Callable[[bytes], None] | None = None) -> bytes:
        """Returns the body of the reply to `request`.

        `check` raises ProtocolError for an invalid body; such a reply is billed, so the call is repeated only
        once.

        Raises AuthError, NotFound, QuotaExhausted, RateLimited, SourceError or ProtocolError if the server
        refuses or sends an invalid reply; Offline if it cannot be reached.
        """

        def once() -> bytes:
            answer = self._answer(ApiCall("GET", request, accept))
            if answer.status != 200:
                raise self._refusal(answer, request)
            if answer.body[:64].lstrip()[:1] == _PAGE:
                raise web_page(describe(request), self.host)
            if check is not None:
                self._check(answer.body, check)
            return answer.body

        return self._retried_call(once)

    def post(self, request: str, body: bytes, *, restoring: bool = False) -> bytes:
        """Returns the body of the reply to a POST of JSON. Raises the errors of `get`.

        The call is repeated only if the server cannot have made the change: it was not reached, or its rate
        limit refused the call. `restoring`: the call undoes a change and may be repeated safely, so it is
        retried as in `get`, and sent even if all other calls were stopped.
        """

        def once() -> bytes:
            answer = self._answer(ApiCall("POST", request, JSON, body, restoring))
            if not 200 <= answer.status < 300:
                raise self._refusal(answer, request, final=not restoring)
            return answer.body

        return self._retried_call(once, restoring=restoring)

    def stop(self) -> None:
        """Prevents further calls, and ends running calls and waits: they raise Offline."""
        self._halt.stop(Offline("the calls were stopped", self.host, "run the same command again"))
        self._wire.disconnect()

    def _retried_call(self, once: Callable[[], bytes], *, restoring: bool = False) -> bytes:
        """Returns the result of `once`, retried after temporary failures unless the calls were stopped."""

        def unless_stopped() -> bytes:
            try:
                return once()
            except TemporaryFailure:
                if not restoring:
                    self._halt.check()
                raise

        return retries.persist(unless_stopped, self._patience)

    def _answer(self, call: ApiCall) -> HttpReply:
        """Returns the reply with any status, after waiting for the server's rate limit."""
        kind, seconds = endpoint(call.request), self._patience.first_wait
        for _ in range(self._patience.refusals):
            self._windows.wait(kind, stoppable=not call.restores)
            answer = self._complete_reply(call)
            if answer.status != 429:
                return answer
            if not call.restores:
                self._halt.check()
            # Never less than our own pause: a server that says 0 must not be asked in a rush.
            requested = retry_after(answer.headers)
            seconds = max(requested or 0.0, seconds)
            if not self._windows.close(kind, seconds):
                break
            self._say(f"{self.host} allows no more calls for {call.subject}: waiting {seconds:.0f} s")
            seconds = min(2 * seconds, self._patience.longest_wait) if requested is None else seconds
        error = rate_limited(
            call.subject,
            self._reply_text(answer),
            self.host,
            requested=retry_after(answer.headers),
            waited=self._windows.waited,
            max_wait=self._patience.max_wait,
        )
        self._halt.stop(error)
        raise error

    def _complete_reply(self, call: ApiCall) -> HttpReply:
        """Returns a complete reply; raises the error for a missing or incomplete reply."""
        try:
            return self._follow(call)
        except NoReply as lost:
            raise self._reply_error(lost, call) from lost
        except ReplyTooLarge as error:
            raise too_large(call.request, self.host) from error
        except UnexpectedEncoding as error:
            raise wrongly_packed(call.subject, self.host, str(error)) from error
        except OSError as error:
            msg = f"the reply with {call.subject} cannot be written: {error.strerror or error}"
            hint = "make room there, or name another folder in the environment variable TMPDIR"
            raise SourceError(msg, tempfile.gettempdir(), hint) from error

    def _reply_error(self, failure: NoReply, call: ApiCall) -> Exception:
        """Returns the error for a missing or incomplete reply: `TemporaryFailure` if the call may be
        repeated."""
        error = no_reply(failure, call.subject, self.host)
        if failure.trouble is not None and failure.trouble.is_lasting and not failure.late:
            return error
        if call.method != "GET" and failure.begun and not call.restores:
            hint = "the server may have made the change: check the document in the browser"
            return type(error)(error.message, error.where, hint)
        return TemporaryFailure(error, "billed" if billed(failure.status) else "free", self._say)

    def _follow(self, call: ApiCall) -> HttpReply:
        """Returns the reply after all redirects. Each redirect is authenticated, and billed."""
        document = call.request.partition("/d/")[2].partition("/")[0]
        with self._lock:
            origin = self._origins.get(document, self._origin)
        first = address = f"{origin}/api/{api(call.request)}{call.request}"
        for _ in range(1 + redirects.MAX_REDIRECTS):
            if not call.restores:
                self._halt.check()
            # Calls that restore values are made whatever the budget.
            with self._budget.slot(needed=call.restores) as slot:
                answer = self._wire.send(
                    call.method,
                    address,
                    functools.partial(call.headers, self._credentials),
                    call.content,
                    functools.partial(self._note, call.request, slot),
                    reply_sizes.largest(call.request),
                )
            if not redirects.must_follow(call.method, answer.status):
                return answer
            address = redirects.target(address, answer.headers.get("Location", ""), call.subject)
            region = redirects.moved_origin(first, address)
            if region is not None:
                # The other calls for this document go there directly: each stop costs a call.
                with self._lock:
                    self._origins[document] = region
        msg = f"the server redirects the request for {call.subject} more than {redirects.MAX_REDIRECTS} times"
        raise ProtocolError(msg, self.host, "use the host that the browser shows for this document")

    def _check(self, body: bytes, check: Callable[[bytes], None]) -> None:
        try:
            check(body)
        except ProtocolError as error:
            located = ProtocolError(error.message, self.host, error.hint)
            raise TemporaryFailure(located, "billed", self._say) from error

    def _refusal(self, answer: HttpReply, request: str, *, final: bool = False) -> Exception:
        """Returns the error for a refusal: `TemporaryFailure` for a temporary refusal, unless it is
        `final`."""
        text = self._reply_text(answer)
        error = refusal(answer.status, answer.headers, text, request, self.host, self._credentials.kind)
        if isinstance(error, QuotaExhausted):
            self._halt.stop(error)
        if final or not (answer.status >= 500 or answer.status == 499):
            return error
        requested = retry_after(answer.headers)
        if requested and not self._windows.close(endpoint(request), requested):
            return error
        return TemporaryFailure(error, "free", self._say)

    def _reply_text(self, answer: HttpReply) -> str:
        """Returns the body without secrets, including those written with JSON escapes."""
        text = answer.body.decode("utf-8", "replace")
        with contextlib.suppress(ValueError, RecursionError):
            text = json.dumps(json.loads(text), ensure_ascii=False)
        return self._credentials.scrub(text)

    def _note(self, request: str, slot: CallSlot, status: int, headers: Mapping[str, str]) -> None:
        slot.charge(billed(status))
        kind = endpoint(request)
        prefix = "definition_" if is_definition(request) else ""
        calls_left = remaining_calls(headers)
        self._windows.note(kind, calls_left)
        with self._lock:
            for header, name in _FACT_HEADERS.items():
                if headers.get(header):
                    name = prefix + name if name == "api" else name
                    self.server_facts[name] = self._credentials.scrub(headers[header])[:40]
        if self._ledger is not None and (why := self._ledger.note(kind, status, calls_left)):
            if not self._uncounted:
                self._say(f"API calls are not counted: {why}")
            self._uncounted = True

    def _say(self, line: str) -> None:
        with self._lock:
            self._progress(line)
