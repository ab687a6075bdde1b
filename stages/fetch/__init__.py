"""Fetch: a source in, a `Bundle` out. `fetch` is the stage; the rest is what is known before it.

An Onshape document costs one call for its definition and two for each part studio; a bundle and
the sample replay recorded replies through the same code.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stages.fetch.keys import FetchKeys
    from stages.fetch.replies import Replies
    from stages.robot.bundle import Bundle

VERSION = 1
"""Grows with every change of what this stage makes of the same input."""


@dataclass(frozen=True, slots=True)
class Fetched:
    """A bundle, the `calls` made for it that count against the quota, and the calls `saved`."""

    bundle: Bundle
    calls: int
    saved: int


def fetch(
    keys: FetchKeys, replies: Replies, environ: Mapping[str, str], tell: Callable[[str], None]
) -> Fetched:
    """The bundle of what `keys.source` names. `tell` gets lines about progress.

    ConfigError where a call is due and there is no API key; SourceError and its kinds where the
    source cannot be read; AssemblyError where the assembly has no part.
    """
    from stages.fetch.onshape import gather

    source = keys.source
    if source.kind == "onshape":
        from stages.fetch.network import Network
        from stages.fetch.url import parse

        with Network(parse(source.url), source.tessellation, replies, environ, tell) as network:
            bundle = gather(network)
            return Fetched(bundle, network.calls, network.saved)

    from stages.fetch.bundle import read
    from stages.fetch.files import content, label
    from stages.fetch.recorded import Recorded

    where = label(source)
    return Fetched(gather(Recorded(read(content(source), where), where)), calls=0, saved=0)


def preflight(keys: FetchKeys, environ: Mapping[str, str]) -> None:
    """ConfigError for what is wrong with the source before any work: address, file, missing key.

    An address pinned to a version or microversion may need no call, so its key is asked for later.
    """
    source = keys.source
    if source.kind == "onshape":
        from stages.fetch.credentials import find
        from stages.fetch.url import parse

        if not parse(source.url).pinned:
            find(environ)
    elif source.kind == "bundle":
        from stages.fetch.files import require

        require(source)


def pinned(keys: FetchKeys) -> dict[str, Any] | None:
    """What identifies the source for ever, as plain data; None for a workspace, which changes."""
    source = keys.source
    if source.kind == "onshape":
        from stages.fetch.requests import API, definition
        from stages.fetch.url import parse

        url = parse(source.url)
        if not url.pinned:
            return None
        request = definition(url.document, url.pin, url.element, url.configuration)
        quality = source.tessellation
        return {
            "kind": "onshape",
            "api": API,
            "request": request,
            "tessellation": [quality.angle, quality.chord, quality.max_facet_width],
        }

    from hashlib import sha256

    from stages.fetch.files import content

    return {"kind": "recording", "sha256": sha256(content(source)).hexdigest()}
