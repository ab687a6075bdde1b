"""Collects findings about the meshes of a link's parts, and encodes the link's visual meshes."""

import io
import struct
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import orjson

from linkwright.stages.formats.meshes.surface import Surface, transform_surface
from linkwright.stages.mesh.files.mesh_file import MeshFile
from linkwright.stages.mesh.part_mesh import PartMesh
from linkwright.stages.mesh.visuals.budget import Decimation, Decimator
from linkwright.stages.mesh.visuals.make import DrawnPart, LinkVisuals, make_visuals
from linkwright.stages.robot.model.robot import Array, MeshRef

if TYPE_CHECKING:
    from linkwright.stages.mesh.section import VisualSection


@dataclass(frozen=True, slots=True, eq=False)
class PlacedMesh:
    """The mesh of a part, at its place in a link."""

    mesh: MeshRef
    link_from_part: Array
    """Pose of the part in the link (4, 4)."""
    collides: bool = True
    """Whether the part takes part in contact."""
    seen: bool = True
    """Whether the part is drawn."""

    def key(self) -> list[Any]:
        """Returns the placed mesh as plain data, exact to the bit, for cache keys."""
        return [
            self.mesh.part,
            # + 0.0 makes -0.0 equal to 0.0.
            [(value + 0.0).hex() for value in self.link_from_part.ravel().tolist()],
            self.mesh.reply,
            *([] if self.collides else ["seen"]),
            *([] if self.seen else ["unseen"]),
        ]


@dataclass(frozen=True, slots=True)
class PartFinding:
    """Properties of a part's mesh."""

    found: bool
    """Whether there is a mesh."""
    volume: float | None
    """Volume [m³]; None if the mesh is open or missing."""
    diagonal: float = 0.0
    """Diagonal [m] of the bounding box."""


@dataclass(frozen=True, slots=True)
class LinkParts:
    """Findings about the meshes of a link's parts."""

    findings: tuple[PartFinding, ...]
    """A finding for each use of a mesh in the link."""
    diagonal: float = 0.0
    """Diagonal [m] of the bounding box of all parts that take part in contact."""

    @staticmethod
    def of(uses: Sequence[PlacedMesh], meshes: Mapping[MeshRef, PartMesh]) -> "LinkParts":
        """Returns the findings, in the order of the uses."""
        findings = tuple(_finding(meshes.get(use.mesh)) for use in uses)
        colliding = [
            transform_surface(mesh.surface, use.link_from_part)
            for use in uses
            if use.collides and (mesh := meshes.get(use.mesh))
        ]
        return LinkParts(findings, _diagonal(colliding))


def visuals_of(
    uses: Sequence[PlacedMesh],
    meshes: Mapping[MeshRef, PartMesh],
    keys: "VisualSection",
    decimator: Decimator,
) -> LinkVisuals:
    """Returns the visual meshes of a link, in the link's frame."""
    drawn_parts = [
        DrawnPart(index, use.mesh, use.link_from_part) for index, use in enumerate(uses) if use.seen
    ]
    return make_visuals(drawn_parts, meshes, keys, decimator)


def _finding(mesh: PartMesh | None) -> PartFinding:
    if mesh is None:
        return PartFinding(False, None)
    return PartFinding(True, mesh.volume if mesh.closed else None, _diagonal([mesh.surface]))


def _diagonal(surfaces: Sequence[Surface]) -> float:
    if not surfaces:
        return 0.0
    low = np.min([surface.vertices.min(axis=0) for surface in surfaces], axis=0)
    high = np.max([surface.vertices.max(axis=0) for surface in surfaces], axis=0)
    return float(np.linalg.norm(high - low))


def encode(link: LinkVisuals) -> bytes:
    """Returns a link's visual meshes as bytes: the length of a JSON header, the header, and the files."""
    header = orjson.dumps(
        {
            "files": [_record(file) for file in link.files],
            "owners": list(link.owners),
            "decimation": asdict(link.decimation) if link.decimation else None,
        }
    )
    files = b"".join(file.data for file in link.files)
    return struct.pack("<Q", len(header)) + header + files


def decode(data: bytes) -> LinkVisuals:
    """Reads the meshes that `encode` wrote."""
    (length,) = struct.unpack_from("<Q", data)
    header, files = orjson.loads(data[8 : 8 + length]), io.BytesIO(data[8 + length :])
    return LinkVisuals(
        files=tuple(_mesh_file(record, files) for record in header["files"]),
        owners=tuple(header["owners"]),
        decimation=Decimation(**header["decimation"]) if header["decimation"] else None,
    )


def _record(file: MeshFile) -> dict[str, Any]:
    """Returns the header's entry of a mesh file: its figures, and the length of its data."""
    return {**asdict(file), "data": len(file.data)}


def _mesh_file(record: dict[str, Any], files: io.BytesIO) -> MeshFile:
    colour = tuple(record["colour"]) if record["colour"] else None
    data, bounds = files.read(record["data"]), tuple(record["bounds"])
    return MeshFile(**{**record, "colour": colour, "data": data, "bounds": bounds})
