"""Defines the triangles of a mesh file, and converts them to a body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.fetch.urdf.meshes.textures import Texture
from linkwright.stages.formats.meshes.body_arrays import Body, merged
from linkwright.stages.robot.model.geometry import Colour

WHITE: Colour = (1.0, 1.0, 1.0, 1.0)
"""The colour factor of an image that is shown unchanged."""

Vector = tuple[float, float, float]
Texcoords = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class LooseMesh:
    """Loose triangles with their colours and images."""

    points: npt.NDArray[np.float64]
    """Points (n, 3) [m]."""

    triangles: npt.NDArray[np.int64]
    """Indices (m, 3) into `points`, counter-clockwise seen from outside."""

    colours: tuple[Colour, ...]
    which: npt.NDArray[np.int64]
    """Index of each triangle's colour (m,)."""

    textures: tuple[Texture | None, ...]
    """The image of each colour, or None."""

    texcoords: Texcoords | None
    """Texture coordinates (u, v) of each corner (m, 3, 2), from the lower left corner of the image; NaN on
    triangles without any. None if no triangle has any."""

    images: tuple[str, ...] = ()
    """The names of images that are not read."""


def join_meshes(pieces: Sequence[LooseMesh], scale: float) -> LooseMesh:
    """Joins meshes (at least one), and scales the result by `scale`."""
    first_points = np.cumsum([0, *(len(piece.points) for piece in pieces)])
    first_colours = np.cumsum([0, *(len(piece.colours) for piece in pieces)])
    return LooseMesh(
        points=np.concatenate([piece.points for piece in pieces]) * scale,
        triangles=np.concatenate(
            [piece.triangles + offset for piece, offset in zip(pieces, first_points, strict=False)]
        ),
        colours=tuple(colour for piece in pieces for colour in piece.colours),
        which=np.concatenate(
            [piece.which + offset for piece, offset in zip(pieces, first_colours, strict=False)]
        ),
        textures=tuple(texture for piece in pieces for texture in piece.textures),
        texcoords=_all_texcoords(pieces),
    )


def _all_texcoords(pieces: Sequence[LooseMesh]) -> Texcoords | None:
    if all(piece.texcoords is None for piece in pieces):
        return None
    return np.concatenate(
        [
            np.full((len(piece.triangles), 3, 2), np.nan, np.float32)
            if piece.texcoords is None
            else piece.texcoords
            for piece in pieces
        ]
    )


def body(mesh: LooseMesh, key: str, scale: Vector, colour: Colour | None, image: str | None) -> Body:
    """Returns the body of a mesh: scaled, with its triangles reversed if the scale mirrors it.

    `image`: the digest of an image for all triangles that have texture coordinates; "" for the mesh's own
    images; None for no image at all. `colour`: the colour of all triangles without an image of the mesh's
    own, if any.
    """
    points = mesh.points * np.array(scale) + 0.0
    mirrored = scale[0] * scale[1] * scale[2] < 0
    corners = mesh.triangles[:, ::-1] if mirrored else mesh.triangles
    texcoords = mesh.texcoords
    if texcoords is None or image is None:
        image, texcoords = None, None
    elif mirrored:
        texcoords = texcoords[:, ::-1]
    own_images = [
        texture.digest if texture and texture.image and image is not None else "" for texture in mesh.textures
    ]
    paints = [
        *zip(mesh.colours, own_images, strict=True),
        (colour or WHITE, image or ""),
        (colour or WHITE, ""),
    ]
    which = mesh.which
    is_textured: npt.NDArray[np.bool_] = np.array([bool(digest) for digest in own_images])[which]
    if image and texcoords is not None:
        is_textured = np.asarray(np.isfinite(texcoords).all(axis=(1, 2)))
        which = np.where(is_textured, len(own_images), which)
    if colour is not None:
        which = np.where(is_textured, which, len(own_images) + 1)
    colours, digests = zip(*paints, strict=True)
    return merged(key, points, corners, colours, which, digests, texcoords)
