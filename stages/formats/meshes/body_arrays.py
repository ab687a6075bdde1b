"""Encodes and decodes the triangles of a part studio in their compact form: fetch stores it, and mesh reads
it.

The module `triangles` describes the form.
"""

import json
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.triangles import (
    COLOUR_BYTES,
    HEADER_LENGTH,
    MAGIC,
    POINT_BYTES,
    REFRESH_HINT,
    TEXCOORDS_BYTES,
    TRIANGLE_BYTES,
    read_header,
)
from linkwright.stages.robot.errors import ProtocolError
from linkwright.stages.robot.model.geometry import Colour

_MAX_COLOURS = 1 << 16
"""Largest number of colours of a body: their indices have 16 bits."""


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """The triangles of a body."""

    id: str
    points: npt.NDArray[np.float64]
    """(n, 3) [m]."""

    triangles: npt.NDArray[np.int32]
    """(m, 3), indices into `points`."""

    palette: tuple[Colour, ...]
    """The colours, sorted."""

    colours: npt.NDArray[np.uint16]
    """(m,), each triangle's index in the palette."""

    textures: tuple[str, ...] = ()
    """The digest of each colour's image, "" for a colour without one; () without any textures."""

    texcoords: npt.NDArray[np.float32] | None = None
    """(m, 3, 2), the (u, v) of each corner, 0 on triangles without a texture; None without any textures."""


def encode(bodies: Sequence[Body]) -> bytes:
    """Returns the compact form of bodies, in order. Raises ValueError for a body with more than 65536
    colours."""
    records, arrays = [], []
    for body in bodies:
        _require_few_colours(body.id, len(body.palette))
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
    return b"".join([MAGIC, HEADER_LENGTH.pack(len(header)), header, *arrays])


def decode(data: bytes, ids: Collection[str] | None = None) -> dict[str, Body]:
    """Returns the bodies by id; with `ids`, only those.

    Raises ProtocolError if `data` is not the compact form, or a triangle refers to a missing point or colour.
    Of two bodies with the same id the first counts.
    """
    bodies: dict[str, Body] = {}
    records, start = read_header(data)
    for record in records:
        name, n, m = record["id"], record["points"], record["triangles"]
        points, triangles = start, start + n * POINT_BYTES
        colours = triangles + m * TRIANGLE_BYTES
        texcoords = colours + m * COLOUR_BYTES
        textures = tuple(record.get("textures", ()))
        start = texcoords + (m * TEXCOORDS_BYTES if textures else 0)
        if name in bodies or (ids is not None and name not in ids):
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


def distinct(points: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Returns the points (n, 3) without repetitions, sorted, and the index among them of each given point.

    −0 counts as 0.
    """
    # NumPy sorts and compares rows much slower than columns.
    x, y, z = np.ascontiguousarray(points.T)
    order = np.lexsort((z, y, x))
    is_new = np.zeros(len(points), dtype=bool)
    is_new[:1] = True
    for column in (x, y, z):
        ordered = column[order]
        is_new[1:] |= ordered[1:] != ordered[:-1]
    index = np.empty(len(points), dtype=np.int64)
    index[order] = np.cumsum(is_new) - 1
    return points.take(order[is_new], axis=0) + 0.0, index


def merged(
    name: str,
    points: npt.NDArray[np.float64],
    corners: npt.NDArray[np.int64],
    colours: Sequence[Colour],
    which: npt.NDArray[np.int64],
    textures: Sequence[str] = (),
    texcoords: npt.NDArray[np.float32] | None = None,
) -> Body:
    """Makes a body from loose triangles: points that are equal to the last bit are merged.

    `corners` (m, 3) index the points (n, 3), `which` (m,) the colours. `textures`: the digest of each
    colour's image, or ""; with any, `texcoords` (m, 3, 2) are the (u, v) of the corners. Raises ValueError
    for more than 65536 colours.
    """
    paints = list(zip(colours, textures or [""] * len(colours), strict=True))

    is_used = np.zeros(len(points), dtype=bool)
    is_used[corners] = True
    if not is_used.all():
        corners = (np.cumsum(is_used) - 1)[corners]
        points = points[is_used]
    points, index = distinct(points)
    palette = sorted({paints[paint] for paint in np.unique(which)})
    _require_few_colours(name, len(palette))
    rank = {paint: place for place, paint in enumerate(palette)}
    ranks = np.array([rank.get(paint, 0) for paint in paints], dtype=np.uint16)
    is_textured = np.array([bool(texture) for _, texture in palette])[ranks[which]]
    return Body(
        id=name,
        points=points,
        triangles=index.astype(np.int32)[corners],
        palette=tuple(colour for colour, _ in palette),
        colours=ranks[which],
        textures=tuple(texture for _, texture in palette) if is_textured.any() else (),
        texcoords=_textured_only(texcoords, is_textured)
        if texcoords is not None and is_textured.any()
        else None,
    )


def _require_few_colours(body: str, count: int) -> None:
    """Raises ValueError if a body has more colours than its indices can count."""
    if count > _MAX_COLOURS:
        msg = f"body {body} has {count} colours; at most {_MAX_COLOURS} are kept"
        raise ValueError(msg)


def _textured_only(
    texcoords: npt.NDArray[np.float32], is_textured: npt.NDArray[np.bool_]
) -> npt.NDArray[np.float32]:
    """Returns texture coordinates (m, 3, 2) that are 0 on triangles without a texture; −0 becomes 0."""
    return np.where(is_textured[:, None, None], texcoords, np.float32(0)).astype(np.float32) + np.float32(0)


def _require_within(body: Body) -> None:
    """Raises ProtocolError if a triangle refers to a missing point or colour, or a number is not finite."""
    if not len(body.triangles):
        return
    within = body.triangles.min() >= 0 and body.triangles.max() < len(body.points)
    if not within or body.colours.max() >= len(body.palette):
        msg = "a triangle has a corner or a colour that is not there"
        raise ProtocolError(msg, f"part {body.id}", REFRESH_HINT)
    numbers = (body.points, np.zeros(0) if body.texcoords is None else body.texcoords)
    if not all(bool(np.isfinite(values).all()) for values in numbers):
        msg = "a coordinate is not a finite number"
        raise ProtocolError(msg, f"part {body.id}", REFRESH_HINT)
