"""Finds whether a workspace changed since its last build, and the tabs that changed.

A workspace is asked only for its microversion; everything else is fetched, and cached, at that
microversion. An edit anywhere gives the whole document a new one, but each tab has a microversion of
its own: replies about a tab with the same microversion stay valid.
"""

import time
from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.stages.fetch.onshape import definition, requests
from linkwright.stages.fetch.onshape.asking.cached_client import CachedClient
from linkwright.stages.fetch.onshape.replies import documents
from linkwright.stages.fetch.onshape.url import AssemblyUrl
from linkwright.stages.robot.errors import Offline


class Workspace:
    """The workspace of an address, and its microversions in earlier builds."""

    def __init__(self, url: AssemblyUrl, client: CachedClient) -> None:
        self._url = url
        self._client = client
        self._place = f"/documents/d/{url.document}/{url.pin}"
        self._definition = requests.definition(url.document, url.pin, url.element, url.configuration)

    def last_microversion(self) -> str | None:
        """Returns the microversion of the last complete build, or else the first recorded; None without
        either."""
        return self._recalled(f"{self._definition}#complete") or self._recalled(f"{self._definition}#first")

    def record_complete(self, microversion: str) -> None:
        """Records that all replies about this assembly are cached at `microversion`."""
        if self._recalled(f"{self._definition}#complete") != microversion:
            self._client.remember(f"{self._definition}#complete", {"microversion": microversion})

    def current(self, *, force: bool = False, asked_since: float | None = None) -> str:
        """Returns the current microversion of the workspace (one call); the last known microversion if
        offline.

        The first time, and with `force`, the definition itself is fetched: it names the microversion. Of
        several builds that ask at the same time only the first calls the server; the others use its answer if
        it is newer than `asked_since` (default: now). All fetches of a sweep use the answer of the first.
        """
        client = self._client
        asked_since = asked_since or time.time()
        if client.offline:
            return self._without_network()
        pins = client.sweep.pins if client.sweep else {}
        if self._place in pins:
            client.count_saved(1)
            return self._recorded(pins[self._place])
        # Not while another build has the variables changed: that state is not the user's.
        with client.undisturbed(), client.lock(self._place):
            recalled = client.recall(self._place)
            # A time in the future comes from a clock that was set back since.
            if not force and asked_since <= _number(recalled.get("at")) <= time.time():
                client.count_saved(1)
                microversion = str(recalled["microversion"])
            else:
                microversion = self._ask(force)
                client.remember(self._place, {"microversion": microversion, "at": time.time()})
        pins[self._place] = microversion
        return self._recorded(microversion)

    def discrepancy(self) -> Mapping[str, Any]:
        """Returns the recorded difference of masses that remained after fetching everything again; empty if
        there is none."""
        return self._client.recall(f"{self._definition}#discrepancy")

    def record_discrepancy(self, fact: Mapping[str, Any]) -> None:
        """Records a difference of masses; an empty mapping deletes the record."""
        if self.discrepancy() != fact:
            self._client.remember(f"{self._definition}#discrepancy", fact)

    def definition(self, microversion: str) -> str:
        """Returns the request for the assembly definition at a microversion."""
        url = self._url
        return requests.definition(url.document, f"m/{microversion}", url.element, url.configuration)

    def _ask(self, force: bool) -> str:
        """Asks the server for the current microversion; the first time, and with `force`, by the
        definition."""
        if self.last_microversion() is None or force:
            self._client.while_waiting()
            body = self._client.uncached_reply(self._definition)
            microversion = definition.read(body).microversion
            self._client.keep(self.definition(microversion), body)
            return microversion
        body = self._client.uncached_reply(
            requests.current_microversion(self._url.document, self._url.pin[2:])
        )
        return documents.microversion(body)

    def _recorded(self, microversion: str) -> str:
        """Returns the microversion; records it if it is the first."""
        if self.last_microversion() is None:
            self._client.remember(f"{self._definition}#first", {"microversion": microversion})
        return microversion

    def _without_network(self) -> str:
        last_microversion = self.last_microversion()
        if last_microversion is None:
            msg = f"no cached state of the workspace of assembly {self._url.element}"
            hint = "build it once with source.offline=false, or build from a bundle (source=bundle)"
            raise Offline(msg, "source.offline", hint)
        return last_microversion

    def _recalled(self, subject: str) -> str | None:
        """Returns the recorded microversion of a subject, or None."""
        microversion = self._client.recall(subject).get("microversion")
        return microversion if isinstance(microversion, str) else None


def tabs_to_ask(
    url: AssemblyUrl, old_microversion: str, new_microversion: str, client: CachedClient
) -> tuple[str, str]:
    """Returns the requests that show the tabs that changed between two microversions of the assembly."""
    pair = (
        requests.elements(url.document, old_microversion),
        requests.elements(url.document, new_microversion),
    )
    for request in pair:
        client.require(request, lambda body: documents.require_tab(body, url.element))
    return pair


def unchanged_tabs(pair: Sequence[str], client: CachedClient) -> frozenset[str]:
    """Returns the ids of the elements that are the same in the replies to the `pair` of `tabs_to_ask`."""
    bodies = client.all(pair)
    old_tabs, new_tabs = (documents.tab_microversions(bodies[request]) for request in pair)
    return frozenset(element for element, version in new_tabs.items() if old_tabs.get(element) == version)


def _number(value: Any) -> float:
    return float(value) if isinstance(value, int | float) else -1.0
