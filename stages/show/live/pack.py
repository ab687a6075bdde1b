"""Writes and reads a pack as bytes: a header in JSON, and buffers to which it refers by their offset.

A pack is the gzip of the length of the header (uint32, little endian), the header (UTF-8, padded with spaces
to a multiple of 4), and the binary part. Offsets in the header are bytes into the binary part, multiples of
4.
"""

import gzip
import json
import struct
from collections.abc import Mapping
from typing import Any

VERSION = 1
_ALIGNMENT = 4


class Buffers:
    """Collects the binary part of a pack, buffer after buffer; equal buffers are stored once."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0
        self._offsets: dict[bytes, int] = {}

    def add(self, data: bytes) -> int:
        """Stores a buffer and returns its offset [bytes]."""
        if data not in self._offsets:
            padding = bytes(-len(data) % _ALIGNMENT)
            self._offsets[data] = self._size
            self._parts += [data, padding]
            self._size += len(data) + len(padding)
        return self._offsets[data]

    def content(self) -> bytes:
        return b"".join(self._parts)


def pack_bytes(scene: Mapping[str, Any], buffers: Buffers) -> bytes:
    """Returns the pack of a header and its buffers: the same bytes whenever these are equal."""
    header = json.dumps(scene, ensure_ascii=False, separators=(",", ":"), allow_nan=False).encode()
    header += b" " * (-len(header) % _ALIGNMENT)
    content = struct.pack("<I", len(header)) + header + buffers.content()
    return gzip.compress(content, compresslevel=9, mtime=0)


def read_pack(pack: bytes) -> tuple[dict[str, Any], bytes]:
    """Returns the header and the binary part of a pack."""
    content = gzip.decompress(pack)
    (length,) = struct.unpack_from("<I", content)
    return json.loads(content[4 : 4 + length]), content[4 + length :]
