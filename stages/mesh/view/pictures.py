"""A picture of each link whose colliders were judged: what is seen on the left, colliders on the right."""

from __future__ import annotations

import base64
import colorsys
from collections.abc import Iterator, Mapping, Sequence
from hashlib import sha256
from typing import TYPE_CHECKING, Any

import numpy as np
import orjson

from linkwright.stages.formats import png
from linkwright.stages.mesh.files import obj, stl
from linkwright.stages.mesh.surfaces.pieces import surface_of
from linkwright.stages.robot import codec
from linkwright.stages.robot.model.geometry import NEUTRAL, Colour, Geometry, Role, Shape
from linkwright.stages.show.raster import Corners, Pixels, drawn, work

if TYPE_CHECKING:
    from linkwright.stages.mesh import Memo

SIDE = 240
"""The height of a picture, and half its width, in pixels."""

MOST_BYTES = 700_000
"""All pictures together have at most so many bytes, which is about 1 MB in the page."""

MOST_WORK = 1 << 26
"""A link is drawn if looking at so many pixels suffices: about a second."""

_FINER = 2  # pixels of what is drawn in one of the picture, each way
_MARGIN = 0.05
_BACKGROUND = np.array([236, 239, 242], dtype=np.uint8)
_SHADES = 24
_DARKEST = 0.4
_GOLDEN = 0.6180339887498949

_TO_VIEWER = (0.5, -0.7, 0.51)
_RIGHT = (0.7, 0.5, 0.0)
_LIGHT = (-0.35, 0.55, 0.76)
"""To the right, up, and to the viewer."""


def pictures(geometry: Geometry, memo: Memo) -> bytes:
    """A table as JSON: `side` [pixels], `pictures` of links in the order of the shapes, as PNG in base64, and
    the names of the links that are `left_out`, since drawing them takes too long or there is no room; links
    with a collider that misses its tolerance have theirs first. b"" where there are none.

    Colliders that nobody judged, as hulls, are not drawn: that would be a quarter of the work of a build.
    """
    judged = {one.link for one in geometry.colliders if one.tolerance is not None}
    shapes: dict[str, list[Shape]] = {}
    for shape in geometry.shapes:
        if shape.link in judged and (shape.file is None or shape.file in geometry.files):
            shapes.setdefault(shape.link, []).append(shape)
    links = [link for link, some in shapes.items() if any(shape.role == "collision" for shape in some)]
    if not links:
        return b""
    missing = {one.link for one in geometry.colliders if not one.meets}
    found, size = dict[str, bytes](), 0
    for link in sorted(links, key=lambda link: link not in missing):
        image = _remembered(shapes[link], geometry.files, memo)
        if image and size + len(image) <= MOST_BYTES:
            found[link] = image
            size += len(image)
    table = {
        "side": SIDE,
        "pictures": [
            {"link": link, "png": base64.b64encode(found[link]).decode()} for link in links if link in found
        ],
        "left_out": [link for link in links if link not in found],
    }
    return orjson.dumps(table)


def _remembered(shapes: Sequence[Shape], files: Mapping[str, bytes], memo: Memo) -> bytes:
    """The picture of a link; nothing where that is too much work."""
    digests = {shape.file: sha256(files[shape.file]).hexdigest() for shape in shapes if shape.file}
    key: list[Any] = [
        [shape.role, shape.colour, digests[shape.file] if shape.file else codec.plain(shape.primitive)]
        for shape in shapes
    ]
    return memo("mesh.picture", {"shapes": key}, lambda: picture(shapes, files))


def picture(shapes: Sequence[Shape], files: Mapping[str, bytes]) -> bytes:
    """The PNG of a link with these shapes, seen from in front, right and above; b"" where it would be too
    much work. Each collider has a colour of its own. Both halves have the same scale."""
    sides = [_seen(shapes, files, "visual"), _seen(shapes, files, "collision")]
    points = np.concatenate([corners for corners, _ in sides]).reshape(-1, 3)
    if not len(points) or not np.isfinite(points).all():
        return b""
    low, high = points.min(axis=0), points.max(axis=0)
    fine = _FINER * SIDE
    scale = fine * (1 - 2 * _MARGIN) / max(float((high - low)[:2].max()), 1e-12)
    placed = [(_placed(corners, (low + high) / 2, scale, fine), colours) for corners, colours in sides]
    if sum(work(corners) for corners, _ in placed) > MOST_WORK:
        return b""
    halves = [_smoothed(drawn(corners, colours, _BACKGROUND, fine)) for corners, colours in placed]
    return png.encode(np.concatenate(halves, axis=1))


def _seen(shapes: Sequence[Shape], files: Mapping[str, bytes], role: Role) -> tuple[Corners, Pixels]:
    """The triangles of a role as the viewer sees them (to the right, up, towards), [m], and their colours."""
    corners: list[Corners] = [np.zeros((0, 3, 3))]
    colours = [np.zeros((0, 3), dtype=np.uint8)]
    some = [shape for shape in shapes if shape.role == role]
    for shape, colour in zip(some, _colours(some, role), strict=True):
        seen = _turned(_corners(shape, files))
        corners.append(seen)
        colours.append(_shaded(seen, colour))
    return np.concatenate(corners), np.concatenate(colours)


def _corners(shape: Shape, files: Mapping[str, bytes]) -> Corners:
    if shape.file is None:
        assert shape.primitive is not None
        return surface_of(shape.primitive).corners
    data = files[shape.file]
    return stl.read(data) if shape.file.endswith(".stl") else obj.read(data)


def _colours(shapes: Sequence[Shape], role: Role) -> Iterator[Colour]:
    """The colour of each shape: its own, or of colliders one as far from those before as it can be."""
    for number, shape in enumerate(shapes):
        if role == "visual":
            yield shape.colour or NEUTRAL
        else:
            yield (*colorsys.hls_to_rgb((0.58 + number * _GOLDEN) % 1.0, 0.6, 0.65), 1.0)


def _turned(corners: Corners) -> Corners:
    """Written out by element: a matrix product may round differently from one processor to the next."""
    to_viewer = np.array(_TO_VIEWER) / np.linalg.norm(_TO_VIEWER)
    right = np.array(_RIGHT) / np.linalg.norm(_RIGHT)
    axes = (right, np.cross(to_viewer, right), to_viewer)
    x, y, z = np.moveaxis(corners, 2, 0)
    return np.stack([axis[0] * x + axis[1] * y + axis[2] * z for axis in axes], axis=2)


def _shaded(seen: Corners, colour: Colour) -> Pixels:
    """(m, 3): the colour of each triangle in the light, from whichever side it is seen."""
    a, b, c = np.moveaxis(seen, 1, 0)
    normals = np.cross(b - a, c - a)
    lengths = np.sqrt((normals * normals).sum(axis=1))
    along = normals[:, 0] * _LIGHT[0] + normals[:, 1] * _LIGHT[1] + normals[:, 2] * _LIGHT[2]
    along *= np.where(normals[:, 2] < 0, -1.0, 1.0)
    bright = np.divide(along, lengths, out=np.ones_like(along), where=lengths > 0)
    steps = np.rint(np.clip(bright, 0.0, 1.0) * _SHADES) / _SHADES
    # Of black some shades are left.
    base = 40 + 215 * np.clip(np.array(colour[:3]), 0.0, 1.0)
    shades = (_DARKEST + (1 - _DARKEST) * steps)[:, None] * base
    return np.asarray(np.rint(shades).astype(np.uint8))


def _placed(corners: Corners, middle: Corners, scale: float, side: int) -> Corners:
    """In pixels, from the upper left corner."""
    result = (corners - middle) * scale
    result[:, :, 0] += side / 2
    result[:, :, 1] = side / 2 - result[:, :, 1]
    return result


def _smoothed(fine: Pixels) -> Pixels:
    """Each pixel the mean of those that were drawn for it."""
    total = np.zeros_like(fine[::_FINER, ::_FINER], dtype=np.uint16)
    for row in range(_FINER):
        for column in range(_FINER):
            total += fine[row::_FINER, column::_FINER]
    return np.asarray((total // _FINER**2).astype(np.uint8))
