"""A reply's body as it comes over the wire, unpacked piece by piece: its reader may stop at a bound."""

import zlib
from collections.abc import Iterable, Iterator

ACCEPTED = "gzip"
"""What is asked for. A reply that is packed in any other way, or several times over, is not read."""

_PIECE = 1 << 18
_GZIP = 16 + zlib.MAX_WBITS


class UnknownEncodingError(Exception):
    """The reply is packed in a way that was not asked for; its text names the way."""


class DamagedError(Exception):
    """What came is no gzip, or ends before its end."""


def unpacked(pieces: Iterable[bytes], encoding: str) -> Iterator[bytes]:
    """The body whose packed `pieces` come one after the other, itself in pieces of 256 kB at most.

    `encoding`: the header Content-Encoding. UnknownEncodingError at once for one that was not asked
    for; DamagedError where the body is found to be harmed.
    """
    name = encoding.strip().lower()
    if name in ("", "identity"):
        return iter(pieces)
    if name in ("gzip", "x-gzip"):
        return _inflated(pieces)
    raise UnknownEncodingError("".join(char if char.isprintable() else " " for char in encoding)[:40])


def _inflated(pieces: Iterable[bytes]) -> Iterator[bytes]:
    """A gzip stream inflated: one member or several, one after the other."""
    inflate, begun = zlib.decompressobj(_GZIP), False
    try:
        for piece in pieces:
            waiting = piece
            while waiting:
                if inflate.eof:
                    inflate = zlib.decompressobj(_GZIP)
                begun = True
                yield inflate.decompress(waiting, _PIECE)
                waiting = inflate.unused_data if inflate.eof else inflate.unconsumed_tail
    except zlib.error as error:
        raise DamagedError(str(error)) from None
    if begun and not inflate.eof:
        msg = "the packed body ends before its end"
        raise DamagedError(msg)
