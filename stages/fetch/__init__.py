"""Fetch: a source in, a `Bundle` out. `fetch` is the stage; the rest is what is known before it.

An Onshape document costs one call for its definition and two for each part studio, and one where it
did not change since; a bundle and the sample replay recorded replies through the same code. A robot's
own file is read with the meshes that it names.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stages.fetch.keys import FetchKeys, OnshapeKeys
    from stages.fetch.onshape.api.retries import Patience
    from stages.fetch.onshape.call_budget import Calls
    from stages.fetch.onshape.reply_store import Replies
    from stages.robot.bundle import Bundle
    from stages.robot.errors import Diagnostic

VERSION = 3
"""Grows with every change of what this stage makes of the same input."""


@dataclass(frozen=True, slots=True)
class Fetched:
    """A bundle, the `calls` made for it that count against the quota, and the calls `saved`.

    `title`: what the assembly's tab is called, where a reply told it. `stale`: it is what was fetched
    last, since the quota is used up, and `source.stale` does not take that for success.
    """

    bundle: Bundle
    calls: int
    saved: int
    diagnostics: tuple[Diagnostic, ...] = ()
    title: str = ""
    stale: bool = False


def fetch(
    keys: FetchKeys,
    replies: Replies,
    environ: Mapping[str, str],
    tell: Callable[[str], None],
    ledger: Path | None = None,
    calls: Calls | None = None,
    patience: Patience | None = None,
    began: float | None = None,
    while_waiting: Callable[[], None] = lambda: None,
    passing: Callable[[str], None] = lambda _: None,
) -> Fetched:
    """The bundle of what `keys.source` names. `tell` gets lines about progress, and `passing` those that
    the next one replaces.

    Calls are taken down in the folder `ledger`, and in `calls` also where the fetch fails. `patience`:
    how failures of the server are borne with, but for `source.max_wait`. `began`: the start of the
    sweep that this build is a job of [s since the epoch]. `while_waiting` is called once replies are on
    their way, or a guest is asked, that make the later stages run, and must return at once.

    ConfigError where a call is due and there is no API key; SourceError and its kinds where the
    source cannot be read; AssemblyError where the assembly has no part.
    """
    source = keys.source
    if source.kind == "onshape":
        from stages.fetch.onshape.call_budget import Calls

        calls = Calls() if calls is None else calls
        return _from_onshape(
            source, replies, environ, tell, ledger, calls, patience, began, while_waiting, passing
        )
    if source.kind == "urdf":
        from stages.fetch.urdf.gather import gather as gathered

        bundle, found = gathered(source, environ)
        return Fetched(bundle, calls=0, saved=0, diagnostics=found)
    if source.kind == "mjcf":
        from stages.fetch.mjcf.gather import gather as compiled

        bundle, found = compiled(source, while_waiting)
        return Fetched(bundle, calls=0, saved=0, diagnostics=found)

    from stages.fetch.bundle.archive import read, whole
    from stages.fetch.files import content, label
    from stages.fetch.onshape.gather import gather
    from stages.fetch.onshape.recorded import Recorded

    where = label(source)
    recording = read(content(source), where)
    if recording.kind != "onshape":
        return Fetched(whole(recording, where), calls=0, saved=0)
    return Fetched(gather(Recorded(recording, where)), calls=0, saved=0)


def _from_onshape(
    source: OnshapeKeys,
    replies: Replies,
    environ: Mapping[str, str],
    tell: Callable[[str], None],
    ledger: Path | None,
    calls: Calls,
    patience: Patience | None,
    began: float | None,
    while_waiting: Callable[[], None],
    passing: Callable[[str], None],
) -> Fetched:
    from stages.fetch.onshape.cached_client import Asking
    from stages.fetch.onshape.gather import gather
    from stages.fetch.onshape.live import Network
    from stages.fetch.onshape.session import Server
    from stages.fetch.onshape.url import parse
    from stages.fetch.onshape.variables import Variables
    from stages.robot.errors import Diagnostic, QuotaExhausted, SourceError

    url = parse(source.url)
    with Server(url, environ, tell, source.max_wait, ledger, patience, source.max_calls, passing) as server:
        asking = Asking(
            server, replies, offline=source.offline, refresh=source.refresh, max_calls=source.max_calls
        )
        asking.began, asking.while_waiting = began, while_waiting
        network = Network(url, source, asking, tell)
        found: tuple[Diagnostic, ...] = ()
        try:
            variables = Variables(url, asking, server, tell)
            asking.settled = variables.settled
            variables.mend()
            if source.variables:
                url = variables.applied(source.variables)
                network = Network(url, source, asking, tell)
            try:
                bundle = gather(network)
            except QuotaExhausted as exhausted:
                if url.pinned:
                    raise
                asking = Asking(server, replies, offline=True, refresh=False, max_calls=source.max_calls)
                network = Network(url, source, asking, tell)
                try:
                    bundle = gather(network)
                except SourceError:
                    raise exhausted from None
                msg = f"{exhausted.message}; this is the assembly as it was last fetched completely"
                hint = "build again when the quota is renewed, or with another key"
                if not source.stale:
                    hint += "; source.stale=true takes a build from what was fetched last for a success"
                found = (Diagnostic("W-QUOTA", msg, exhausted.where, hint),)
        finally:
            server.account(calls)
            calls.saved = asking.saved
    stale = bool(found) and not source.stale
    diagnostics = (*network.diagnostics, *found)
    return Fetched(bundle, calls.made, calls.saved, diagnostics, network.title(), stale)


def preflight(keys: FetchKeys, environ: Mapping[str, str]) -> None:
    """ConfigError for what is wrong with the source before any work: address, file, missing key.

    An address pinned to a version or microversion may need no call, so its key is asked for later;
    nothing needs one offline.
    """
    source = keys.source
    if source.kind == "onshape":
        from stages.fetch.onshape.api.credentials import find
        from stages.fetch.onshape.url import parse

        if source.offline and source.refresh:
            from stages.robot.errors import ConfigError

            msg = "offline makes no call, and refresh makes all of them"
            raise ConfigError(msg, "source.refresh", "set one of source.offline and source.refresh to false")
        url = parse(source.url)
        if source.variables and (url.pinned or source.offline):
            from stages.robot.errors import ConfigError

            why = "offline makes no call" if source.offline else "a version or microversion never changes"
            msg = f"variables cannot be set here: {why}"
            hint = "give the address of a workspace (…/w/…), or set the variables in Onshape"
            raise ConfigError(msg, "source.variables", hint)
        if not url.pinned and not source.offline:
            from stages.fetch.onshape.api.network_settings import require as require_surroundings

            find(environ)
            require_surroundings(environ, proxies=not url.loopback)
    elif source.kind != "sample":
        from stages.fetch.files import require

        require(source)


def remarks(keys: FetchKeys) -> tuple[Diagnostic, ...]:
    """What a user should know of the place that the key is read from."""
    if keys.source.kind != "onshape":
        return ()
    from stages.fetch.onshape.api import credentials

    return credentials.remarks()


def spends(keys: FetchKeys) -> bool:
    """Whether a fetch may make calls that count against a quota."""
    return keys.source.kind == "onshape" and not keys.source.offline


def writes(keys: FetchKeys) -> bool:
    """Whether a build changes the user's document, if only for a moment."""
    return keys.source.kind == "onshape" and bool(keys.source.variables)


def anew(keys: FetchKeys) -> bool:
    """Whether the source must be read again although nothing about it may have changed."""
    return keys.source.kind == "onshape" and keys.source.refresh


def pinned(keys: FetchKeys, environ: Mapping[str, str] | None = None) -> dict[str, Any] | None:
    """What identifies the source for ever, as plain data; None for a workspace, which changes.

    `environ` names the folders of ROS packages. SourceError where a robot's file is not readable.
    """
    source = keys.source
    if source.kind == "urdf":
        from stages.fetch.urdf.survey import identity

        return identity(source, environ or {})
    if source.kind == "mjcf":
        from stages.fetch.mjcf.gather import identity as of_the_model

        return of_the_model(source)
    if source.kind == "onshape":
        from stages.fetch.onshape.requests import API, definition
        from stages.fetch.onshape.url import parse

        url = parse(source.url)
        if not url.pinned:
            return None
        request = definition(url.document, url.pin, url.element, url.configuration)
        quality = source.tessellation
        return {
            "kind": "onshape",
            "api": API,
            "request": request,
            "configuration": sorted(source.configuration.items()),
            "tessellation": [quality.angle, quality.chord, quality.max_facet_width],
        }

    from hashlib import sha256

    from stages.fetch.files import content

    return {"kind": "recording", "sha256": sha256(content(source)).hexdigest()}
