"""Chooses the configuration to build: that of the address, overridden by the user's values.

The document's parameters are fetched once for each microversion and cached. Those of the last build determine
the configuration in the single call that shows whether anything changed.
"""

import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from linkwright.stages.fetch.onshape import configuration, requests
from linkwright.stages.fetch.onshape.asking.cached_client import CachedClient
from linkwright.stages.fetch.onshape.asking.freshness import Workspace
from linkwright.stages.fetch.onshape.url import AssemblyUrl
from linkwright.stages.robot.errors import SourceError


class ConfiguredAddress:
    """The address with `settings` (parameter → value) in its configuration."""

    def __init__(self, url: AssemblyUrl, settings: Mapping[str, Any], client: CachedClient) -> None:
        self._url = url
        self._settings = settings
        self._client = client
        self._subject = f"/documents/d/{url.document}/{url.pin}/e/{url.element}#configuration"

    def address_at(self, pin: str) -> AssemblyUrl:
        """Returns the address at a version or microversion. Raises SourceError with the invalid values."""
        body = self._client.reply(self._request(pin))
        if not self._url.pinned:
            self._client.remember(self._subject, {"microversion": pin[2:]})
        return self._address_with(body)

    def current(self, *, force: bool) -> tuple[AssemblyUrl, str | None, str]:
        """Returns the address, the microversion last built (None at first) and the present microversion of
        its workspace.

        Makes one call if nothing changed, two for both parameters and definition the first time. Of several
        builds that ask at the same time only the first makes the calls.
        """
        began = time.time()
        with self._client.lock(self._subject):
            recalled = self._known_address()
            body = b"" if recalled else self._parameters()
            url = recalled or self._address_with(body)
            workspace = Workspace(url, self._client)
            then = workspace.last_microversion()
            microversion = workspace.current(force=force, asked_since=began)
            if not recalled:
                self._client.keep(self._request(f"m/{microversion}"), body)
            return self.address_at(f"m/{microversion}"), then, microversion

    def _parameters(self) -> bytes:
        """Returns the present parameters of the workspace, while no build has changed its variables."""
        with self._client.undisturbed():
            return self._client.uncached_reply(self._request(self._url.pin))

    def _known_address(self) -> AssemblyUrl | None:
        """Returns the address by the parameters of the last build, if they allow the values."""
        microversion = self._client.recall(self._subject).get("microversion")
        body = self._client.lookup(self._request(f"m/{microversion}")) if microversion else None
        if body is None:
            return None
        try:
            return self._address_with(body)
        except SourceError:
            if self._client.offline:
                raise
            return None

    def _address_with(self, body: bytes) -> AssemblyUrl:
        parameters = configuration.read_parameters(body)
        return replace(
            self._url,
            configuration=configuration.encode_settings(self._url.configuration, self._settings, parameters),
        )

    def _request(self, pin: str) -> str:
        return requests.configuration(self._url.document, pin, self._url.element)
