"""What is known of the meshes of a link's parts, and its visual meshes made of them, both as bytes too."""

import io
import struct
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import orjson

from linkwright.stages.formats.meshes.surface import Surface, moved
from linkwright.stages.mesh.files.mesh_file import MeshFile
from linkwright.stages.mesh.tessellation import PartMesh
from linkwright.stages.mesh.visuals.budget import Decimation, Decimator
from linkwright.stages.mesh.visuals.make import Drawn, LinkVisuals, visuals
from linkwright.stages.robot.model.robot import Array, MeshRef

if TYPE_CHECKING:
    from linkwright.stages.mesh.section import VisualSection


@dataclass(frozen=True, slots=True, eq=False)
class Use:
    """A part's mesh in a link: which one, `link_from_part` (4, 4), whether it takes part in contact, and
    whether it is drawn."""

    mesh: MeshRef
    link_from_part: Array
    collides: bool = True
    seen: bool = True

    def key(self) -> list[Any]:
        """The use as plain data, exact to the bit."""
        return [
            self.mesh.part,
            [(value + 0.0).hex() for value in self.link_from_part.ravel().tolist()],
            self.mesh.reply,
            *([] if self.collides else ["seen"]),
            *([] if self.seen else ["unseen"]),
        ]


@dataclass(frozen=True, slots=True)
class PartFinding:
    """Whether there is a mesh for one use, its volume [m³], None where the mesh is open, and the diagonal of
    its bounding box [m]."""

    found: bool
    volume: float | None
    diagonal: float = 0.0


@dataclass(frozen=True, slots=True)
class LinkParts:
    """A finding for each use of a mesh in a link. `diagonal` [m]: of the box around all that takes part in
    contact."""

    findings: tuple[PartFinding, ...]
    diagonal: float = 0.0

    @staticmethod
    def of(uses: Sequence[Use], meshes: Mapping[MeshRef, PartMesh]) -> "LinkParts":
        """Findings in the order of the uses."""
        found = tuple(_finding(meshes.get(use.mesh)) for use in uses)
        colliding = [
            moved(mesh.surface, use.link_from_part)
            for use in uses
            if use.collides and (mesh := meshes.get(use.mesh))
        ]
        return LinkParts(found, _diagonal(colliding))


def visuals_of(
    uses: Sequence[Use], meshes: Mapping[MeshRef, PartMesh], keys: "VisualSection", decimator: Decimator
) -> LinkVisuals:
    """The visual meshes of a link, in its own frame."""
    drawn = [Drawn(index, use.mesh, use.link_from_part) for index, use in enumerate(uses) if use.seen]
    return visuals(drawn, meshes, keys, decimator)


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
    """A link's visual meshes as bytes: the length of a JSON header, the header, the files."""
    header = orjson.dumps(
        {
            "files": [_record(file) for file in link.files],
            "owners": list(link.owners),
            "decimation": asdict(link.decimation) if link.decimation else None,
        }
    )
    files = b"".join(one.data for one in link.files)
    return struct.pack("<Q", len(header)) + header + files


def decode(data: bytes) -> LinkVisuals:
    """The meshes that `encode` wrote."""
    (length,) = struct.unpack_from("<Q", data)
    header, files = orjson.loads(data[8 : 8 + length]), io.BytesIO(data[8 + length :])
    return LinkVisuals(
        files=tuple(_mesh_file(record, files) for record in header["files"]),
        owners=tuple(header["owners"]),
        decimation=Decimation(**header["decimation"]) if header["decimation"] else None,
    )


def _record(file: MeshFile) -> dict[str, Any]:
    """The header's entry: the figures of a mesh file, and its length."""
    return {**asdict(file), "data": len(file.data)}


def _mesh_file(record: dict[str, Any], files: io.BytesIO) -> MeshFile:
    colour = tuple(record["colour"]) if record["colour"] else None
    data, bounds = files.read(record["data"]), tuple(record["bounds"])
    return MeshFile(**{**record, "colour": colour, "data": data, "bounds": bounds})
