"""The triangles of a look."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.points import mesh_points
from linkwright.stages.show.preview import solids
from linkwright.stages.show.preview.look import Blob, Geom, Look
from linkwright.stages.show.preview.thinning import thinned
from linkwright.stages.show.raster import Corners, Indices, Numbers

Single = npt.NDArray[np.float32]

_Piece = tuple[Corners, Single]

_MANY = 600_000
"""Triangles that are all drawn."""

_CELLS = 600
"""Cells across a robot with more, of which each has one corner: one is about a pixel of the picture."""


@dataclass(frozen=True, slots=True, eq=False)
class Triangles:
    """`corners` (m, 3, 3) in the world [m], and of each triangle its geom (m,), whose `colours` (n, 4) are in
    sRGB from 0 to 1. `images` (height, width, 3): `image` (n,) is the one of a geom, or -1, and `places`
    (m, 3, 2) are those of the corners in it; (0, 3, 2) where there are no images."""

    corners: Corners
    geom: Indices
    colours: Numbers
    image: Indices
    images: tuple[Numbers, ...]
    places: Single


def surface_of(look: Look) -> Triangles:
    """The surface; ValueError where no part of it has a place."""
    pieces = _fewer([_corners(geom, look.blobs) for geom in look.geoms])
    corners = np.concatenate([piece for piece, _ in pieces])
    geom = np.repeat(np.arange(len(pieces), dtype=np.int64), [len(piece) for piece, _ in pieces])
    shown = sorted({geom.image for geom in look.geoms} - {-1})
    places = np.zeros((len(corners) if shown else 0, 3, 2), dtype=np.float32)
    if shown:
        np.concatenate([piece for _, piece in pieces], out=places)
    if not np.isfinite(corners).all():
        finite = np.isfinite(corners).all(axis=(1, 2))
        corners, geom, places = corners[finite], geom[finite], places[finite[: len(places)]]
    if not len(corners):
        raise ValueError("no part of the robot has a place")
    colours = np.array([geom.colour for geom in look.geoms])
    image = np.array([shown.index(geom.image) if geom.image >= 0 else -1 for geom in look.geoms])
    return Triangles(corners, geom, colours, image, tuple(_image(look.blobs[one]) for one in shown), places)


def _fewer(pieces: list[_Piece]) -> list[_Piece]:
    """The pieces, without what is smaller than a pixel where they have too many triangles."""
    if sum(len(corners) for corners, _ in pieces) <= _MANY:
        return pieces
    ends = np.array([(corners.min(axis=(0, 1)), corners.max(axis=(0, 1))) for corners, _ in pieces])
    cell = float(np.ptp(ends.reshape(-1, 3), axis=0).max()) / _CELLS
    fewer = [thinned(corners, cell) for corners, _ in pieces]
    return [(corners, np.zeros((len(corners), 3, 2), dtype=np.float32)) for corners in fewer]


def _corners(geom: Geom, blobs: tuple[Blob, ...]) -> _Piece:
    """The triangles of a geom in the world, and where they are in its image."""
    size = np.array(geom.size)
    places = None
    match geom.solid:
        case "ellipsoid":
            own = solids.ellipsoid(size)
        case "capsule":
            own = solids.capsule(size[0], size[1])
        case "cylinder":
            own = solids.cylinder(size[0], size[1])
        case "box":
            own = solids.box(size)
        case "mesh":
            own, places = _mesh(blobs[geom.blob])
            own = own * np.array(geom.scale)
    # No matrix product: of its rows equal ones may differ in the last digit, and corners are known by place.
    turn = np.array(geom.turn).reshape(3, 3)
    corners = own[:, :, :1] * turn[:, 0] + geom.position
    corners += own[:, :, 1:2] * turn[:, 1]
    corners += own[:, :, 2:] * turn[:, 2]
    if places is None or geom.image < 0:
        return corners, np.zeros((len(corners), 3, 2), dtype=np.float32)
    return corners, places * np.array(geom.repeat, dtype=np.float32)


def _mesh(blob: Blob) -> tuple[Corners, Single | None]:
    if blob.packing == "stl":
        return mesh_points(".stl", blob.data).reshape(-1, 3, 3), None
    values = np.frombuffer(blob.data, dtype="<f4")
    count = len(values) // 15
    return values[: 9 * count].reshape(-1, 3, 3).astype(np.float64), values[9 * count :].reshape(-1, 3, 2)


def _image(blob: Blob) -> Numbers:
    return np.frombuffer(blob.data, dtype=np.uint8).reshape(blob.height, -1, 3) / 255.0
