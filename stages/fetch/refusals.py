"""What a server's refusal means, and what to do about it."""

import json
import re
from collections.abc import Mapping

from stages.fetch.requests import describe, is_definition
from stages.robot.errors import (
    AuthError,
    LinkwrightError,
    NotFound,
    ProtocolError,
    QuotaExhausted,
    RateLimited,
    SourceError,
)

_NOT_ASSEMBLY = "it may not be an assembly (a part studio or a drawing?)"


def refusal(status: int, headers: Mapping[str, str], text: str, request: str, host: str) -> LinkwrightError:
    """The error for a reply whose status is not 200.

    `text` is the body, free of secrets; `headers` looks names up without regard to case.
    """
    what = describe(request)
    said = server_words(text)
    quoted = f' ("{said}")' if said else ""
    if status in (401, 403):
        return _denied(status, what, quoted, host)
    if status == 402:
        msg = f"the yearly quota of API calls is used up (402), so {what} was not given{quoted}"
        hint = (
            "what was fetched is kept; look at My account > Developer in Onshape, or build from a bundle "
            "(source=bundle) or the cache"
        )
        return QuotaExhausted(msg, host, hint)
    if status == 404:
        return _absent(what, quoted, host, request)
    if status == 429:
        wait = headers.get("Retry-After", "")
        after = f"; it asks to wait {wait} s" if re.fullmatch(r"\d{1,9}", wait) else ""
        msg = f"the server allows no more calls of this kind for now (429){after}{quoted}"
        return RateLimited(msg, host, "run the same command again later; what was fetched is kept")
    if status == 400 and is_definition(request):
        msg = f"the server refuses to give {what} (400){quoted}: {_NOT_ASSEMBLY}"
        return SourceError(msg, host, _open_the_tab())
    if 300 <= status < 400:
        msg = f"the server points elsewhere for {what} ({status}), which is not followed"
        return ProtocolError(msg, host, "use the host that the browser shows for this document")
    if status >= 500 or status == 499:
        msg = f"the server failed to give {what} ({status}){quoted}"
        hint = "run the same command again in a while; if it fails each time, try a smaller assembly"
        return ProtocolError(msg, host, hint)
    msg = f"the server refuses to give {what} ({status}){quoted}"
    return ProtocolError(msg, host, "check that the document opens in the browser with the same account")


def server_words(text: str) -> str:
    """What the server says, short and on one line; nothing for web pages and other noise."""
    try:
        data = json.loads(text)
    except ValueError:
        return ""
    message = data.get("message") if isinstance(data, dict) else None
    if not isinstance(message, str):
        return ""
    line = " ".join("".join(char if char.isprintable() else " " for char in message).split())
    return line if len(line) <= 200 else line[:199] + "…"


def _denied(status: int, what: str, quoted: str, host: str) -> AuthError:
    if status == 401:
        msg = f"the server does not accept the API key (401){quoted}"
        hint = (
            f"check ONSHAPE_ACCESS_KEY and ONSHAPE_SECRET_KEY; a key works only on the host where it was "
            f"made: is it a key of {host}?"
        )
        return AuthError(msg, host, hint)
    msg = f"the API key may not read {what} (403){quoted}"
    hint = "give the key read permission, share the document with its owner, and check this computer's clock"
    return AuthError(msg, host, hint)


def _absent(what: str, quoted: str, host: str, request: str) -> NotFound:
    maybe = f", or {_NOT_ASSEMBLY}" if is_definition(request) else ""
    msg = f"the server does not find {what} (404){quoted}: gone, or private to others{maybe}"
    hint = _open_the_tab() if maybe else "share the linked document with the owner of the API key"
    return NotFound(msg, host, hint)


def _open_the_tab() -> str:
    return "open the assembly's tab in the browser, with the account of the API key, and copy its address"
