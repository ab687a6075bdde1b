"""The meshes and colliders of one link, made from the meshes of its parts and stored as bytes."""

import io
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import orjson

from stages.mesh.collider_settings import ColliderSettings
from stages.mesh.mesh_file import MeshFile
from stages.mesh.surface import Surface, moved
from stages.mesh.tessellation import PartMesh
from stages.mesh.visuals.budget import Decimation, Decimator
from stages.mesh.visuals.make import Drawn, visuals
from stages.robot import codec
from stages.robot.model import Array, MeshRef, Primitive

if TYPE_CHECKING:
    from stages.mesh.keys import VisualKeys

Collider = MeshFile | Primitive

ColliderMaker = Callable[[Sequence[Surface], ColliderSettings], tuple[Collider, ...]]
"""Makes the colliders of a link from the surfaces of its parts (at least one), all in the link's frame."""


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
class Finding:
    """Whether there is a mesh for one use, and its volume [m³]; None where the mesh is open."""

    found: bool
    volume: float | None


@dataclass(frozen=True, slots=True)
class LinkMesh:
    """A link's visual meshes, sorted by colour, its colliders, all in its own frame, and a finding for each
    use, and what decimation made of the visual meshes.

    `owners`: the use of each visual mesh, where each has one of its own.
    """

    visuals: tuple[MeshFile, ...]
    colliders: tuple[Collider, ...]
    findings: tuple[Finding, ...]
    decimation: Decimation | None = None
    owners: tuple[int, ...] = ()


def make(
    uses: Sequence[Use],
    meshes: Mapping[MeshRef, PartMesh],
    maker: ColliderMaker,
    settings: ColliderSettings,
    keys: "VisualKeys",
    decimator: Decimator,
) -> LinkMesh:
    """The meshes of a link; the order of `uses` is that of the findings. `keys`: of its visual meshes."""
    drawn = [Drawn(index, use.mesh, use.link_from_part) for index, use in enumerate(uses) if use.seen]
    seen = visuals(drawn, meshes, keys, decimator)
    solid = [
        moved(mesh.surface, use.link_from_part)
        for use in uses
        if use.collides and (mesh := meshes.get(use.mesh))
    ]
    return LinkMesh(
        visuals=seen.files,
        colliders=maker(solid, settings) if solid else (),
        findings=tuple(_finding(meshes.get(use.mesh)) for use in uses),
        decimation=seen.decimation,
        owners=seen.owners,
    )


def _finding(mesh: PartMesh | None) -> Finding:
    if mesh is None:
        return Finding(False, None)
    return Finding(True, mesh.volume if mesh.closed else None)


def encode(link: LinkMesh) -> bytes:
    """A link's meshes as bytes: the length of a JSON header, the header, the files."""
    header = orjson.dumps(
        {
            "visuals": [_record(file) for file in link.visuals],
            "colliders": [_record(collider) for collider in link.colliders],
            "findings": [asdict(finding) for finding in link.findings],
            "owners": list(link.owners),
            "decimation": asdict(link.decimation) if link.decimation else None,
        }
    )
    files = [one.data for one in (*link.visuals, *link.colliders) if isinstance(one, MeshFile)]
    return struct.pack("<Q", len(header)) + header + b"".join(files)


def decode(data: bytes) -> LinkMesh:
    """The meshes that `encode` wrote."""
    (length,) = struct.unpack_from("<Q", data)
    header, files = orjson.loads(data[8 : 8 + length]), io.BytesIO(data[8 + length :])
    return LinkMesh(
        visuals=tuple(_mesh_file(record, files) for record in header["visuals"]),
        colliders=tuple(_collider(record, files) for record in header["colliders"]),
        findings=tuple(Finding(**finding) for finding in header["findings"]),
        owners=tuple(header["owners"]),
        decimation=Decimation(**header["decimation"]) if header["decimation"] else None,
    )


def _record(collider: Collider) -> dict[str, Any]:
    """The header's entry: of a mesh file its figures and its length, of a primitive all."""
    if isinstance(collider, MeshFile):
        return {**asdict(collider), "data": len(collider.data)}
    return {"primitive": codec.plain(collider)}


def _collider(record: dict[str, Any], files: io.BytesIO) -> Collider:
    if "primitive" in record:
        primitive: Primitive = codec.typed(Primitive, record["primitive"])
        return primitive
    return _mesh_file(record, files)


def _mesh_file(record: dict[str, Any], files: io.BytesIO) -> MeshFile:
    colour = tuple(record["colour"]) if record["colour"] else None
    return MeshFile(**{**record, "colour": colour, "data": files.read(record["data"])})
