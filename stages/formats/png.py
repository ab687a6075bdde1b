"""Checks that readers accept a PNG image, and writes pixels as PNG.

Layout and rules are those of the PNG specification (ISO/IEC 15948).
"""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

MAX_BYTES = 1 << 26
"""Largest size of an image that is read [bytes]."""

MAX_PIXELS = 1 << 26
"""Largest number of pixels of an image that is used: beyond it a reader would need gigabytes."""

SIGNATURE = b"\x89PNG\r\n\x1a\n"
"""The first bytes of every PNG."""

_CHUNK_FRAME_BYTES = 12
"""Bytes of a chunk besides its content: four each of the length, the type and the check sum."""

_HEADER_OFFSET = 16
"""Position of the header's content: after the signature, and the header's length and type."""

_HEADER_FORMAT = ">IIBBBBB"
"""Width, height, bit depth, type of colour, compression, filtering, interlacing."""

_FILTER_UP = 2
"""PNG's number of the filter that stores the difference from the row above."""

_DEPTHS = {0: (1, 2, 4, 8, 16), 2: (8, 16), 3: (1, 2, 4, 8), 4: (8, 16), 6: (8, 16)}
"""Type of colour → its bit depths."""

_COLOUR_TYPES = {1: 0, 3: 2, 4: 6}
"""Number of channels → type of colour: grey, RGB, RGBA."""

_CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
"""Type of colour → number of channels."""

_ADAM7 = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))
"""First column and row, and steps, of each of the smaller images of an interlaced image."""

_MAX_INFLATED_PIECE = 1 << 20
"""Largest size of the pieces in which pixels are inflated [bytes]."""


def problem(data: bytes) -> str:
    """Returns the reason why `data` is not a PNG that every reader accepts; "" if it is such a PNG.

    The header, the lengths and check sums of the chunks, and their inflated sizes are checked, not the
    pixels: MuJoCo loads no model at all with an image that it cannot read.
    """
    if not data.startswith(SIGNATURE):
        return "it is not a PNG"
    view = memoryview(data)
    kinds, packed = list[bytes](), list[memoryview]()
    at = len(SIGNATURE)
    while not kinds or kinds[-1] != b"IEND":
        if at + _CHUNK_FRAME_BYTES > len(data):
            return "it is incomplete"
        length, kind = struct.unpack_from(">I4s", data, at)
        end = at + _CHUNK_FRAME_BYTES + length
        if end > len(data):
            return "it is incomplete"
        if zlib.crc32(view[at + 4 : end - 4]) != int.from_bytes(data[end - 4 : end], "big"):
            return "it is damaged"
        if not kinds and (kind != b"IHDR" or length != 13):
            return "it is damaged: it does not begin with its header"
        kinds.append(kind)
        packed += [view[at + 8 : end - 4]] if kind == b"IDAT" else []
        at = end
    header = struct.unpack_from(_HEADER_FORMAT, data, _HEADER_OFFSET)
    header_problem = _header_problem(header, b"PLTE" in kinds)
    if header_problem:
        return header_problem
    return "" if _inflates_to(packed, _filtered_size(header)) else "it is damaged: its pixels are incomplete"


def pixel_count(head: bytes) -> int:
    """Returns the number of pixels of a PNG from its first 24 bytes; 0 for other bytes."""
    if len(head) < 24 or not head.startswith(SIGNATURE):
        return 0
    width, height = struct.unpack_from(">II", head, _HEADER_OFFSET)
    return int(width) * int(height)


def encode(pixels: npt.NDArray[np.uint8]) -> bytes:
    """Returns the PNG of an image (height, width, channels), its first row at the top. The channels are grey,
    RGB or RGBA.

    Each row is stored as its difference from the row above, which halves the size of photos.
    """
    # Imported late: an unchanged build needs no numpy.
    import numpy as np

    height, width, channels = pixels.shape
    header = struct.pack(_HEADER_FORMAT, width, height, 8, _COLOUR_TYPES[channels], 0, 0, 0)
    above = np.concatenate([np.zeros_like(pixels[:1]), pixels[:-1]])
    rows = (pixels - above).reshape(height, width * channels)
    filtered = np.concatenate([np.full((height, 1), _FILTER_UP, dtype=np.uint8), rows], axis=1)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(filtered.tobytes(), 6)), (b"IEND", b""))
    return SIGNATURE + b"".join(_chunk(kind, content) for kind, content in chunks)


def _header_problem(header: tuple[int, ...], has_palette: bool) -> str:
    """Returns the reason why a reader may refuse a header, or ""."""
    width, height, depth, colour, compression, filtering, interlace = header
    legal = depth in _DEPTHS.get(colour, ()) and (compression, filtering) == (0, 0) and interlace < 2
    if not legal or not width or not height or (colour == 3 and not has_palette):
        return "it is damaged: its header is invalid"
    if width * height > MAX_PIXELS:
        return f"it has {width} × {height} pixels; at most {MAX_PIXELS} are carried"
    return ""


def _filtered_size(header: tuple[int, ...]) -> int:
    """Returns the size of an image's rows [bytes], each with its filter; an interlaced image is seven smaller
    images."""
    width, height, depth, colour, _, _, interlace = header
    bits = depth * _CHANNELS[colour]
    total = 0
    for left, top, column_step, row_step in _ADAM7 if interlace else ((0, 0, 1, 1),):
        # Rounded up.
        columns, rows = -((left - width) // column_step), -((top - height) // row_step)
        total += rows * (1 + (columns * bits + 7) // 8) if columns > 0 and rows > 0 else 0
    return total


def _inflates_to(packed: list[memoryview], size: int) -> bool:
    """Tells whether the pieces of a zlib stream inflate to exactly this size [bytes]."""
    stream, inflated = zlib.decompressobj(), 0
    for piece in packed:
        remainder: bytes | memoryview = piece
        while remainder and inflated <= size:
            try:
                inflated += len(stream.decompress(remainder, _MAX_INFLATED_PIECE))
            except zlib.error:
                return False
            remainder = stream.unconsumed_tail
    return stream.eof and inflated == size


def _chunk(kind: bytes, content: bytes) -> bytes:
    """Returns a chunk of this type, with its length and check sum."""
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
