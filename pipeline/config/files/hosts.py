"""Checks hosts on this computer: the API key is sent there in clear, so no file alone may choose the port."""

from collections.abc import Collection, Mapping
from typing import Any

from linkwright.pipeline.config.files.trust import TRUST_CODE
from linkwright.stages.fetch.onshape.url import parse
from linkwright.stages.robot.errors import ConfigError, Diagnostic

HOST_VARIABLE = "LINKWRIGHT_HOST"
"""Environment variable with the host on this computer that files may name: `http://127.0.0.1:8000`."""

URL_KEY = "source.url"


def host_problems(
    tree: Mapping[str, Any], typed: Collection[str], environ: Mapping[str, str]
) -> list[Diagnostic]:
    """Returns the problem of an address on this computer that only a file names, or [].

    `typed`: the addresses that the command line names, or the caller in Python.
    """
    source = tree.get("source")
    origin = _origin(source.get("url") if isinstance(source, Mapping) else None)
    if not origin or origin in {_origin(address) for address in typed}:
        return []
    trusted_host = environ.get(HOST_VARIABLE, "").strip().rstrip("/").lower()
    if origin == trusted_host:
        return []
    text = f"a file must not send the API key to a port of this computer ({origin})"
    text += f"; {HOST_VARIABLE} names another host" if trusted_host else ""
    hint = f"if you trust it: set {HOST_VARIABLE}={origin}, or give {URL_KEY} on the command line"
    return [Diagnostic(TRUST_CODE, text, URL_KEY, hint)]


def _origin(address: Any) -> str:
    """Returns scheme, host and port of an address on this computer; "" for other and invalid addresses."""
    try:
        url = parse(address) if isinstance(address, str) else None
    except ConfigError:
        return ""
    return url.origin if url is not None and url.loopback else ""
