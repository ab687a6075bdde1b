"""The visual meshes of a link, made from the meshes of its parts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface, chosen, joined, moved
from linkwright.stages.mesh.files import mesh_file
from linkwright.stages.mesh.files.mesh_file import MeshFile
from linkwright.stages.mesh.tessellation import PartMesh
from linkwright.stages.mesh.visuals.budget import Decimation, Decimator
from linkwright.stages.robot.model.geometry import Colour
from linkwright.stages.robot.model.robot import Array, MeshRef

if TYPE_CHECKING:
    from linkwright.stages.mesh.section import VisualSection

_ATTEMPTS = 4


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """A part that is drawn: its number among the parts of the link, its mesh and `link_from_part` (4, 4)."""

    index: int
    mesh: MeshRef
    link_from_part: Array


@dataclass(frozen=True, slots=True)
class LinkVisuals:
    """The visual meshes of a link, sorted by colour and texture, or by part and these: then `owners` has the
    number of the part of each. `decimation`: None where the meshes are as the parts have them."""

    files: tuple[MeshFile, ...]
    owners: tuple[int, ...]
    decimation: Decimation | None


def visuals(
    drawn: Sequence[Drawn], meshes: Mapping[MeshRef, PartMesh], keys: "VisualSection", decimator: Decimator
) -> LinkVisuals:
    """The visual meshes with at most `max_faces` triangles together, or the fewest that the bound of the
    error allows; one a colour, or one a part and colour."""
    allowed = most = keys.max_faces
    for _ in range(_ATTEMPTS):
        fitted, decimation = decimator.fitted([one.mesh for one in drawn], meshes, allowed)
        groups = [[one] for one in drawn] if keys.merge == "part" else [drawn]
        found = [(group[0].index, file) for group in groups if group for file in _files(group, fitted)]
        faces = sum(file.faces for _, file in found)
        # A flat surface gets a back, so that files may have more triangles than their parts.
        if faces <= most or (decimation is not None and decimation.limited):
            break
        allowed = max(0, allowed - (faces - most))
    owners = tuple(index for index, _ in found) if keys.merge == "part" else ()
    return LinkVisuals(tuple(file for _, file in found), owners, decimation)


def _files(drawn: Sequence[Drawn], meshes: Mapping[MeshRef, PartMesh]) -> tuple[MeshFile, ...]:
    placed = [
        (moved(mesh.surface, one.link_from_part), mesh) for one in drawn if (mesh := meshes.get(one.mesh))
    ]
    return tuple(
        file
        for (colour, texture), surface in _by_paint(placed)
        for file in mesh_file.visuals(surface, colour, texture)
    )


def _by_paint(placed: Sequence[tuple[Surface, PartMesh]]) -> list[tuple[tuple[Colour, str], Surface]]:
    """The triangles of all parts as one surface for each colour and texture, sorted by these."""
    if not placed:
        return []
    paints = sorted({paint for _, mesh in placed for paint in mesh.paints})
    rank = {paint: index for index, paint in enumerate(paints)}
    whole = joined([surface for surface, _ in placed])
    ranks = np.concatenate(
        [np.array([rank[paint] for paint in mesh.paints])[mesh.colours] for _, mesh in placed]
    )
    order = np.argsort(ranks, kind="stable")
    bounds = np.searchsorted(ranks[order], np.arange(len(paints) + 1))
    return [
        (paint, chosen(whole, order[begin:end]))
        for paint, begin, end in zip(paints, bounds, bounds[1:], strict=False)
        if end > begin
    ]
