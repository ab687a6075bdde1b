"""Parses the address of an assembly, as the browser shows it."""

import re
from dataclasses import dataclass, field
from urllib.parse import SplitResult, unquote, urlsplit

from linkwright.stages.robot.errors import ConfigError

EXAMPLE = (
    "https://cad.onshape.com/documents/5f1a0c2b9d8e7f6a5b4c3d2e"
    "/w/0a1b2c3d4e5f60718293a4b5/e/a1b2c3d4e5f60718293a4b5c"
)
_PATH = re.compile(r"/documents/([0-9a-f]{24})/([wvm])/([0-9a-f]{24})/e/([0-9a-f]{24})/?", re.IGNORECASE)
_PATH_WITHOUT_TAB = re.compile(r"/documents/[0-9a-f]{24}(/[wvm]/[0-9a-f]{24})?/?", re.IGNORECASE)
OWNER_DOMAIN = "onshape.com"
"""The domain whose hosts may be sent a key."""

_OWNER_HOST = re.compile(r"([a-z0-9]([a-z0-9-]*[a-z0-9])?\.)*onshape\.com(:443)?")
_BYTE = r"(25[0-5]|2[0-4]\d|1\d\d|[1-9]?\d)"
_LOOPBACK = re.compile(rf"(localhost|127\.{_BYTE}\.{_BYTE}\.{_BYTE}|\[::1\])(:\d{{1,5}})?", re.ASCII)
_AMBIGUOUS = re.compile(r"[\s\\\x00-\x1f\x7f]")
"""Characters before the query of an address on which libraries disagree: some end the host there, some drop
them."""


@dataclass(frozen=True, slots=True)
class AssemblyUrl:
    """The address of an assembly."""

    origin: str
    """Scheme and host: "https://cad.onshape.com"."""

    document: str
    pin: str
    """Workspace "w/<id>", version "v/<id>" or microversion "m/<id>"."""

    element: str
    configuration: str
    """Onshape's own text, decoded once; "default" if the address has none."""

    text: str = field(default="", compare=False)
    """The address as the user typed it."""

    @property
    def pinned(self) -> bool:
        """Whether the content can never change (a version or a microversion)."""
        return not self.pin.startswith("w/")

    @property
    def loopback(self) -> bool:
        """Whether the host is this computer."""
        return is_loopback(urlsplit(self.origin).netloc)


def parse(text: str) -> AssemblyUrl:
    """Returns the assembly that a browser's address names. Raises ConfigError for anything else.

    The parts for the browser alone (`renderMode`, `uiState`, the fragment) are dropped.
    """
    parts = _split(text.strip())
    match = _PATH.fullmatch(parts.path)
    if match is None:
        if _PATH_WITHOUT_TAB.fullmatch(parts.path):
            raise _refused(parts, "it names a document, but no tab of it (…/e/<element>)")
        raise _refused(parts, "its path is not /documents/<id>/w|v|m/<id>/e/<id>, each id 24 hex digits")
    document, kind, version, element = (piece.lower() for piece in match.groups())
    return AssemblyUrl(
        origin=_origin(parts),
        document=document,
        pin=f"{kind}/{version}",
        element=element,
        configuration=_configuration(parts.query),
        text=text,
    )


def split(text: str) -> SplitResult:
    """Splits an address. Raises ValueError if libraries could disagree about its host."""
    if _AMBIGUOUS.search(re.split(r"[?#]", text, maxsplit=1)[0]):
        msg = "white space, a control character or a backslash"
        raise ValueError(msg)
    parts = urlsplit(text)
    _ = parts.port  # the library checks the port only when it is read
    return parts


def key_origin(parts: SplitResult) -> str:
    """Returns scheme, host and port of an address where a key may be sent: a host of Onshape over https, or
    this computer; "" for other addresses."""
    host = parts.netloc
    if parts.scheme == "https" and is_owner(host):
        return _origin(parts)
    return _origin(parts) if parts.scheme in ("http", "https") and is_loopback(host) else ""


def is_owner(host: str) -> bool:
    """Tells whether a host, as an address has it, is Onshape's."""
    return host.isascii() and bool(_OWNER_HOST.fullmatch(host.lower()))


def is_loopback(host: str) -> bool:
    """Tells whether a host, with its port as an address has it, is this computer."""
    return host.isascii() and bool(_LOOPBACK.fullmatch(host.lower()))


def _origin(parts: SplitResult) -> str:
    return f"{parts.scheme}://{parts.netloc.lower()}"


def _split(text: str) -> SplitResult:
    """Splits an address. Raises ConfigError unless its scheme and host may be sent a key."""
    try:
        parts = split(text)
    except ValueError:
        msg = "the address is not a URL"
        raise ConfigError(msg, "source.url", _hint()) from None
    if parts.scheme not in ("https", "http") or not parts.hostname:
        msg = "expected an address that starts with https://"
        raise ConfigError(msg, "source.url", _hint())
    if "@" in parts.netloc:
        # The address is not shown: the text before the @ may be a key.
        msg = "the address must not contain a user name or password"
        raise ConfigError(msg, "source.url", "keys belong in ONSHAPE_ACCESS_KEY and ONSHAPE_SECRET_KEY")
    if key_origin(parts):
        return parts
    if parts.scheme == "http" and is_owner(parts.netloc):
        raise _refused(parts, "plain http would send your key unencrypted; use https://")
    raise _refused(parts, f"its host is not {OWNER_DOMAIN} or below it, and no key is sent elsewhere")


def _configuration(query: str) -> str:
    """Returns the value of `configuration`; plus signs stay, since Onshape encodes spaces as plus signs."""
    for item in query.split("&"):
        name, _, value = item.partition("=")
        if name == "configuration" and value:
            return unquote(value)
    return "default"


def _refused(parts: SplitResult, why: str) -> ConfigError:
    address = f"{parts.scheme}://{parts.netloc}{parts.path}"
    msg = f"{address} is not the address of an Onshape assembly: {why}"
    return ConfigError(msg, "source.url", _hint())


def _hint() -> str:
    return f"open the assembly's tab in the browser and copy its address, for example {EXAMPLE}"
