"""Reads the mesh of each part: its triangles, welded to a surface."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes import body_arrays
from linkwright.stages.formats.meshes.body_arrays import Body
from linkwright.stages.formats.meshes.surface import Surface, weld
from linkwright.stages.robot.model.geometry import Colour


@dataclass(frozen=True, slots=True, eq=False)
class PartMesh:
    """The mesh of a part: its welded triangles, in the part's own frame. A part from Onshape has the frame of
    its part studio."""

    surface: Surface
    palette: tuple[Colour, ...]
    """The part's colours, sorted."""
    colours: npt.NDArray[np.int64]
    """Index of each triangle's colour in `palette` (m,)."""
    closed: bool
    """Whether the surface bounds a solid."""
    volume: float
    """Volume [m³]; 0 if the surface is not closed."""
    textures: tuple[str, ...] = ()
    """SHA-256 of the image of each colour, "" for no image; () if the part has no images."""

    @property
    def paints(self) -> list[tuple[Colour, str]]:
        """Each colour of the palette with the digest of its image."""
        return list(zip(self.palette, self.textures or [""] * len(self.palette), strict=True))


def decode_meshes(data: bytes, parts: Collection[str]) -> dict[str, PartMesh]:
    """Decodes the meshes of `parts` from the compact format of `body_arrays`. Parts without triangles are
    left out.

    Raises ProtocolError if `data` is not in that format.
    """
    meshes = {name: _part_mesh(body) for name, body in body_arrays.decode(data, parts).items()}
    return {name: mesh for name, mesh in meshes.items() if mesh is not None}


def _part_mesh(body: Body) -> PartMesh | None:
    surface, kept_triangles = weld(body.points, body.triangles.astype(np.int64), body.texcoords)
    if not len(surface.triangles):
        return None
    colours = body.colours[kept_triangles].astype(np.int64)
    closed = surface.is_closed()
    volume = surface.volume()
    if volume < 0:
        # The whole part is inside out.
        surface, volume = surface.flipped(), -volume
    return PartMesh(surface, body.palette, colours, closed, volume, body.textures)
