"""Reads the header of a part studio's triangles in their compact form, which is all that an unchanged build
reads.

The form is an exact and deterministic function of the bodies. After a line that names it and its
version: the length of the header (unsigned, 4 bytes), the header (JSON), then for each body

    points     n × 3 float64 [m], in the part studio's frame
    triangles  m × 3 int32, indices into the points, counter-clockwise seen from outside
    colours    m × uint16, indices into the header's palette of the body
    texcoords  m × 3 × 2 float32, of a body with textures only: (u, v) of each corner

all little-endian. The header has `bodies`: id, points (n), triangles (m), palette (RGBA in 0..1), and of a
body with textures `textures`: of each colour of the palette the SHA-256 of its image, "" for none. u runs to
the right and v upwards from the lower left corner of the image, as in OBJ. A closed mesh takes about 26 bytes
a triangle, or 50 with textures.
"""

import json
import math
import re
import struct
from typing import Any

from linkwright.stages.robot.errors import ProtocolError

MAGIC = b"linkwright triangles 1\n"

LENGTH = struct.Struct("<I")
"""The format of the header's length."""

_MAX_HEADER = 1 << 24
"""Largest length of the header [bytes]."""

POINT, TRIANGLE, COLOUR, TEXCOORDS = 24, 12, 2, 24
"""Sizes [bytes] of a point, and of a triangle in each array."""

_DIGEST = re.compile(r"([0-9a-f]{64})?")
HINT = "fetch again with source.refresh=true"
"""The hint for damaged triangles."""


def names(data: bytes) -> frozenset[str]:
    """Returns the ids of the bodies that have triangles. Raises ProtocolError if `data` is not the compact
    form."""
    return frozenset(record["id"] for record in opened(data)[0] if record["triangles"])


def is_compact(data: bytes) -> bool:
    """Tells whether `data` begins as the compact form does."""
    return data.startswith(MAGIC)


def check(data: bytes) -> None:
    """Raises ProtocolError if `data` is not the compact form, or is cut short."""
    opened(data)


def textures(data: bytes) -> frozenset[str]:
    """Returns the digests of the images that the bodies name. Raises ProtocolError if `data` is not the
    compact form."""
    return frozenset(digest for record in opened(data)[0] for digest in record.get("textures", ()) if digest)


def opened(data: bytes) -> tuple[list[dict[str, Any]], int]:
    """Returns the header's bodies, and the start of the arrays. Raises ProtocolError if these are
    incomplete."""
    start = len(MAGIC) + LENGTH.size
    try:
        if not is_compact(data) or len(data) < start:
            msg = "it does not begin as such"
            raise ValueError(msg)
        (length,) = LENGTH.unpack_from(data, len(MAGIC))
        if length > _MAX_HEADER:
            msg = f"its header has {length} bytes"
            raise ValueError(msg)
        records = json.loads(data[start : start + length])["bodies"]
        size = sum(_size(record) for record in records)
    except (AttributeError, KeyError, RecursionError, TypeError, ValueError) as error:
        msg = f"the triangles are not in the compact form: {error}"
        raise ProtocolError(msg, hint=HINT) from None
    if len(data) != start + length + size:
        msg = f"the triangles have {len(data)} bytes where {start + length + size} are announced"
        raise ProtocolError(msg, hint=HINT)
    return records, start + length


def _size(record: dict[str, Any]) -> int:
    """Returns the size of a body's arrays [bytes], by its record in the header."""
    points, triangles = record["points"], record["triangles"]
    counts = isinstance(points, int) and isinstance(triangles, int) and min(points, triangles) >= 0
    colours = all(len(colour) == 4 and all(map(_is_channel, colour)) for colour in record["palette"])
    images = record.get("textures", [])
    textured = len(images) in (0, len(record["palette"])) and all(map(_DIGEST.fullmatch, images))
    if not counts or not colours or not textured or not isinstance(record["id"], str):
        msg = f"the record of body {record['id']!r} is malformed"
        raise ValueError(msg)
    return int(points * POINT + triangles * (TRIANGLE + COLOUR + (TEXCOORDS if images else 0)))


def _is_channel(value: Any) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)
