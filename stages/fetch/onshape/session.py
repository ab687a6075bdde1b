"""The server of one assembly: connected when the first call is due, its replies checked."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from stages.fetch.onshape import definition, requests
from stages.fetch.onshape.api import network_settings
from stages.fetch.onshape.api.client import AT_ONCE, Client
from stages.fetch.onshape.api.credentials import find
from stages.fetch.onshape.api.http_errors import Declined
from stages.fetch.onshape.api.ledger import Ledger
from stages.fetch.onshape.api.retries import Patience
from stages.fetch.onshape.call_budget import Calls
from stages.fetch.onshape.reply_checks import accepted
from stages.fetch.onshape.url import AssemblyUrl
from stages.robot.errors import ProtocolError

Promise = Callable[[bytes], None]
"""Raises ProtocolError for an accepted reply that lacks something that it must have."""


class Server:
    """A context manager: the connections live as long as it.

    `max_wait` [s] bounds the waits that the server may ask for; `ledger` is the folder where calls
    are taken down, if any; `patience` is what else is borne with; `passing` hears how much has arrived.
    """

    at_once = AT_ONCE

    def __init__(
        self,
        url: AssemblyUrl,
        environ: Mapping[str, str],
        tell: Callable[[str], None],
        max_wait: float,
        ledger: Path | None,
        patience: Patience | None = None,
        max_calls: int | None = None,
        passing: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._url = url
        self._passing = passing
        self._max_calls = max_calls
        self._environ = environ
        self._tell = tell
        self._patience = replace(patience or Patience(), max_wait=max_wait)
        self._folder = ledger
        self._ledger: Ledger | None = None
        self._client: Client | None = None

    def __enter__(self) -> "Server":
        return self

    def __exit__(self, *reason: object) -> None:
        if self._client is not None:
            self._client.__exit__(None, None, None)

    @property
    def calls(self) -> int:
        """Calls made that count against the quota."""
        return self._client.calls if self._client else 0

    def account(self, calls: Calls) -> None:
        """Takes down in `calls` what this server was asked so far."""
        calls.made = self.calls
        calls.remaining = dict(sorted(self._client.left.items())) if self._client else {}
        calls.year = self._ledger.counted() if self._ledger else None
        if self._client is not None:
            calls.served = dict(sorted(self._client.met.items()))
            calls.waited = self._client.waited

    def ready(self) -> Client:
        """The client, made when the first call is due: a build from kept replies needs no key."""
        if self._client is None:
            credentials = find(self._environ)
            network_settings.require(self._environ, proxies=not self._url.loopback)
            self._ledger = Ledger(self._folder, credentials.who) if self._folder else None
            self._client = Client(
                self._url,
                credentials,
                patience=self._patience,
                ledger=self._ledger,
                tell=self._tell,
                max_calls=self._max_calls,
                passing=self._passing,
            )
        return self._client

    def stop(self) -> None:
        """Lets no further call begin and ends all waits."""
        if self._client is not None:
            self._client.stop()

    def ask(self, request: str, promise: Promise | None = None) -> bytes:
        """What is kept of the reply to `request`. Safe to call from several threads once `ready`.

        A reply that is not what was asked for, or does not hold the `promise`, is asked for once more.
        Not so where the promise raises Declined, and the mass of an assembly: it only checks others.
        """
        kept = b""
        final: ProtocolError | None = None

        def fits(body: bytes) -> None:
            nonlocal kept, final
            try:
                kept = accepted(request, body)
                if requests.is_definition(request):
                    self._same_assembly(body)
                if promise is not None:
                    promise(kept)
            except ProtocolError as error:
                if not (isinstance(error, Declined) or requests.is_assembly_mass(request)):
                    raise
                final = error

        self.ready().get(request, requests.accept(request), check=fits)
        if final is not None:
            raise final
        return kept

    def _same_assembly(self, body: bytes) -> None:
        found = definition.read(body)
        if (found.document, found.element) != (self._url.document, self._url.element):
            msg = f"the server gave assembly {found.element} where {self._url.element} was asked for"
            raise ProtocolError(msg, hint="run the same command again")
