"""Follows redirects by hand, so that a key is sent only to hosts of its owner."""

from urllib.parse import SplitResult, urljoin, urlsplit

from linkwright.stages.fetch.onshape.url import is_loopback, key_origin, split
from linkwright.stages.robot.errors import ProtocolError

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
    https, and this computer to the same port. `what` names what was asked for.
    """
    before = urlsplit(here)
    try:
        # What joins drops line breaks, which the address must not have.
        split(location)
        parts = split(urljoin(here, location)) if location else urlsplit("")
    except ValueError:
        parts = urlsplit("")
    if not parts.hostname:
        msg = f"the server redirects the request for {what} without a valid address"
        raise ProtocolError(msg, before.netloc, "use the host that the browser shows for this document")
    if not _safe(before, parts):
        to = f"{parts.scheme}://{parts.hostname}"
        msg = f"the server redirects the request for {what} to {to}; your key is not sent there"
        raise ProtocolError(msg, before.netloc, "use the host that the browser shows for this document")
    return parts._replace(fragment="").geturl()


def moved(here: str, there: str) -> str | None:
    """The new origin, where only the host changed: the region that keeps a document."""
    old, new = urlsplit(here), urlsplit(there)
    same = (old.path, old.query) == (new.path, new.query)
    return f"{new.scheme}://{new.netloc}" if same and old.netloc != new.netloc else None


def _safe(before: SplitResult, after: SplitResult) -> bool:
    old, new = key_origin(before), key_origin(after)
    if is_loopback(before.netloc) or is_loopback(after.netloc):
        return new == old != ""
    return bool(old and new)
