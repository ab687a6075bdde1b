"""The triangles of a mesh file, and the body that they become."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.fetch.urdf.meshes.textures import Texture
from linkwright.stages.formats.triangles import Body, merged
from linkwright.stages.robot.model.geometry import Colour

WHITE: Colour = (1.0, 1.0, 1.0, 1.0)
"""The colour of an image that is as it is."""

Vector = tuple[float, float, float]
Texcoords = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class LooseMesh:
    """Loose triangles: `points` (n, 3) float64 [m], `triangles` (m, 3) indices into them counter-clockwise
    seen from outside, `colours` and which of them each triangle has (m,); `images`: names of images,
    which are not read. `textures`: the image of each colour, None for none; `texcoords` (m, 3, 2): (u, v) of
    each corner, from the lower left corner of the image, NaN on triangles that have none; None where no
    triangle has any."""

    points: npt.NDArray[np.float64]
    triangles: npt.NDArray[np.int64]
    colours: tuple[Colour, ...]
    which: npt.NDArray[np.int64]
    textures: tuple[Texture | None, ...]
    texcoords: Texcoords | None
    images: tuple[str, ...] = ()


def joined(pieces: Sequence[LooseMesh], scale: float) -> LooseMesh:
    """Several meshes (at least one) as one, `scale` times as large."""
    first = np.cumsum([0, *(len(piece.points) for piece in pieces)])
    shade = np.cumsum([0, *(len(piece.colours) for piece in pieces)])
    return LooseMesh(
        points=np.concatenate([piece.points for piece in pieces]) * scale,
        triangles=np.concatenate([one.triangles + at for one, at in zip(pieces, first, strict=False)]),
        colours=tuple(colour for piece in pieces for colour in piece.colours),
        which=np.concatenate([one.which + at for one, at in zip(pieces, shade, strict=False)]),
        textures=tuple(one for piece in pieces for one in piece.textures),
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
    """A mesh as one body: scaled, turned outside again where that mirrors it.

    `image`: the digest of an image for all triangles that have texture coordinates, "" for the mesh's own
    images; None for no image at all. `colour`: for all triangles without an image of the mesh's own, if any.
    """
    points = mesh.points * np.array(scale) + 0.0
    mirrored = scale[0] * scale[1] * scale[2] < 0
    corners = mesh.triangles[:, ::-1] if mirrored else mesh.triangles
    texcoords = mesh.texcoords
    if texcoords is None or image is None:
        image, texcoords = None, None
    elif mirrored:
        texcoords = texcoords[:, ::-1]
    own = [one.digest if one and one.image and image is not None else "" for one in mesh.textures]
    paints = [*zip(mesh.colours, own, strict=True), (colour or WHITE, image or ""), (colour or WHITE, "")]
    which = mesh.which
    textured: npt.NDArray[np.bool_] = np.array([bool(one) for one in own])[which]
    if image and texcoords is not None:
        textured = np.asarray(np.isfinite(texcoords).all(axis=(1, 2)))
        which = np.where(textured, len(own), which)
    if colour is not None:
        which = np.where(textured, which, len(own) + 1)
    colours, digests = zip(*paints, strict=True)
    return merged(key, points, corners, colours, which, digests, texcoords)
