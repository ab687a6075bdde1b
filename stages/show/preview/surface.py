"""Makes the triangles of a look."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.points import mesh_points
from linkwright.stages.show.preview import solids
from linkwright.stages.show.preview.look import Blob, Geom, Look
from linkwright.stages.show.preview.thinning import merge_details
from linkwright.stages.show.raster import Corners, Indices, Numbers

Single = npt.NDArray[np.float32]

_Piece = tuple[Corners, Single]

_MAX_TRIANGLES = 600_000
"""Largest number of triangles that are drawn unchanged."""

_CELLS = 600
"""Number of cells along a robot with more triangles. The corners in a cell, which is about a pixel, are
merged."""


@dataclass(frozen=True, slots=True, eq=False)
class Triangles:
    """The triangles of all geoms of a look."""

    corners: Corners
    """The corners (m, 3, 3) in the world [m]."""

    geom: Indices
    """The geom (m,) of each triangle."""

    colours: Numbers
    """The colour (n, 4) of each geom, in sRGB from 0 to 1."""

    image: Indices
    """The index (n,) of each geom's image in `images`, or -1."""

    images: tuple[Numbers, ...]
    """The images (height, width, 3)."""

    places: Single
    """The places (m, 3, 2) of the corners in their images; (0, 3, 2) without images."""


def surface_of(look: Look) -> Triangles:
    """Returns the triangles of a look. Raises ValueError if no part of it has finite coordinates."""
    pieces = _with_pixel_details([_corners(geom, look.blobs) for geom in look.geoms])
    corners = np.concatenate([piece for piece, _ in pieces])
    geom = np.repeat(np.arange(len(pieces), dtype=np.int64), [len(piece) for piece, _ in pieces])
    image_blobs = sorted({geom.image for geom in look.geoms} - {-1})
    places = np.zeros((len(corners) if image_blobs else 0, 3, 2), dtype=np.float32)
    if image_blobs:
        np.concatenate([piece for _, piece in pieces], out=places)
    if not np.isfinite(corners).all():
        finite = np.isfinite(corners).all(axis=(1, 2))
        corners, geom, places = corners[finite], geom[finite], places[finite[: len(places)]]
    if not len(corners):
        raise ValueError("no part of the robot has a place")
    colours = np.array([geom.colour for geom in look.geoms])
    image = np.array([image_blobs.index(geom.image) if geom.image >= 0 else -1 for geom in look.geoms])
    images = tuple(_image(look.blobs[number]) for number in image_blobs)
    return Triangles(corners, geom, colours, image, images, places)


def _with_pixel_details(pieces: list[_Piece]) -> list[_Piece]:
    """Returns the pieces; if they have too many triangles, without details smaller than a pixel."""
    if sum(len(corners) for corners, _ in pieces) <= _MAX_TRIANGLES:
        return pieces
    # A mesh of points alone has no triangles.
    bounds = np.array(
        [(corners.min(axis=(0, 1)), corners.max(axis=(0, 1))) for corners, _ in pieces if len(corners)]
    )
    cell = float(np.ptp(bounds.reshape(-1, 3), axis=0).max()) / _CELLS
    thinned_pieces = [merge_details(corners, cell) if len(corners) else corners for corners, _ in pieces]
    return [(corners, np.zeros((len(corners), 3, 2), dtype=np.float32)) for corners in thinned_pieces]


def _corners(geom: Geom, blobs: tuple[Blob, ...]) -> _Piece:
    """Returns the triangles of a geom in the world, and their places in its image."""
    size = np.array(geom.size)
    places = None
    match geom.solid:
        case "ellipsoid":
            local = solids.ellipsoid(size)
        case "capsule":
            local = solids.capsule(size[0], size[1])
        case "cylinder":
            local = solids.cylinder(size[0], size[1])
        case "box":
            local = solids.box(size)
        case "mesh":
            local, places = _mesh(blobs[geom.blob])
            local = local * np.array(geom.scale)
    # No matrix product: equal corners could differ in the last digit of the result, and corners are matched
    # by their coordinates.
    turn = np.array(geom.turn).reshape(3, 3)
    corners = local[:, :, :1] * turn[:, 0] + geom.position
    corners += local[:, :, 1:2] * turn[:, 1]
    corners += local[:, :, 2:] * turn[:, 2]
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
