"""The triangles of a part studio in a compact form: fetch stores it, and mesh reads it.

The form is an exact and deterministic function of the bodies. After a line that names it and its
version: the length of the header (unsigned, 4 bytes), the header (JSON), then for each body

    points     n × 3 float64 [m], in the part studio's frame
    triangles  m × 3 int32, indices into the points, counter-clockwise seen from outside
    colours    m × uint16, indices into the header's palette of the body
    texcoords  m × 3 × 2 float32, of a body with textures only: (u, v) of each corner

all little-endian. The header has `bodies`: id, points (n), triangles (m), palette (RGBA in 0..1), and of
a body with textures `textures`: of each colour of the palette the SHA-256 of its image, "" for none. u runs
to the right and v upwards from the lower left corner of the image, as in OBJ.
A closed mesh takes about 26 bytes a triangle so, and with textures 50.
"""

from __future__ import annotations

import json
import math
import re
import struct
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from linkwright.stages.robot.errors import ProtocolError
from linkwright.stages.robot.model.geometry import Colour

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

MAGIC = b"linkwright triangles 1\n"

_LENGTH = struct.Struct("<I")
_MOST_COLOURS = 1 << 16
_LONGEST_HEADER = 1 << 24
_POINT, _TRIANGLE, _COLOUR, _TEXCOORDS = 24, 12, 2, 24
_DIGEST = re.compile(r"([0-9a-f]{64})?")
_HINT = "fetch again with source.refresh=true"


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """One body's triangles.

    `points` (n, 3) float64 [m]; `triangles` (m, 3) int32; `palette`: its colours, sorted;
    `colours` (m,) uint16: each triangle's index in the palette. `textures`: the digest of each colour's
    image, "" for none; () where there are none at all, else `texcoords` (m, 3, 2) float32 has the (u, v) of
    each corner, 0 on triangles without a texture.
    """

    id: str
    points: npt.NDArray[np.float64]
    triangles: npt.NDArray[np.int32]
    palette: tuple[Colour, ...]
    colours: npt.NDArray[np.uint16]
    textures: tuple[str, ...] = ()
    texcoords: npt.NDArray[np.float32] | None = None


def encode(bodies: Sequence[Body]) -> bytes:
    """The compact form of bodies, in their order; ValueError for more than 65536 colours in one."""
    # Late: an unchanged build needs no numpy.
    import numpy as np

    records, arrays = [], []
    for body in bodies:
        if len(body.palette) > _MOST_COLOURS:
            msg = f"body {body.id} has {len(body.palette)} colours; at most {_MOST_COLOURS} are kept"
            raise ValueError(msg)
        records.append(
            {
                "id": body.id,
                "points": len(body.points),
                "triangles": len(body.triangles),
                "palette": [list(colour) for colour in body.palette],
                **({"textures": list(body.textures)} if body.textures else {}),
            }
        )
        for array, kind in ((body.points, "<f8"), (body.triangles, "<i4"), (body.colours, "<u2")):
            arrays.append(np.ascontiguousarray(array, dtype=kind).tobytes())
        if body.textures:
            arrays.append(np.ascontiguousarray(body.texcoords, dtype="<f4").tobytes())
    header = json.dumps({"bodies": records}, separators=(",", ":")).encode()
    return b"".join([MAGIC, _LENGTH.pack(len(header)), header, *arrays])


def decode(data: bytes, wanted: Collection[str] | None = None) -> dict[str, Body]:
    """The bodies by id, only the `wanted` ones where that is given.

    ProtocolError where `data` is not the compact form. Of two bodies with one id the first counts.
    """
    # Late: an unchanged build needs no numpy.
    import numpy as np

    bodies: dict[str, Body] = {}
    records, start = _opened(data)
    for record in records:
        name, n, m = record["id"], record["points"], record["triangles"]
        points, triangles = start, start + n * _POINT
        colours = triangles + m * _TRIANGLE
        texcoords = colours + m * _COLOUR
        textures = tuple(record.get("textures", ()))
        start = texcoords + (m * _TEXCOORDS if textures else 0)
        if name in bodies or (wanted is not None and name not in wanted):
            continue
        body = Body(
            id=name,
            points=np.frombuffer(data, "<f8", 3 * n, points).reshape(n, 3),
            triangles=np.frombuffer(data, "<i4", 3 * m, triangles).reshape(m, 3),
            palette=tuple((r, g, b, a) for r, g, b, a in record["palette"]),
            colours=np.frombuffer(data, "<u2", m, colours),
            textures=textures,
            texcoords=np.frombuffer(data, "<f4", 6 * m, texcoords).reshape(m, 3, 2) if textures else None,
        )
        _require_within(body)
        bodies[name] = body
    return bodies


def names(data: bytes) -> frozenset[str]:
    """The ids of the bodies that have triangles; ProtocolError where `data` is not the compact form."""
    return frozenset(record["id"] for record in _opened(data)[0] if record["triangles"])


def is_compact(data: bytes) -> bool:
    """Whether `data` begins as the compact form does."""
    return data.startswith(MAGIC)


def check(data: bytes) -> None:
    """ProtocolError where `data` is not the compact form, or is cut short. Needs no array library."""
    _opened(data)


def distinct(points: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """The points (n, 3) without repetitions, sorted, and the index among them of each given point.

    −0 counts as 0.
    """
    # Late: an unchanged build needs no numpy.
    import numpy as np

    # NumPy takes rows much slower than columns.
    x, y, z = np.ascontiguousarray(points.T)
    order = np.lexsort((z, y, x))
    new = np.zeros(len(points), dtype=bool)
    new[:1] = True
    for column in (x, y, z):
        ordered = column[order]
        new[1:] |= ordered[1:] != ordered[:-1]
    index = np.empty(len(points), dtype=np.int64)
    index[order] = np.cumsum(new) - 1
    return points.take(order[new], axis=0) + 0.0, index


def merged(
    name: str,
    points: npt.NDArray[np.float64],
    corners: npt.NDArray[np.int64],
    colours: Sequence[Colour],
    which: npt.NDArray[np.int64],
    textures: Sequence[str] = (),
    texcoords: npt.NDArray[np.float32] | None = None,
) -> Body:
    """A body out of loose triangles: points that are equal to the last bit become one.

    `corners` (m, 3) index the points (n, 3), `which` (m,) the colours. `textures`: the digest of each
    colour's image, "" for none; with any, `texcoords` (m, 3, 2) are the (u, v) of the corners.
    """
    # Late: an unchanged build needs no numpy.
    import numpy as np

    paints = list(zip(colours, textures or [""] * len(colours), strict=True))

    used = np.zeros(len(points), dtype=bool)
    used[corners] = True
    if not used.all():
        corners = (np.cumsum(used) - 1)[corners]
        points = points[used]
    points, index = distinct(points)
    palette = sorted({paints[seen] for seen in np.unique(which)})
    rank = {paint: place for place, paint in enumerate(palette)}
    ranks = np.array([rank.get(paint, 0) for paint in paints], dtype=np.uint16)
    textured = np.array([bool(texture) for _, texture in palette])[ranks[which]]
    return Body(
        id=name,
        points=points,
        triangles=index.astype(np.int32)[corners],
        palette=tuple(colour for colour, _ in palette),
        colours=ranks[which],
        textures=tuple(texture for _, texture in palette) if textured.any() else (),
        texcoords=_only(texcoords, textured) if texcoords is not None and textured.any() else None,
    )


def textures(data: bytes) -> frozenset[str]:
    """The digests of the images that the bodies name; ProtocolError where `data` is not the compact form."""
    return frozenset(one for record in _opened(data)[0] for one in record.get("textures", ()) if one)


def _only(texcoords: npt.NDArray[np.float32], textured: npt.NDArray[np.bool_]) -> npt.NDArray[np.float32]:
    """Texture coordinates, 0 where no texture is; −0 becomes 0."""
    # Late: an unchanged build needs no numpy.
    import numpy as np

    return np.where(textured[:, None, None], texcoords, np.float32(0)).astype(np.float32) + np.float32(0)


def _opened(data: bytes) -> tuple[list[dict[str, Any]], int]:
    """The header's bodies, and where the arrays begin, once they are known to be all there."""
    start = len(MAGIC) + _LENGTH.size
    try:
        if not is_compact(data) or len(data) < start:
            msg = "it does not begin as such"
            raise ValueError(msg)
        (length,) = _LENGTH.unpack_from(data, len(MAGIC))
        if length > _LONGEST_HEADER:
            msg = f"its header has {length} bytes"
            raise ValueError(msg)
        records = json.loads(data[start : start + length])["bodies"]
        size = sum(_size(record) for record in records)
    except (AttributeError, KeyError, RecursionError, TypeError, ValueError) as error:
        msg = f"the triangles are not in the compact form: {error}"
        raise ProtocolError(msg, hint=_HINT) from None
    if len(data) != start + length + size:
        msg = f"the triangles have {len(data)} bytes where {start + length + size} are announced"
        raise ProtocolError(msg, hint=_HINT)
    return records, start + length


def _size(record: dict[str, Any]) -> int:
    """The bytes of a body's arrays, by its record in the header."""
    points, triangles = record["points"], record["triangles"]
    counts = isinstance(points, int) and isinstance(triangles, int) and min(points, triangles) >= 0
    colours = all(len(colour) == 4 and all(map(_is_channel, colour)) for colour in record["palette"])
    images = record.get("textures", [])
    known = len(images) in (0, len(record["palette"])) and all(map(_DIGEST.fullmatch, images))
    if not counts or not colours or not known or not isinstance(record["id"], str):
        msg = f"the record of body {record['id']!r} is malformed"
        raise ValueError(msg)
    return int(points * _POINT + triangles * (_TRIANGLE + _COLOUR + (_TEXCOORDS if images else 0)))


def _is_channel(value: Any) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)


def _require_within(body: Body) -> None:
    """ProtocolError where a triangle names a point or a colour that is not there."""
    # Late: an unchanged build needs no numpy.
    import numpy as np

    if not len(body.triangles):
        return
    within = body.triangles.min() >= 0 and body.triangles.max() < len(body.points)
    numbers = (body.points, np.zeros(0) if body.texcoords is None else body.texcoords)
    finite = all(bool(np.isfinite(one).all()) for one in numbers)
    if not within or body.colours.max() >= len(body.palette) or not finite:
        msg = "a triangle has a corner or a colour that is not there"
        raise ProtocolError(msg, f"part {body.id}", _HINT)
