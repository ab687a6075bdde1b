"""Hosts on this computer: the API key goes there in clear, so a file alone must not choose the port."""

from collections.abc import Collection, Mapping
from typing import Any

from linkwright.pipeline.config.files.trust import CODE
from linkwright.stages.fetch.onshape.url import parse
from linkwright.stages.robot.errors import ConfigError, Diagnostic

VARIABLE = "LINKWRIGHT_HOST"
"""The variable that names the host on this computer that files may name: `http://127.0.0.1:8000`."""

KEY = "source.url"


def unnamed(tree: Mapping[str, Any], typed: Collection[str], environ: Mapping[str, str]) -> list[Diagnostic]:
    """The problem of an address on this computer that only a file names.

    `typed`: the addresses that the command line gives, or the caller in Python.
    """
    source = tree.get("source")
    origin = _origin(source.get("url") if isinstance(source, Mapping) else None)
    if not origin or origin in {_origin(address) for address in typed}:
        return []
    named = environ.get(VARIABLE, "").strip().rstrip("/").lower()
    if origin == named:
        return []
    text = f"a file must not send the API key to a port of this computer ({origin})"
    text += f"; {VARIABLE} names another host" if named else ""
    hint = f"if you trust it: set {VARIABLE}={origin}, or give {KEY} on the command line"
    return [Diagnostic(CODE, text, KEY, hint)]


def _origin(address: Any) -> str:
    """Scheme, host and port of an address on this computer; "" for others, also those that are refused."""
    try:
        url = parse(address) if isinstance(address, str) else None
    except ConfigError:
        return ""
    return url.origin if url is not None and url.loopback else ""
