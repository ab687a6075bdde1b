"""Follows redirects by hand, so that a key is sent only to hosts of its owner."""

from urllib.parse import SplitResult, urljoin, urlsplit

from linkwright.stages.fetch.onshape.url import is_loopback, key_origin, split
from linkwright.stages.robot.errors import ProtocolError

MAX_REDIRECTS = 3
"""Largest number of redirects followed for a call: each of them is billed."""

_SAME_METHOD = (307, 308)
"""Statuses of redirects that keep the method of the request."""

_ALL_REDIRECTS = (301, 302, 303, *_SAME_METHOD)


def must_follow(method: str, status: int) -> bool:
    """Tells whether a reply with this status is a redirect to follow.

    301, 302 and 303 would turn a POST into a GET, which is another request.
    """
    return status in (_ALL_REDIRECTS if method == "GET" else _SAME_METHOD)


def target(current_address: str, location: str, subject: str) -> str:
    """Returns the address that a reply from the address `current_address` points to.

    Raises ProtocolError if a key must not be sent there: Onshape's hosts point to Onshape's hosts over https,
    and this computer to the same port. `subject` names the requested thing.
    """
    address = urlsplit(current_address)
    try:
        # `urljoin` drops line breaks, which the address must not have.
        split(location)
        parts = split(urljoin(current_address, location)) if location else urlsplit("")
    except ValueError:
        parts = urlsplit("")
    if not parts.hostname:
        msg = f"the server redirects the request for {subject} without a valid address"
        raise ProtocolError(msg, address.netloc, "use the host that the browser shows for this document")
    if not _may_send_key(address, parts):
        to = f"{parts.scheme}://{parts.hostname}"
        msg = f"the server redirects the request for {subject} to {to}; your key is not sent there"
        raise ProtocolError(msg, address.netloc, "use the host that the browser shows for this document")
    return parts._replace(fragment="").geturl()


def moved_origin(old_address: str, new_address: str) -> str | None:
    """Returns the new origin if only the host changed: the region that keeps a document."""
    old, new = urlsplit(old_address), urlsplit(new_address)
    same_path = (old.path, old.query) == (new.path, new.query)
    return f"{new.scheme}://{new.netloc}" if same_path and old.netloc != new.netloc else None


def _may_send_key(before: SplitResult, after: SplitResult) -> bool:
    old_origin, new_origin = key_origin(before), key_origin(after)
    if is_loopback(before.netloc) or is_loopback(after.netloc):
        return new_origin == old_origin != ""
    return bool(old_origin and new_origin)
