"""The visual meshes of a link, made from the meshes of its parts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stages.mesh import mesh_file
from stages.mesh.mesh_file import MeshFile
from stages.mesh.surface import Surface, compacted, moved
from stages.mesh.tessellation import PartMesh
from stages.mesh.visuals.budget import Decimation, Decimator
from stages.robot.geometry import Colour
from stages.robot.model import Array, MeshRef

_ATTEMPTS = 4

Drawn = Sequence[tuple[MeshRef, Array]]
"""The parts that are drawn: the mesh of each and its `link_from_part` (4, 4)."""


@dataclass(frozen=True, slots=True)
class LinkVisuals:
    """The visual meshes of a link, sorted by colour, and what decimation made of them; None where they are
    as the parts have them."""

    files: tuple[MeshFile, ...]
    decimation: Decimation | None


def visuals(drawn: Drawn, meshes: Mapping[MeshRef, PartMesh], most: int, decimator: Decimator) -> LinkVisuals:
    """The visual meshes with at most `most` triangles together, or the fewest that the bound of the error
    allows."""
    allowed = most
    for _ in range(_ATTEMPTS):
        fitted, decimation = decimator.fitted([ref for ref, _ in drawn], meshes, allowed)
        files = _files(drawn, fitted)
        faces = sum(file.faces for file in files)
        # A flat surface gets a back, so that files may have more triangles than their parts.
        if faces <= most or (decimation is not None and decimation.limited):
            break
        allowed = max(0, allowed - (faces - most))
    return LinkVisuals(files, decimation)


def _files(drawn: Drawn, meshes: Mapping[MeshRef, PartMesh]) -> tuple[MeshFile, ...]:
    placed = [(moved(mesh.surface, pose), mesh) for ref, pose in drawn if (mesh := meshes.get(ref))]
    return tuple(
        file for colour, surface in _by_colour(placed) for file in mesh_file.visuals(surface, colour)
    )


def _by_colour(placed: Sequence[tuple[Surface, PartMesh]]) -> list[tuple[Colour, Surface]]:
    """The triangles of all parts as one surface a colour, colours sorted."""
    if not placed:
        return []
    palette = sorted({colour for _, mesh in placed for colour in mesh.palette})
    rank = {colour: index for index, colour in enumerate(palette)}
    vertices = np.concatenate([surface.vertices for surface, _ in placed])
    offsets = np.cumsum([0, *(len(surface.vertices) for surface, _ in placed)])
    triangles = np.concatenate(
        [surface.triangles + offset for (surface, _), offset in zip(placed, offsets, strict=False)]
    )
    colours = np.concatenate(
        [np.array([rank[colour] for colour in mesh.palette])[mesh.colours] for _, mesh in placed]
    )
    order = np.argsort(colours, kind="stable")
    bounds = np.searchsorted(colours[order], np.arange(len(palette) + 1))
    return [
        (colour, compacted(Surface(vertices, triangles[order[begin:end]])))
        for colour, begin, end in zip(palette, bounds, bounds[1:], strict=False)
        if end > begin
    ]
