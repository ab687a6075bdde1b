"""Makes the visual meshes of a link from the meshes of its parts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface, chosen, joined, moved
from linkwright.stages.mesh.files import mesh_file
from linkwright.stages.mesh.files.mesh_file import MeshFile
from linkwright.stages.mesh.part_mesh import PartMesh
from linkwright.stages.mesh.visuals.budget import Decimation, Decimator
from linkwright.stages.robot.model.geometry import Colour
from linkwright.stages.robot.model.robot import Array, MeshRef

if TYPE_CHECKING:
    from linkwright.stages.mesh.section import VisualSection

_MAX_ATTEMPTS = 4
"""Largest number of times that parts are decimated again because backs of flat surfaces exceed the limit."""


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """A part that is drawn."""

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


def visuals(
    drawn_parts: Sequence[Drawn],
    meshes: Mapping[MeshRef, PartMesh],
    keys: "VisualSection",
    decimator: Decimator,
) -> LinkVisuals:
    """Makes the visual meshes, for each colour, or for each part and colour. Together they have at most
    `max_faces` triangles, or the fewest that the bound of the error allows."""
    allowed = max_faces = keys.max_faces
    for _ in range(_MAX_ATTEMPTS):
        fitted, decimation = decimator.fitted([part.mesh for part in drawn_parts], meshes, allowed)
        groups = [[part] for part in drawn_parts] if keys.merge == "part" else [drawn_parts]
        files = [(group[0].index, file) for group in groups if group for file in _files(group, fitted)]
        faces = sum(file.faces for _, file in files)
        # A flat surface gets a back, so that files may have more triangles than their parts.
        if faces <= max_faces or (decimation is not None and decimation.limited):
            break
        allowed = max(0, allowed - (faces - max_faces))
    owners = tuple(index for index, _ in files) if keys.merge == "part" else ()
    return LinkVisuals(tuple(file for _, file in files), owners, decimation)


def _files(drawn_parts: Sequence[Drawn], meshes: Mapping[MeshRef, PartMesh]) -> tuple[MeshFile, ...]:
    moved_surfaces = [
        (moved(mesh.surface, part.link_from_part), mesh)
        for part in drawn_parts
        if (mesh := meshes.get(part.mesh))
    ]
    return tuple(
        file
        for (colour, texture), surface in _by_coloured_image(moved_surfaces)
        for file in mesh_file.visuals(surface, colour, texture)
    )


def _by_coloured_image(
    moved_surfaces: Sequence[tuple[Surface, PartMesh]],
) -> list[tuple[tuple[Colour, str], Surface]]:
    """Returns the triangles of all parts, joined to a surface for each colour and texture, sorted by
    these."""
    if not moved_surfaces:
        return []
    paints = sorted({paint for _, mesh in moved_surfaces for paint in mesh.paints})
    rank = {paint: index for index, paint in enumerate(paints)}
    whole = joined([surface for surface, _ in moved_surfaces])
    ranks = np.concatenate(
        [np.array([rank[paint] for paint in mesh.paints])[mesh.colours] for _, mesh in moved_surfaces]
    )
    order = np.argsort(ranks, kind="stable")
    bounds = np.searchsorted(ranks[order], np.arange(len(paints) + 1))
    return [
        (paint, chosen(whole, order[begin:end]))
        for paint, begin, end in zip(paints, bounds, bounds[1:], strict=False)
        if end > begin
    ]
