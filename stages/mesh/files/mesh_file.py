"""Mesh files: surfaces in a form that every reader accepts."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface, chosen, joined, rounded
from linkwright.stages.mesh.files import obj, stl
from linkwright.stages.robot.model.geometry import Colour

MOST_FACES = 200_000
"""The largest number of triangles in one file: MuJoCo reads no more."""

_SKIN = 1e-6
_SPECK = 1e-14


@dataclass(frozen=True, slots=True)
class MeshFile:
    """One mesh file of a link, with the figures that `Shape` has: a binary STL, or an OBJ where it has a
    `texture`, the digest of an image, "" for none."""

    colour: Colour | None
    vertices: int
    faces: int
    area: float
    volume: float
    data: bytes
    texture: str = ""
    bounds: tuple[float, ...] = ()


def collider(surface: Surface) -> MeshFile:
    """The mesh file of a convex hull."""
    return _mesh_file(rounded(surface), None)


def visuals(surface: Surface, colour: Colour, texture: str = "") -> Iterator[MeshFile]:
    """The mesh files of a surface of one colour and texture, each with at most `MOST_FACES` triangles.

    MuJoCo refuses meshes that span no volume, and a single coloured face is one: it gets a back,
    a thousandth of a millimetre behind. Specks too small even for that, below 1e-14 m³, are left out.
    """
    for part, span in _portions(rounded(surface)):
        solid = part
        if _flat(part, span):
            solid = rounded(_backed(part))
            span = _span(solid)
        if len(solid.triangles) and span >= _SPECK:
            yield _mesh_file(solid, colour, texture)


def _portions(surface: Surface) -> Iterator[tuple[Surface, float]]:
    """Parts of the surface that are small enough for one file, and the span [m³] of each."""
    count = len(surface.triangles)
    if not count:
        return
    span = _span(surface)
    if count <= (MOST_FACES // 2 if _flat(surface, span) else MOST_FACES):
        yield surface, span
        return
    for half in np.array_split(np.arange(count), 2):
        yield from _portions(chosen(surface, half))


def _scale(surface: Surface) -> float:
    """1 for coordinates up to a metre, and as many as they are above: single precision is relative."""
    return max(1.0, float(np.abs(surface.vertices).max()))


def _flat(surface: Surface, span: float) -> bool:
    """Whether a surface of that span lies in a plane, within single precision."""
    return span <= 0.2 * _SKIN * _scale(surface) * surface.area()


def _span(surface: Surface) -> float:
    """The volume [m³] between the surface and its middle: what MuJoCo calls a mesh's volume."""
    weights = np.linalg.norm(surface.normals(), axis=1)
    total = float(weights.sum())
    if total == 0.0:
        return 0.0
    middle = (surface.corners.mean(axis=1) * weights[:, None]).sum(axis=0) / total
    return float(np.abs(surface.cone_volumes(middle)).sum())


def _backed(surface: Surface) -> Surface:
    """A flat surface with a back close behind it."""
    normals = surface.normals()
    lengths = np.linalg.norm(normals, axis=1)
    largest = int(lengths.argmax())
    if lengths[largest] == 0.0:
        return surface
    area = float(lengths.sum() / 2)
    # Specks need a thicker back to be more than nothing, but never thicker than they are wide.
    depth = max(_SKIN * _scale(surface), min(1e-12 / area, float(np.sqrt(area))))
    behind = surface.vertices - depth * normals[largest] / lengths[largest]
    return joined([surface, replace(surface, vertices=behind).flipped()])


def _mesh_file(surface: Surface, colour: Colour | None, texture: str = "") -> MeshFile:
    points = surface.corners.reshape(-1, 3)
    return MeshFile(
        colour,
        vertices=len(surface.vertices),
        faces=len(surface.triangles),
        area=surface.area(),
        volume=surface.volume(),
        data=obj.write(surface) if texture else stl.write(surface),
        texture=texture,
        bounds=(*map(float, points.min(axis=0)), *map(float, points.max(axis=0))),
    )
