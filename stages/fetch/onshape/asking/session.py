"""Connects to the server of an assembly for the first call, and checks the replies."""

from collections.abc import Callable
from dataclasses import replace

from linkwright.stages.fetch.onshape import definition, requests
from linkwright.stages.fetch.onshape.api import network_settings
from linkwright.stages.fetch.onshape.api.client import AT_ONCE, Client
from linkwright.stages.fetch.onshape.api.credentials import find
from linkwright.stages.fetch.onshape.api.http_errors import Declined
from linkwright.stages.fetch.onshape.api.ledger import Ledger
from linkwright.stages.fetch.onshape.api.retries import Patience
from linkwright.stages.fetch.onshape.call_budget import Budget
from linkwright.stages.fetch.onshape.replies.checks import cached_form
from linkwright.stages.fetch.onshape.section import OnshapeSourceSection
from linkwright.stages.fetch.source import Calls, FetchContext
from linkwright.stages.robot.errors import ConfigError, ProtocolError

ReplyCheck = Callable[[bytes], None]
"""A function that raises ProtocolError for an accepted reply without its required content."""


class Session:
    """The connection to a server, a context manager: the connections live as long as it.

    `keys`: the configuration of the source; `max_wait` and `max_calls` limit the calls.
    """

    at_once = AT_ONCE

    def __init__(self, keys: OnshapeSourceSection, context: FetchContext) -> None:
        self._url = keys.url
        self._max_calls = keys.max_calls
        self._context = context
        self._patience = replace(context.patience or Patience(), max_wait=keys.max_wait)
        self._ledger: Ledger | None = None
        self._client: Client | None = None

    def __enter__(self) -> "Session":
        return self

    def __exit__(self, *reason: object) -> None:
        if self._client is not None:
            self._client.__exit__(None, None, None)

    @property
    def calls(self) -> int:
        """The calls made that count against the quota."""
        return self._client.calls if self._client else 0

    def account(self, calls: Calls) -> None:
        """Copies the number of calls made so far to `calls`."""
        calls.made = self.calls
        calls.remaining = dict(sorted(self._client.left.items())) if self._client else {}
        calls.year = self._ledger.counted() if self._ledger else None
        if self._client is not None:
            calls.served = dict(sorted(self._client.server_facts.items()))
            calls.waited = self._client.waited

    def has_key(self) -> bool:
        """Tells whether there is a key, which a build from cached replies does not need."""
        try:
            return self._client is not None or bool(find(self._context.environ))
        except ConfigError:
            return False

    def ready(self) -> Client:
        """Returns the client, made for the first call: a build from cached replies needs no key."""
        if self._client is None:
            context = self._context
            credentials = find(context.environ)
            network_settings.require(context.environ, proxies=not self._url.loopback)
            self._ledger = Ledger(context.ledger, credentials.owner_id) if context.ledger else None
            self._client = Client(
                self._url,
                credentials,
                patience=self._patience,
                ledger=self._ledger,
                progress=context.progress,
                budget=Budget(self._max_calls, context.sweep.made if context.sweep else None),
                transient=context.transient,
            )
        return self._client

    def stop(self) -> None:
        """Prevents further calls and ends all waits."""
        if self._client is not None:
            self._client.stop()

    def ask(self, request: str, promise: ReplyCheck | None = None) -> bytes:
        """Returns the reply to `request` in the form that is cached. Safe to call from several threads once
        `ready`.

        An invalid reply, or a reply that does not fulfil `promise`, is fetched once more. Exceptions: a
        promise that raises Declined, and the mass of an assembly, which only checks other replies.
        """
        cached = b""
        deferred_error: ProtocolError | None = None

        def check_reply(body: bytes) -> None:
            nonlocal cached, deferred_error
            try:
                cached = cached_form(request, body)
                if requests.is_definition(request):
                    self._require_assembly(body)
                if promise is not None:
                    promise(cached)
            except ProtocolError as error:
                if not (isinstance(error, Declined) or requests.is_assembly_mass(request)):
                    raise
                deferred_error = error

        self.ready().get(request, requests.accept(request), check=check_reply)
        if deferred_error is not None:
            raise deferred_error
        return cached

    def _require_assembly(self, body: bytes) -> None:
        assembly = definition.read(body)
        if (assembly.document, assembly.element) != (self._url.document, self._url.element):
            msg = f"the server gave assembly {assembly.element} where {self._url.element} was asked for"
            raise ProtocolError(msg, hint="run the same command again")
