"""Makes the visual meshes of a link from the meshes of its parts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from linkwright.stages.formats.meshes.surface import (
    Surface,
    join_surfaces,
    select_triangles,
    transform_surface,
)
from linkwright.stages.mesh.files import mesh_file
from linkwright.stages.mesh.files.mesh_file import MeshFile
from linkwright.stages.mesh.part_mesh import PartMesh
from linkwright.stages.mesh.visuals.budget import Decimation, Decimator
from linkwright.stages.robot.model.geometry import Colour
from linkwright.stages.robot.model.robot import Array, MeshRef

if TYPE_CHECKING:
    from linkwright.stages.mesh.section import VisualSection

_MAX_ATTEMPTS = 4
"""Largest number of times that the parts are decimated: they are decimated again, to fewer triangles, while
the backs of flat surfaces exceed the limit."""


@dataclass(frozen=True, slots=True, eq=False)
class DrawnPart:
    """A part that the visual mesh of its link shows."""

    index: int
    """Index among the parts of the link."""
    mesh: MeshRef
    link_from_part: Array
    """Pose of the part in the link (4, 4)."""


@dataclass(frozen=True, slots=True)
class LinkVisuals:
    """The visual meshes of a link."""

    files: tuple[MeshFile, ...]
    """Mesh files, sorted by colour and texture; with `mesh.visual.merge: part`, by part first."""
    owners: tuple[int, ...]
    """With `merge: part`, the index of each file's part in the link; else ()."""
    decimation: Decimation | None
    """None if no mesh was decimated."""


def make_visuals(
    drawn_parts: Sequence[DrawnPart],
    meshes: Mapping[MeshRef, PartMesh],
    section: "VisualSection",
    decimator: Decimator,
) -> LinkVisuals:
    """Makes a visual mesh for each colour, or for each part and colour. The parts are decimated until all
    meshes together have at most `max_faces` triangles, as far as the error bound allows."""
    allowed = max_faces = section.max_faces
    is_by_part = section.merge == "part"
    groups = [[part] for part in drawn_parts]
    if not is_by_part and groups:
        groups = [list(drawn_parts)]
    for _ in range(_MAX_ATTEMPTS):
        fitted, decimation = decimator.fitted([part.mesh for part in drawn_parts], meshes, allowed)
        files = [(group[0].index, file) for group in groups for file in _files(group, fitted)]
        faces = sum(file.faces for _, file in files)
        # A flat surface gets a back, so the files may have more triangles than the parts.
        if faces <= max_faces or (decimation is not None and decimation.limited):
            break
        allowed = max(0, allowed - (faces - max_faces))
    owners = tuple(index for index, _ in files) if is_by_part else ()
    return LinkVisuals(tuple(file for _, file in files), owners, decimation)


def _files(drawn_parts: Sequence[DrawnPart], meshes: Mapping[MeshRef, PartMesh]) -> tuple[MeshFile, ...]:
    """Returns the mesh files of parts, sorted by colour and texture."""
    moved_surfaces = [
        (transform_surface(mesh.surface, part.link_from_part), mesh)
        for part in drawn_parts
        if (mesh := meshes.get(part.mesh))
    ]
    return tuple(
        file
        for (colour, texture), surface in _surfaces_by_paint(moved_surfaces)
        for file in mesh_file.visuals(surface, colour, texture)
    )


def _surfaces_by_paint(
    moved_surfaces: Sequence[tuple[Surface, PartMesh]],
) -> list[tuple[tuple[Colour, str], Surface]]:
    """Returns a surface for each colour and texture, with the triangles of all parts that have them, sorted
    by colour and texture."""
    if not moved_surfaces:
        return []
    paints = sorted({paint for _, mesh in moved_surfaces for paint in mesh.paints})
    rank = {paint: index for index, paint in enumerate(paints)}
    all_triangles = join_surfaces([surface for surface, _ in moved_surfaces])
    ranks = np.concatenate(
        [np.array([rank[paint] for paint in mesh.paints])[mesh.colours] for _, mesh in moved_surfaces]
    )
    order = np.argsort(ranks, kind="stable")
    bounds = np.searchsorted(ranks[order], np.arange(len(paints) + 1))
    return [
        (paint, select_triangles(all_triangles, order[begin:end]))
        for paint, begin, end in zip(paints, bounds, bounds[1:], strict=False)
        if end > begin
    ]
