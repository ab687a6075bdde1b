"""Makes the errors for HTTP status codes and unusable replies, each with a hint."""

import json
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING

from linkwright.stages.fetch.onshape import reply_sizes
from linkwright.stages.fetch.onshape.api.connection_errors import ConnectionFault
from linkwright.stages.fetch.onshape.api.rate_limits import date
from linkwright.stages.fetch.onshape.requests import (
    configuration_asked,
    describe,
    is_definition,
    is_gltf,
    is_triangles,
)
from linkwright.stages.robot.errors import (
    AuthError,
    NotFound,
    Offline,
    ProtocolError,
    QuotaExhausted,
    RateLimited,
    SourceError,
)

if TYPE_CHECKING:
    from linkwright.stages.fetch.onshape.api.transport import NoReply

AGAIN_HINT = "run the same command again; what was fetched is kept and not paid for twice"

_NOT_ASSEMBLY = "it may not be an assembly (a part studio or a drawing?)"
_TAB_HINT = "open the tab of the assembly in the browser, and copy its address"
_MAX_SKEW = 240.0
"""Largest clock error [s]: Onshape accepts signatures within 5 minutes of its time; this is a little less."""


class Declined(ProtocolError):
    """The error that the server refuses this particular request permanently; another request may succeed.

    The connection, the key and the quota are fine, and nothing was billed.
    """


def refusal(
    status: int, headers: Mapping[str, str], text: str, request: str, host: str, kind: str = "basic"
) -> SourceError:
    """Returns the error for a reply whose status is not 200.

    `text` is the body, free of secrets; `headers` looks names up without regard to case; `kind`: the way of
    authentication (basic, signature, bearer).
    """
    subject = describe(request)
    words = server_words(text)
    quoted = f' ("{words}")' if words else ""
    if status in (401, 403):
        return _denied(status, subject, quoted, host, kind, _skew(headers))
    if status == 402:
        msg = f"the yearly quota of API calls is used up (402), so {subject} was not sent{quoted}"
        hint = (
            "no further call was made, and what was fetched is kept; see My account > Developer in "
            "Onshape, or build from the cache (source.offline=true) or a bundle (source=bundle)"
        )
        return QuotaExhausted(msg, host, hint)
    if status == 404:
        return _not_found(subject, quoted, host, request, page=_is_page(text))
    if status == 400 and is_definition(request) and configuration_asked(request):
        return _configuration_refused(configuration_asked(request), quoted, host)
    if status == 400 and is_definition(request):
        tab = subject.removeprefix("the definition of assembly ")
        msg = f"the tab {tab} is no assembly, but perhaps a part studio or a drawing (400){quoted}"
        return SourceError(msg, host, _TAB_HINT)
    if status in (405, 406, 415):
        msg = f"the server refuses the form of the request for {subject} ({status}){quoted}"
        return Declined(msg, host, "this is a bug in linkwright, or the API has changed: report it")
    if status == 204:
        return ProtocolError(f"the server sent an empty reply instead of {subject} (204)", host, AGAIN_HINT)
    if 300 <= status < 400:
        msg = f"the server redirects the request for {subject} ({status}); this redirect is not followed"
        return ProtocolError(msg, host, "use the host that the browser shows for this document")
    if status >= 500 or status == 499:
        msg = f"the server failed to give {subject} ({status}){quoted}"
        hint = f"{AGAIN_HINT} in a while; if it fails each time, try a smaller assembly"
        return ProtocolError(msg, host, hint)
    msg = f"the server refuses to give {subject} ({status}){quoted}"
    return Declined(msg, host, "check that the document opens in the browser with the same account")


def rate_limited(
    subject: str, text: str, host: str, *, requested: float | None, waited: float, max_wait: float
) -> RateLimited:
    """Returns the error for a rate limit (429) once the allowed waiting time is used up. Times in seconds."""
    words = server_words(text)
    quoted = f' ("{words}")' if words else ""
    bound = f"source.max_wait allows {max_wait:g} s"
    spent = f" and {waited:.0f}s were already spent waiting" if waited else ""
    request = f"; it asks to wait {requested:.0f} s" if requested is not None else ""
    msg = (
        f"the server allows no more calls for {subject} for now (429){request}, while {bound}{spent}{quoted}"
    )
    when = f"in {_minutes(requested)}" if requested is not None else "later"
    hint = f"run the same command again {when}: what was fetched is kept and not paid for twice"
    if requested is not None and requested + 10 > max_wait:
        hint += f"; or allow a longer wait: source.max_wait={int(requested) + 10}"
    return RateLimited(msg, host, hint)


def cut_short(subject: str, host: str) -> ProtocolError:
    """Returns the error for an incomplete reply."""
    return ProtocolError(f"the reply with {subject} was cut short", host, AGAIN_HINT)


def offline(subject: str, host: str, why: str, *, late: bool) -> Offline:
    """Returns the error for a server that does not answer, or not in time."""
    if late:
        return Offline(f"{host} did not answer in time for {subject}", host, AGAIN_HINT)
    msg = f"{host} cannot be reached: {why}"
    hint = "check the network and the host in source.url, or build offline: source=sample, source=bundle"
    return Offline(msg, host, hint)


def unreached(trouble: ConnectionFault, host: str) -> Offline:
    """Returns the error for a request that did not reach its server."""
    return Offline(trouble.message, host, trouble.hint)


def no_reply(failure: "NoReply", subject: str, host: str) -> SourceError:
    """Returns the error for a missing or incomplete reply."""
    if failure.trouble is not None and not failure.late:
        return unreached(failure.trouble, host)
    if failure.late or not failure.status:
        return offline(subject, host, str(failure), late=failure.late)
    return cut_short(subject, host)


def too_large(request: str, host: str) -> ProtocolError:
    """Returns the error for a reply that is larger than the limit of its kind."""
    bound = reply_sizes.in_words(reply_sizes.largest(request))
    msg = f"the reply with {describe(request)} is larger than the limit ({bound})"
    if is_triangles(request) or is_gltf(request):
        return ProtocolError(msg, host, "use a coarser source.tessellation")
    return ProtocolError(msg, host, "check that source.url names the right assembly; if it does, report this")


def wrongly_packed(subject: str, host: str, how: str) -> ProtocolError:
    """Returns the error for a reply with an unexpected content encoding."""
    msg = f"the reply with {subject} has an unexpected encoding ({how})"
    return ProtocolError(msg, host, "check the host in source.url, and whether a proxy changes replies")


def web_page(subject: str, host: str) -> ProtocolError:
    """Returns the error for a web page in place of the reply."""
    msg = f"the server sent a web page instead of {subject}"
    return ProtocolError(msg, host, "check the host in source.url, and whether a proxy requires a login")


def server_words(text: str) -> str:
    """Returns the server's error message, short and on one line; "" for web pages and other noise."""
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        return ""
    message = data.get("message") if isinstance(data, dict) else None
    if not isinstance(message, str):
        return ""
    line = " ".join("".join(char if char.isprintable() else " " for char in message).split())
    return line if len(line) <= 200 else line[:199] + "…"


def _denied(status: int, subject: str, quoted: str, host: str, kind: str, skew: float) -> AuthError:
    if skew:
        ahead = "ahead of" if skew > 0 else "behind"
        clock = f"this computer's clock is {_minutes(abs(skew))} {ahead} the server's"
    else:
        clock = ""
    if kind == "signature" and clock:
        msg = f"the server does not accept the signature ({status}){quoted}: {clock}"
        return AuthError(msg, host, "set the clock, or leave out ONSHAPE_AUTH=signature")
    if status == 401 and kind == "bearer":
        msg = f"the server does not accept the bearer token (401){quoted}"
        hint = f"a token is valid for about an hour: get a new one, and check that it is for {host}"
        return AuthError(msg, host, hint)
    if status == 401:
        msg = f"the server does not accept the API key (401){quoted}"
        hint = (
            f"check ONSHAPE_ACCESS_KEY and ONSHAPE_SECRET_KEY; a key works only on the host where it was "
            f"made (here {host})"
        )
        return AuthError(msg, host, hint)
    credential = "bearer token" if kind == "bearer" else "API key"
    msg = f"the {credential} may not read {subject} (403){quoted}"
    hint = (
        f"give the {credential} the permission to read documents (My account > Developer in Onshape), and "
        f"share the document with its owner" + (f"; {clock}" if clock else "")
    )
    return AuthError(msg, host, hint)


def _configuration_refused(configuration: str, quoted: str, host: str) -> SourceError:
    msg = f"the server refuses the configuration {configuration!r} (400){quoted}"
    hint = (
        "choose it in the browser and copy the address again, or give the values by name in "
        "source.configuration, which is checked against the document; if the build works without "
        "a configuration, the configuration is wrong; else the tab may not be an assembly"
    )
    return SourceError(msg, host, hint)


def _not_found(subject: str, quoted: str, host: str, request: str, *, page: bool) -> NotFound:
    alternative = f", or {_NOT_ASSEMBLY}" if is_definition(request) else ""
    msg = f"the server does not find {subject} (404){quoted}: deleted, not shared with you{alternative}"
    hint = _open_the_tab() if alternative else "share the linked document with the owner of the API key"
    if page:
        hint += f"; {host} answered with a web page: check that it is the host that the browser shows"
    return NotFound(msg, host, hint)


def _is_page(text: str) -> bool:
    return text[:64].lstrip().startswith("<")


def _skew(headers: Mapping[str, str]) -> float:
    """Returns the advance of this computer's clock [s]; 0 if it is near enough or the server sends no
    date."""
    server_time = date(headers.get("Date", ""))
    skew = 0.0 if server_time is None else time.time() - server_time
    return skew if abs(skew) > _MAX_SKEW else 0.0


def _minutes(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min"


def _open_the_tab() -> str:
    return "open the assembly's tab in the browser with the account of the API key, and copy its address"
