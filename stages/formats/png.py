"""PNG images: whether bytes are one, without decoding it, and a PNG of pixels.

Layout and rules are those of the PNG specification (ISO/IEC 15948).
"""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

LARGEST = 1 << 26
"""Larger images are not read [bytes]."""

MOST_PIXELS = 1 << 26
"""Images with more pixels are not carried: a reader would need gigabytes."""

SIGNATURE = b"\x89PNG\r\n\x1a\n"

_DEPTHS = {0: (1, 2, 4, 8, 16), 2: (8, 16), 3: (1, 2, 4, 8), 4: (8, 16), 6: (8, 16)}
"""The bit depths of each type of colour."""

_COLOUR_TYPES = {1: 0, 3: 2, 4: 6}
"""The type of colour by the number of channels: grey, RGB, RGBA."""


def problem(data: bytes) -> str:
    """Why `data` is not a PNG that every reader takes; "" where it is one.

    The header, the order, lengths and check sums of the chunks are looked at, not the pixels.
    """
    if not data.startswith(SIGNATURE):
        return "it is not a PNG"
    kinds, at = list[bytes](), len(SIGNATURE)
    while not kinds or kinds[-1] != b"IEND":
        if at + 12 > len(data):
            return "it is incomplete"
        length, kind = struct.unpack_from(">I4s", data, at)
        end = at + 12 + length
        if end > len(data):
            return "it is incomplete"
        if zlib.crc32(data[at + 4 : end - 4]) != int.from_bytes(data[end - 4 : end], "big"):
            return "it is damaged"
        if not kinds and (kind != b"IHDR" or length != 13):
            return "it is damaged: it does not begin with its header"
        kinds.append(kind)
        at = end
    if b"IDAT" not in kinds:
        return "it has no pixels"
    return _of_header(data, b"PLTE" in kinds)


def encode(pixels: npt.NDArray[np.uint8]) -> bytes:
    """The file of an image (height, width, 1, 3 or 4 channels), its first row at the top. Each row is stored
    as its difference from the one above (filter 2), which halves the size of photos."""
    import numpy as np

    height, width, channels = pixels.shape
    header = struct.pack(">IIBBBBB", width, height, 8, _COLOUR_TYPES[channels], 0, 0, 0)
    above = np.concatenate([np.zeros_like(pixels[:1]), pixels[:-1]])
    rows = (pixels - above).reshape(height, width * channels)
    filtered = np.concatenate([np.full((height, 1), 2, dtype=np.uint8), rows], axis=1)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(filtered.tobytes(), 6)), (b"IEND", b""))
    return SIGNATURE + b"".join(_chunk(kind, content) for kind, content in chunks)


def _of_header(data: bytes, has_palette: bool) -> str:
    width, height, depth, colour, compression, filtering, interlace = struct.unpack_from(">IIBBBBB", data, 16)
    legal = depth in _DEPTHS.get(colour, ()) and (compression, filtering) == (0, 0) and interlace < 2
    if not legal or not width or not height or (colour == 3 and not has_palette):
        return "it is damaged: its header is invalid"
    if width * height > MOST_PIXELS:
        return f"it has {width} × {height} pixels; at most {MOST_PIXELS} are carried"
    return ""


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
