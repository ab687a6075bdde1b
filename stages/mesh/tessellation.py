"""Each part's triangles, welded to a surface, in the part studio's frame."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats import triangles
from linkwright.stages.formats.meshes.surface import Surface, weld
from linkwright.stages.formats.triangles import Body
from linkwright.stages.robot.model.geometry import Colour


@dataclass(frozen=True, slots=True, eq=False)
class PartMesh:
    """One part's triangles, welded, in the part's own frame.

    `palette`: the part's colours, sorted; `colours` (m,): each triangle's index in it. `textures`: the digest
    of each colour's image, "" for none; () where there are none at all.
    `closed`: whether the surface bounds a solid; `volume` [m³] is 0 where it does not.
    """

    surface: Surface
    palette: tuple[Colour, ...]
    colours: npt.NDArray[np.int64]
    closed: bool
    volume: float
    textures: tuple[str, ...] = ()

    @property
    def paints(self) -> list[tuple[Colour, str]]:
        """Each colour of the palette and its image."""
        return list(zip(self.palette, self.textures or [""] * len(self.palette), strict=True))


def read(data: bytes, parts: Collection[str]) -> dict[str, PartMesh]:
    """The meshes of `parts` out of the compact form; a part without triangles is absent.

    ProtocolError where `data` is not in that form.
    """
    meshes = {name: _welded(body) for name, body in triangles.decode(data, parts).items()}
    return {name: mesh for name, mesh in meshes.items() if mesh is not None}


def _welded(body: Body) -> PartMesh | None:
    surface, kept = weld(body.points, body.triangles.astype(np.int64), body.texcoords)
    if not len(surface.triangles):
        return None
    colours = body.colours[kept].astype(np.int64)
    closed = surface.closed()
    volume = surface.volume()
    if volume < 0:
        surface, volume = surface.flipped(), -volume
    return PartMesh(surface, body.palette, colours, closed, volume, body.textures)
