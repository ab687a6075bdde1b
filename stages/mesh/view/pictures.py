"""Draws each link whose colliders were judged: visual meshes on the left, colliders on the right."""

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
from linkwright.stages.show.raster import Corners, Pixels, picture_of_triangles, work

if TYPE_CHECKING:
    from linkwright.stages.mesh import Memo

SIDE = 240
"""Height of a picture, and half its width, in pixels."""

MAX_BYTES = 700_000
"""Largest size of all pictures together [bytes]: about 1 MB in the page."""

MAX_WORK = 1 << 26
"""Largest number of pixel tests that a picture may take: about a second."""

_OVERSAMPLING = 2  # drawn pixels in a pixel of the picture, each way
_MARGIN = 0.05  # share of the side that stays free on each edge
_BACKGROUND = np.array([236, 239, 242], dtype=np.uint8)
_SHADES = 24  # steps of brightness
_DARKEST = 0.4  # brightness of a triangle along the light
_GOLDEN_RATIO = 0.6180339887498949  # step of the hue: it keeps hues far from each other

_TO_VIEWER = (0.5, -0.7, 0.51)
_RIGHT = (0.7, 0.5, 0.0)
_LIGHT = (-0.35, 0.55, 0.76)
"""Direction of the light: components to the right, up, and to the viewer."""


def pictures(geometry: Geometry, memo: Memo) -> bytes:
    """Returns a table as JSON: `side` [pixels], `pictures` of links in the order of the shapes, as PNG in
    base64, and the names of the links that are `left_out`, since drawing them takes too long or there is no
    room. Links with a collider that misses its tolerance get room first. Returns b"" if no link is drawn.

    Colliders that were not judged, such as hulls, are not drawn: that would take a quarter of the time of a
    build.
    """
    judged = {figures.link for figures in geometry.colliders if figures.tolerance is not None}
    shapes: dict[str, list[Shape]] = {}
    for shape in geometry.shapes:
        if shape.link in judged and (shape.file is None or shape.file in geometry.files):
            shapes.setdefault(shape.link, []).append(shape)
    links = [
        link
        for link, link_shapes in shapes.items()
        if any(shape.role == "collision" for shape in link_shapes)
    ]
    if not links:
        return b""
    links_off_tolerance = {figures.link for figures in geometry.colliders if not figures.meets}
    images, size = dict[str, bytes](), 0
    for link in sorted(links, key=lambda link: link not in links_off_tolerance):
        image = _cached_picture(shapes[link], geometry.files, memo)
        if image and size + len(image) <= MAX_BYTES:
            images[link] = image
            size += len(image)
    table = {
        "side": SIDE,
        "pictures": [
            {"link": link, "png": base64.b64encode(images[link]).decode()} for link in links if link in images
        ],
        "left_out": [link for link in links if link not in images],
    }
    return orjson.dumps(table)


def _cached_picture(shapes: Sequence[Shape], files: Mapping[str, bytes], memo: Memo) -> bytes:
    """Returns the picture of a link from the cache; b"" if drawing takes too much work."""
    digests = {shape.file: sha256(files[shape.file]).hexdigest() for shape in shapes if shape.file}
    key: list[Any] = [
        [shape.role, shape.colour, digests[shape.file] if shape.file else codec.plain_data(shape.primitive)]
        for shape in shapes
    ]
    return memo("mesh.picture", {"shapes": key}, lambda: picture(shapes, files))


def picture(shapes: Sequence[Shape], files: Mapping[str, bytes]) -> bytes:
    """Returns the PNG of a link with these shapes, seen from in front, right and above; b"" if drawing takes
    too much work. Each collider has a different colour. Both halves have the same scale."""
    sides = [_viewed(shapes, files, "visual"), _viewed(shapes, files, "collision")]
    points = np.concatenate([corners for corners, _ in sides]).reshape(-1, 3)
    if not len(points) or not np.isfinite(points).all():
        return b""
    low, high = points.min(axis=0), points.max(axis=0)
    fine_side = _OVERSAMPLING * SIDE
    scale = fine_side * (1 - 2 * _MARGIN) / max(float((high - low)[:2].max()), 1e-12)
    halves_in_pixels = [
        (_in_pixels(corners, (low + high) / 2, scale, fine_side), colours) for corners, colours in sides
    ]
    if sum(work(corners) for corners, _ in halves_in_pixels) > MAX_WORK:
        return b""
    halves = [
        _smoothed(picture_of_triangles(corners, colours, _BACKGROUND, fine_side))
        for corners, colours in halves_in_pixels
    ]
    return png.encode(np.concatenate(halves, axis=1))


def _viewed(shapes: Sequence[Shape], files: Mapping[str, bytes], role: Role) -> tuple[Corners, Pixels]:
    """Returns the triangles (m, 3, 3) of the shapes of a role in the viewer's frame (right, up, towards) [m],
    and their colours (m, 3)."""
    corners: list[Corners] = [np.zeros((0, 3, 3))]
    colours = [np.zeros((0, 3), dtype=np.uint8)]
    role_shapes = [shape for shape in shapes if shape.role == role]
    for shape, colour in zip(role_shapes, _colours(role_shapes, role), strict=True):
        viewed_corners = _in_viewer_frame(_corners(shape, files))
        corners.append(viewed_corners)
        colours.append(_shaded(viewed_corners, colour))
    return np.concatenate(corners), np.concatenate(colours)


def _corners(shape: Shape, files: Mapping[str, bytes]) -> Corners:
    if shape.file is None:
        assert shape.primitive is not None
        return surface_of(shape.primitive).corners
    data = files[shape.file]
    return stl.read(data) if shape.file.endswith(".stl") else obj.read(data)


def _colours(shapes: Sequence[Shape], role: Role) -> Iterator[Colour]:
    """Yields the colour of each shape; colliders get hues that are far from the hues before."""
    for number, shape in enumerate(shapes):
        if role == "visual":
            yield shape.colour or NEUTRAL
        else:
            yield (*colorsys.hls_to_rgb((0.58 + number * _GOLDEN_RATIO) % 1.0, 0.6, 0.65), 1.0)


def _in_viewer_frame(corners: Corners) -> Corners:
    """Returns the corners in the viewer's frame. The product is written out by element, since a matrix
    product may round differently on another processor."""
    to_viewer = np.array(_TO_VIEWER) / np.linalg.norm(_TO_VIEWER)
    right = np.array(_RIGHT) / np.linalg.norm(_RIGHT)
    axes = (right, np.cross(to_viewer, right), to_viewer)
    x, y, z = np.moveaxis(corners, 2, 0)
    return np.stack([axis[0] * x + axis[1] * y + axis[2] * z for axis in axes], axis=2)


def _shaded(viewed_corners: Corners, colour: Colour) -> Pixels:
    """Returns the colour (m, 3) of each triangle in the light, whichever side of it is seen."""
    a, b, c = np.moveaxis(viewed_corners, 1, 0)
    normals = np.cross(b - a, c - a)
    lengths = np.sqrt((normals * normals).sum(axis=1))
    heights = normals[:, 0] * _LIGHT[0] + normals[:, 1] * _LIGHT[1] + normals[:, 2] * _LIGHT[2]
    heights *= np.where(normals[:, 2] < 0, -1.0, 1.0)
    brightness = np.divide(heights, lengths, out=np.ones_like(heights), where=lengths > 0)
    steps = np.rint(np.clip(brightness, 0.0, 1.0) * _SHADES) / _SHADES
    # Black keeps some shades.
    base = 40 + 215 * np.clip(np.array(colour[:3]), 0.0, 1.0)
    shades = (_DARKEST + (1 - _DARKEST) * steps)[:, None] * base
    return np.asarray(np.rint(shades).astype(np.uint8))


def _in_pixels(corners: Corners, middle: Corners, scale: float, side: int) -> Corners:
    """Returns the corners in pixels, from the upper left."""
    result = (corners - middle) * scale
    result[:, :, 0] += side / 2
    result[:, :, 1] = side / 2 - result[:, :, 1]
    return result


def _smoothed(fine: Pixels) -> Pixels:
    """Returns a smaller picture in which each pixel is the mean of the pixels drawn for it."""
    total = np.zeros_like(fine[::_OVERSAMPLING, ::_OVERSAMPLING], dtype=np.uint16)
    for row in range(_OVERSAMPLING):
        for column in range(_OVERSAMPLING):
            total += fine[row::_OVERSAMPLING, column::_OVERSAMPLING]
    return np.asarray((total // _OVERSAMPLING**2).astype(np.uint8))
