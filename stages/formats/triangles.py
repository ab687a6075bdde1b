"""Reads the header of a part studio's triangles in the compact form.

An unchanged build reads only this header.

The form is lossless, and equal bodies give equal bytes. It begins with a line that names the form and its
version. The length of the header (unsigned, 4 bytes) and the header (JSON) follow, then for each body

    points     n × 3 float64 [m], in the part studio's frame
    triangles  m × 3 int32, indices into the points, counter-clockwise seen from outside
    colours    m × uint16, indices into the header's palette of the body
    texcoords  m × 3 × 2 float32, only if the body has textures: (u, v) of each corner

All numbers are little-endian. The header lists `bodies`, each with `id`, `points` (n), `triangles` (m),
`palette` (RGBA in 0..1) and, if the body has textures, `textures`: the SHA-256 of the image of each colour in
the palette, "" for a colour without an image. u runs to the right and v upwards from the lower left corner of
the image, as in OBJ. A closed mesh takes about 26 bytes for each triangle, or 50 with textures.
"""

import json
import math
import re
import struct
from typing import Any

from linkwright.stages.robot.errors import ProtocolError

MAGIC = b"linkwright triangles 1\n"
"""The first line of the form, with its version."""

HEADER_LENGTH = struct.Struct("<I")
"""The format of the header's length."""

_MAX_HEADER_BYTES = 1 << 24
"""Largest length of the header [bytes]."""

POINT_BYTES, TRIANGLE_BYTES, COLOUR_BYTES, TEXCOORDS_BYTES = 24, 12, 2, 24
"""Sizes [bytes] of a point, and of a triangle in each array."""

_DIGEST = re.compile(r"([0-9a-f]{64})?")
"""The SHA-256 of an image, or "" for a colour without an image."""

REFRESH_HINT = "fetch again with source.refresh=true"
"""The hint for damaged triangles."""


def ids_with_triangles(data: bytes) -> frozenset[str]:
    """Returns the ids of the bodies that have triangles. Raises ProtocolError if `data` is not the compact
    form."""
    return frozenset(record["id"] for record in read_header(data)[0] if record["triangles"])


def is_compact(data: bytes) -> bool:
    """Tells whether `data` begins with the first line of the compact form."""
    return data.startswith(MAGIC)


def require_compact(data: bytes) -> None:
    """Raises ProtocolError if `data` is not the compact form, or is cut short."""
    read_header(data)


def textures(data: bytes) -> frozenset[str]:
    """Returns the digests of the images that the bodies refer to. Raises ProtocolError if `data` is not the
    compact form."""
    return frozenset(
        digest for record in read_header(data)[0] for digest in record.get("textures", ()) if digest
    )


def read_header(data: bytes) -> tuple[list[dict[str, Any]], int]:
    """Returns the bodies that the header lists, and the position at which the arrays start. Raises
    ProtocolError if `data` is not the compact form, or is cut short."""
    start = len(MAGIC) + HEADER_LENGTH.size
    try:
        if not is_compact(data) or len(data) < start:
            msg = "their first line is not that of the form"
            raise ValueError(msg)
        (length,) = HEADER_LENGTH.unpack_from(data, len(MAGIC))
        if length > _MAX_HEADER_BYTES:
            msg = f"their header has {length} bytes, more than {_MAX_HEADER_BYTES}"
            raise ValueError(msg)
        records = json.loads(data[start : start + length])["bodies"]
        for record in records:
            _require_valid(record)
        size = sum(map(_size, records))
    except (AttributeError, KeyError, RecursionError, TypeError, ValueError) as error:
        msg = f"the triangles are not in the compact form: {error}"
        raise ProtocolError(msg, hint=REFRESH_HINT) from None
    if len(data) != start + length + size:
        msg = f"the triangles have {len(data)} bytes, but their header announces {start + length + size}"
        raise ProtocolError(msg, hint=REFRESH_HINT)
    return records, start + length


def _require_valid(record: dict[str, Any]) -> None:
    """Raises ValueError if the record of a body in the header is malformed."""
    points, triangles = record["points"], record["triangles"]
    valid_counts = isinstance(points, int) and isinstance(triangles, int) and min(points, triangles) >= 0
    valid_palette = all(len(colour) == 4 and all(map(_is_channel, colour)) for colour in record["palette"])
    images = record.get("textures", [])
    valid_textures = len(images) in (0, len(record["palette"])) and all(map(_DIGEST.fullmatch, images))
    if not valid_counts or not valid_palette or not valid_textures or not isinstance(record["id"], str):
        msg = f"the record of body {record['id']!r} is malformed"
        raise ValueError(msg)


def _size(record: dict[str, Any]) -> int:
    """Returns the size of a body's arrays [bytes], from its record in the header."""
    triangle_bytes = TRIANGLE_BYTES + COLOUR_BYTES + (TEXCOORDS_BYTES if record.get("textures") else 0)
    return int(record["points"] * POINT_BYTES + record["triangles"] * triangle_bytes)


def _is_channel(value: Any) -> bool:
    """Tells whether a value can be a channel of a colour: a finite number."""
    return isinstance(value, int | float) and math.isfinite(value)
