"""Follows redirects by hand, so that a key is sent only to hosts of its owner."""

from urllib.parse import urljoin, urlsplit

from stages.fetch.onshape.url import OWNER, is_loopback
from stages.robot.errors import ProtocolError

MOST = 3
"""Redirects followed for one call: each of them is billed."""

_SAME_METHOD = (307, 308)
_ANY = (301, 302, 303, *_SAME_METHOD)


def followed(method: str, status: int) -> bool:
    """Whether a reply with this status is a redirect to follow.

    301, 302 and 303 would turn a POST into a GET, which is another request.
    """
    return status in (_ANY if method == "GET" else _SAME_METHOD)


def target(here: str, location: str, what: str) -> str:
    """The address that a reply from the address `here` points to.

    ProtocolError where a key must not be sent there: Onshape's hosts point to Onshape's hosts over
    https, this computer to itself, and any other host to itself. `what` names what was asked for.
    """
    before = urlsplit(here)
    try:
        address = urljoin(here, location) if location else ""
        parts = urlsplit(address)
        host, _ = parts.hostname or "", parts.port  # a port that is none shows only when it is read
    except ValueError:
        parts, host = urlsplit(""), ""
    if not host:
        msg = f"the server redirects the request for {what} without a valid address"
        raise ProtocolError(msg, before.netloc, "use the host that the browser shows for this document")
    if "@" in parts.netloc or not _safe(before.scheme, before.hostname or "", parts.scheme, host):
        to = f"{parts.scheme}://{host}"
        msg = f"the server redirects the request for {what} to {to}; your key is not sent there"
        raise ProtocolError(msg, before.netloc, "use the host that the browser shows for this document")
    return parts._replace(fragment="").geturl()


def moved(here: str, there: str) -> str | None:
    """The new origin, where only the host changed: the region that keeps a document."""
    old, new = urlsplit(here), urlsplit(there)
    same = (old.path, old.query) == (new.path, new.query)
    return f"{new.scheme}://{new.netloc}" if same and old.netloc != new.netloc else None


def _safe(old_scheme: str, old: str, scheme: str, host: str) -> bool:
    if is_loopback(old):
        return is_loopback(host) and scheme in ("http", "https")
    if scheme != "https" or old_scheme != "https":
        return False
    return host == old or (_onshape(old) and _onshape(host))


def _onshape(host: str) -> bool:
    return host == OWNER or host.endswith(f".{OWNER}")
