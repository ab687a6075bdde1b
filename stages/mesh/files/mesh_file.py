"""Converts surfaces to mesh files that every reader accepts."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface, join_surfaces, round_to_single, select_triangles
from linkwright.stages.mesh.files import obj, stl
from linkwright.stages.robot.model.geometry import Colour

MAX_FACES = 200_000
"""Largest number of triangles in a file: MuJoCo reads no more."""

_BACK_DISTANCE = 1e-6
"""Distance [m] between a flat surface and the back that it gets."""

_MIN_SPAN = 1e-14
"""Smallest volume [m³] between a mesh and its centroid; MuJoCo refuses meshes that span nothing."""


@dataclass(frozen=True, slots=True)
class MeshFile:
    """A mesh file of a link, with the figures that `Shape` has."""

    colour: Colour | None
    vertices: int
    faces: int
    area: float
    """Surface area [m²]."""
    volume: float
    """Signed volume [m³]."""
    data: bytes
    """Content of the file: a binary STL, or an OBJ if there is a texture."""
    texture: str = ""
    """SHA-256 of the image, "" for no image."""
    bounds: tuple[float, ...] = ()
    """Smallest x, y and z, then the largest [m]."""


def collider(surface: Surface) -> MeshFile:
    """Returns the mesh file of a convex hull."""
    return _mesh_file(round_to_single(surface), None)


def visuals(surface: Surface, colour: Colour, texture: str = "") -> Iterator[MeshFile]:
    """Yields the mesh files of a surface of one colour and texture, each with at most `MAX_FACES` triangles.

    MuJoCo refuses meshes that span no volume, such as a single coloured face. A flat surface therefore gets a
    back, a thousandth of a millimetre behind it. Specks that span less than 1e-14 m³ even then are left out.
    """
    for part, span in _portions(round_to_single(surface)):
        solid = part
        if _is_flat(part, span):
            solid = round_to_single(_backed(part))
            span = _span(solid)
        if len(solid.triangles) and span >= _MIN_SPAN:
            yield _mesh_file(solid, colour, texture)


def _portions(surface: Surface) -> Iterator[tuple[Surface, float]]:
    """Yields portions of the surface that are small enough for a file, and the span [m³] of each."""
    count = len(surface.triangles)
    if not count:
        return
    span = _span(surface)
    if count <= (MAX_FACES // 2 if _is_flat(surface, span) else MAX_FACES):
        yield surface, span
        return
    for half in np.array_split(np.arange(count), 2):
        yield from _portions(select_triangles(surface, half))


def _scale(surface: Surface) -> float:
    """Returns the largest coordinate [m], at least 1: rounding to single precision is relative."""
    return max(1.0, float(np.abs(surface.vertices).max()))


def _is_flat(surface: Surface, span: float) -> bool:
    """Tells whether a surface of the given span [m³] lies in a plane, within single precision."""
    return span <= 0.2 * _BACK_DISTANCE * _scale(surface) * surface.area()


def _span(surface: Surface) -> float:
    """Returns the sum [m³] of the volumes between each triangle and the centroid, as MuJoCo computes a
    volume."""
    weights = np.linalg.norm(surface.normals(), axis=1)
    total = float(weights.sum())
    if total == 0.0:
        return 0.0
    centroid = (surface.corners.mean(axis=1) * weights[:, None]).sum(axis=0) / total
    return float(np.abs(surface.cone_volumes(centroid)).sum())


def _backed(surface: Surface) -> Surface:
    """Returns a flat surface with a back close behind it."""
    normals = surface.normals()
    lengths = np.linalg.norm(normals, axis=1)
    largest = int(lengths.argmax())
    if lengths[largest] == 0.0:
        return surface
    area = float(lengths.sum() / 2)
    # For a tiny surface, a millionth of a metre would span too little volume; but the back is never farther
    # away than the surface is wide.
    depth = max(_BACK_DISTANCE * _scale(surface), min(1e-12 / area, float(np.sqrt(area))))
    back_vertices = surface.vertices - depth * normals[largest] / lengths[largest]
    return join_surfaces([surface, replace(surface, vertices=back_vertices).flipped()])


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
