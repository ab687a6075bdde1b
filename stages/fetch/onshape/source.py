"""Defines the source `onshape`: an assembly in an Onshape document."""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType
from typing import TYPE_CHECKING, Any, ClassVar

from linkwright.stages.fetch.onshape import reply_sizes
from linkwright.stages.fetch.onshape.api import credentials, network_settings
from linkwright.stages.fetch.onshape.requests import API, definition
from linkwright.stages.fetch.source import CallsAhead, FetchContext, Fetched, Source
from linkwright.stages.robot.bundle import OnshapeBundle
from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.text.plural import count

if TYPE_CHECKING:
    from linkwright.stages.fetch.onshape.section import OnshapeSourceSection
    from linkwright.stages.fetch.recording import Recording
    from linkwright.stages.robot.bundle import Bundle
    from linkwright.stages.robot.errors import Diagnostic


def _online() -> ModuleType:
    # Late: an unchanged source is not read again.
    from linkwright.stages.fetch.onshape.asking import online

    return online


class OnshapeSource(Source):
    """A source that is an assembly, at a workspace, a version or a microversion."""

    recorded: ClassVar[bool] = True
    remote: ClassVar[bool] = True

    def __init__(self, keys: OnshapeSourceSection) -> None:
        self._keys = keys

    def label(self) -> str:
        return self._keys.url.text

    def preflight(self, environ: Mapping[str, str]) -> None:
        """Raises ConfigError for contradicting keys, and if a call will be made and there is no API key.

        An address pinned to a version or microversion may need no call, so its key is required later; offline
        no key is needed.
        """
        keys, url = self._keys, self._keys.url
        if keys.offline and keys.refresh:
            msg = "source.offline allows no call, but source.refresh fetches everything again"
            raise ConfigError(msg, "source.refresh", "set one of source.offline and source.refresh to false")
        if keys.variables and (url.pinned or keys.offline):
            why = "offline makes no call" if keys.offline else "a version or microversion never changes"
            msg = f"variables cannot be set here: {why}"
            hint = "give the address of a workspace (…/w/…), or set the variables in Onshape"
            raise ConfigError(msg, "source.variables", hint)
        if not url.pinned and not keys.offline:
            credentials.find(environ)
            network_settings.require(environ, proxies=not url.loopback)

    def pinned(self, environ: Mapping[str, str]) -> dict[str, Any] | None:
        url, quality = self._keys.url, self._keys.tessellation
        if not url.pinned:
            return None
        return {
            "kind": "onshape",
            "api": API,
            "request": definition(url.document, url.pin, url.element, url.configuration),
            "configuration": sorted(self._keys.configuration.items()),
            "tessellation": [quality.angle, quality.chord, quality.max_facet_width],
        }

    def fetch(self, context: FetchContext) -> Fetched:
        fetched: Fetched = _online().fetch(self._keys, context)
        return fetched

    def survey(self, context: FetchContext, *, masses: bool) -> Fetched:
        fetched: Fetched = _online().survey(self._keys, context, masses=masses)
        return fetched

    def ahead(self, context: FetchContext) -> CallsAhead:
        ahead: CallsAhead = _online().ahead(self._keys, context)
        return ahead

    @property
    def spends(self) -> bool:
        return not self._keys.offline

    @property
    def writes(self) -> bool:
        return bool(self._keys.variables)

    @property
    def force(self) -> bool:
        return self._keys.refresh

    def remarks(self) -> tuple[Diagnostic, ...]:
        return credentials.remarks()

    def describe(self) -> dict[str, str]:
        return {"url": self._keys.url.text}

    @staticmethod
    def replay(recording: Recording, where: str) -> OnshapeBundle:
        # Late: an unchanged source is not read again.
        from linkwright.stages.fetch.onshape.gather import gather
        from linkwright.stages.fetch.onshape.replies.recorded import RecordedAnswers

        return gather(RecordedAnswers(recording, where))

    @staticmethod
    def largest_reply(request: str) -> int:
        return reply_sizes.largest(request)

    @staticmethod
    def summary(bundle: Bundle) -> str:
        assert isinstance(bundle, OnshapeBundle)
        replies, studios = len(bundle.blobs), len(bundle.studios)
        return f"{count(replies, 'reply', 'replies')} about {count(studios, 'part studio')}"
