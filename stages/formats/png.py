"""PNG images: whether bytes are one that readers take, and a PNG of pixels.

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

_CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
"""The number of channels by the type of colour."""

_ADAM7 = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))
"""First column and row, and steps, of each of the smaller images."""

_PIECE = 1 << 20


def problem(data: bytes) -> str:
    """Why `data` is not a PNG that every reader takes; "" where it is one.

    The header, the lengths and check sums of the chunks, and how much they inflate to are looked at, not the
    pixels: MuJoCo loads no model at all with an image that it cannot read.
    """
    if not data.startswith(SIGNATURE):
        return "it is not a PNG"
    view, kinds, packed, at = memoryview(data), list[bytes](), list[memoryview](), len(SIGNATURE)
    while not kinds or kinds[-1] != b"IEND":
        if at + 12 > len(data):
            return "it is incomplete"
        length, kind = struct.unpack_from(">I4s", data, at)
        end = at + 12 + length
        if end > len(data):
            return "it is incomplete"
        if zlib.crc32(view[at + 4 : end - 4]) != int.from_bytes(data[end - 4 : end], "big"):
            return "it is damaged"
        if not kinds and (kind != b"IHDR" or length != 13):
            return "it is damaged: it does not begin with its header"
        kinds.append(kind)
        packed += [view[at + 8 : end - 4]] if kind == b"IDAT" else []
        at = end
    header = struct.unpack_from(">IIBBBBB", data, 16)
    why = _of_header(header, b"PLTE" in kinds)
    return why or ("" if _inflates(packed, _size(header)) else "it is damaged: its pixels are incomplete")


def pixels(head: bytes) -> int:
    """How many pixels the first 24 bytes of a PNG say that it has; 0 where they are of no PNG."""
    if len(head) < 24 or not head.startswith(SIGNATURE):
        return 0
    width, height = struct.unpack_from(">II", head, 16)
    return int(width) * int(height)


def encode(pixels: npt.NDArray[np.uint8]) -> bytes:
    """The file of an image (height, width, 1, 3 or 4 channels), its first row at the top. Each row is stored
    as its difference from the one above (filter 2), which halves the size of photos."""
    # Late: an unchanged build needs no numpy.
    import numpy as np

    height, width, channels = pixels.shape
    header = struct.pack(">IIBBBBB", width, height, 8, _COLOUR_TYPES[channels], 0, 0, 0)
    above = np.concatenate([np.zeros_like(pixels[:1]), pixels[:-1]])
    rows = (pixels - above).reshape(height, width * channels)
    filtered = np.concatenate([np.full((height, 1), 2, dtype=np.uint8), rows], axis=1)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(filtered.tobytes(), 6)), (b"IEND", b""))
    return SIGNATURE + b"".join(_chunk(kind, content) for kind, content in chunks)


def _of_header(header: tuple[int, ...], has_palette: bool) -> str:
    width, height, depth, colour, compression, filtering, interlace = header
    legal = depth in _DEPTHS.get(colour, ()) and (compression, filtering) == (0, 0) and interlace < 2
    if not legal or not width or not height or (colour == 3 and not has_palette):
        return "it is damaged: its header is invalid"
    if width * height > MOST_PIXELS:
        return f"it has {width} × {height} pixels; at most {MOST_PIXELS} are carried"
    return ""


def _size(header: tuple[int, ...]) -> int:
    """The bytes of an image's rows, each with its filter; interlaced it is seven smaller images."""
    width, height, depth, colour, _, _, interlace = header
    bits = depth * _CHANNELS[colour]
    found = 0
    for left, top, right, down in _ADAM7 if interlace else ((0, 0, 1, 1),):
        columns, rows = -((left - width) // right), -((top - height) // down)
        found += rows * (1 + (columns * bits + 7) // 8) if columns > 0 and rows > 0 else 0
    return found


def _inflates(packed: list[memoryview], size: int) -> bool:
    """Whether the pieces of a zlib stream come to just so many bytes."""
    stream, found = zlib.decompressobj(), 0
    for piece in packed:
        rest: bytes | memoryview = piece
        while rest and found <= size:
            try:
                found += len(stream.decompress(rest, _PIECE))
            except zlib.error:
                return False
            rest = stream.unconsumed_tail
    return stream.eof and found == size


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
