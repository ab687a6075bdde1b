"""The visual meshes of one link, made from the meshes of its parts and stored as bytes."""

import io
import struct
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import orjson

from stages.mesh.mesh_file import MeshFile
from stages.mesh.surface import Surface, moved
from stages.mesh.tessellation import PartMesh
from stages.mesh.visuals.budget import Decimation, Decimator
from stages.mesh.visuals.make import Drawn, visuals
from stages.robot.model import Array, MeshRef

if TYPE_CHECKING:
    from stages.mesh.keys import VisualKeys


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
class LinkMesh:
    """A link's visual meshes, sorted by colour, in its own frame, a finding for each use, and what decimation
    made of the meshes.

    `owners`: the use of each visual mesh, where each has one of its own. `diagonal` [m]: of the box around
    all that takes part in contact.
    """

    visuals: tuple[MeshFile, ...]
    findings: tuple[PartFinding, ...]
    decimation: Decimation | None = None
    owners: tuple[int, ...] = ()
    diagonal: float = 0.0


def make(
    uses: Sequence[Use],
    meshes: Mapping[MeshRef, PartMesh],
    keys: "VisualKeys",
    decimator: Decimator,
) -> LinkMesh:
    """The meshes of a link; the order of `uses` is that of the findings. `keys`: of its visual meshes."""
    drawn = [Drawn(index, use.mesh, use.link_from_part) for index, use in enumerate(uses) if use.seen]
    seen = visuals(drawn, meshes, keys, decimator)
    return LinkMesh(
        visuals=seen.files,
        findings=tuple(_finding(meshes.get(use.mesh)) for use in uses),
        decimation=seen.decimation,
        owners=seen.owners,
        diagonal=_diagonal(
            [
                moved(mesh.surface, use.link_from_part)
                for use in uses
                if use.collides and (mesh := meshes.get(use.mesh))
            ]
        ),
    )


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


def encode(link: LinkMesh) -> bytes:
    """A link's meshes as bytes: the length of a JSON header, the header, the files."""
    header = orjson.dumps(
        {
            "visuals": [_record(file) for file in link.visuals],
            "findings": [asdict(finding) for finding in link.findings],
            "owners": list(link.owners),
            "diagonal": link.diagonal,
            "decimation": asdict(link.decimation) if link.decimation else None,
        }
    )
    files = b"".join(one.data for one in link.visuals)
    return struct.pack("<Q", len(header)) + header + files


def decode(data: bytes) -> LinkMesh:
    """The meshes that `encode` wrote."""
    (length,) = struct.unpack_from("<Q", data)
    header, files = orjson.loads(data[8 : 8 + length]), io.BytesIO(data[8 + length :])
    return LinkMesh(
        visuals=tuple(_mesh_file(record, files) for record in header["visuals"]),
        findings=tuple(PartFinding(**finding) for finding in header["findings"]),
        owners=tuple(header["owners"]),
        diagonal=header["diagonal"],
        decimation=Decimation(**header["decimation"]) if header["decimation"] else None,
    )


def _record(file: MeshFile) -> dict[str, Any]:
    """The header's entry: the figures of a mesh file, and its length."""
    return {**asdict(file), "data": len(file.data)}


def _mesh_file(record: dict[str, Any], files: io.BytesIO) -> MeshFile:
    colour = tuple(record["colour"]) if record["colour"] else None
    data, bounds = files.read(record["data"]), tuple(record["bounds"])
    return MeshFile(**{**record, "colour": colour, "data": data, "bounds": bounds})
