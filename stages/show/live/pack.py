"""The pack as bytes: a header in JSON, and the buffers that it names by their place.

gzip of: the length of the header (uint32, little endian), the header (UTF-8, padded with spaces to a
multiple of 4), the binary part. Offsets in the header are bytes into the binary part, multiples of 4.
"""

import gzip
import json
import struct
from collections.abc import Mapping
from typing import Any

VERSION = 1
_ALIGNMENT = 4


class Buffers:
    """The binary part of a pack, one buffer after the other; equal buffers are stored once."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0
        self._places: dict[bytes, int] = {}

    def add(self, data: bytes) -> int:
        """Stores a buffer and returns its place [bytes]."""
        if data not in self._places:
            padding = bytes(-len(data) % _ALIGNMENT)
            self._places[data] = self._size
            self._parts += [data, padding]
            self._size += len(data) + len(padding)
        return self._places[data]

    def content(self) -> bytes:
        return b"".join(self._parts)


def packed(scene: Mapping[str, Any], buffers: Buffers) -> bytes:
    """The pack: the same bytes for the same scene and buffers."""
    header = json.dumps(scene, ensure_ascii=False, separators=(",", ":"), allow_nan=False).encode()
    header += b" " * (-len(header) % _ALIGNMENT)
    whole = struct.pack("<I", len(header)) + header + buffers.content()
    return gzip.compress(whole, compresslevel=9, mtime=0)


def unpacked(pack: bytes) -> tuple[dict[str, Any], bytes]:
    """The header and the binary part of a pack."""
    whole = gzip.decompress(pack)
    (length,) = struct.unpack_from("<I", whole)
    return json.loads(whole[4 : 4 + length]), whole[4 + length :]
