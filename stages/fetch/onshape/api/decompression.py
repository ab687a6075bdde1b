"""Decompresses the body of a reply piece by piece, so that its reader may stop at a size limit."""

import zlib
from collections.abc import Iterable, Iterator

ACCEPTED = "gzip"
"""The accepted encoding. A reply with another encoding, or with several, is not read."""

_MAX_PIECE = 1 << 18
"""Largest size of a decompressed piece [bytes]."""

_GZIP = 16 + zlib.MAX_WBITS


class UnknownEncodingError(Exception):
    """The error that a reply has an unexpected content encoding; its text names the encoding."""


class DamagedError(Exception):
    """The error that a body is not valid gzip, or is incomplete."""


def decompressed(pieces: Iterable[bytes], encoding: str) -> Iterator[bytes]:
    """Yields the decompressed body of compressed `pieces`, in pieces of at most 256 kB.

    `encoding`: the header Content-Encoding. Raises UnknownEncodingError at once for an unexpected encoding;
    DamagedError if the body is damaged.
    """
    name = encoding.strip().lower()
    if name in ("", "identity"):
        return iter(pieces)
    if name in ("gzip", "x-gzip"):
        return _inflated(pieces)
    raise UnknownEncodingError("".join(char if char.isprintable() else " " for char in encoding)[:40])


def _inflated(pieces: Iterable[bytes]) -> Iterator[bytes]:
    """Inflates a gzip stream: one member or several, one after the other."""
    inflate, has_begun = zlib.decompressobj(_GZIP), False
    try:
        for piece in pieces:
            remaining = piece
            while remaining:
                if inflate.eof:
                    inflate = zlib.decompressobj(_GZIP)
                has_begun = True
                yield inflate.decompress(remaining, _MAX_PIECE)
                remaining = inflate.unused_data if inflate.eof else inflate.unconsumed_tail
    except zlib.error as error:
        raise DamagedError(str(error)) from None
    if has_begun and not inflate.eof:
        msg = "the compressed body is cut short"
        raise DamagedError(msg)
