"""One link's meshes from the meshes of its parts, as a value that can be kept as bytes."""

import struct
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import orjson

from stages.mesh import mesh_file
from stages.mesh.colliders.hull import convex_hull
from stages.mesh.mesh_file import Piece
from stages.mesh.surface import Surface, compacted, moved
from stages.mesh.tessellation import PartMesh
from stages.robot.geometry import Colour
from stages.robot.model import Array, MeshRef


@dataclass(frozen=True, slots=True, eq=False)
class Use:
    """A part's mesh in a link: which, `link_from_part` (4, 4), and whether it is more than seen, and seen
    at all."""

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
    """What was found of one use: whether there is a mesh, and its volume [m³], None where open."""

    found: bool
    volume: float | None


@dataclass(frozen=True, slots=True)
class LinkMesh:
    """A link's pieces in its own frame, `visuals` sorted by colour, and a finding for each use."""

    visuals: tuple[Piece, ...]
    collision: Piece | None
    findings: tuple[Finding, ...]


def make(uses: Sequence[Use], meshes: Mapping[MeshRef, PartMesh]) -> LinkMesh:
    """The meshes of a link that uses parts so; the order of `uses` is that of the findings."""
    placed = [
        (moved(mesh.surface, use.link_from_part), mesh)
        for use in uses
        if use.seen and (mesh := meshes.get(use.mesh))
    ]
    visuals = [part for colour, surface in _by_colour(placed) for part in mesh_file.visuals(surface, colour)]
    solid = [
        moved(mesh.surface, use.link_from_part).vertices
        for use in uses
        if use.collides and (mesh := meshes.get(use.mesh))
    ]
    hull = convex_hull(np.concatenate(solid)) if solid else None
    return LinkMesh(
        visuals=tuple(visuals),
        collision=mesh_file.collider(hull) if hull is not None else None,
        findings=tuple(_finding(meshes.get(use.mesh)) for use in uses),
    )


def _finding(mesh: PartMesh | None) -> Finding:
    if mesh is None:
        return Finding(False, None)
    return Finding(True, mesh.volume if mesh.closed else None)


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


def encode(link: LinkMesh) -> bytes:
    """A link's meshes as bytes: the length of a JSON header, the header, the files."""
    pieces = [*link.visuals, *([link.collision] if link.collision else [])]
    header = orjson.dumps(
        {
            "pieces": [{**asdict(part), "data": len(part.data)} for part in pieces],
            "collision": link.collision is not None,
            "findings": [asdict(finding) for finding in link.findings],
        }
    )
    return struct.pack("<Q", len(header)) + header + b"".join(part.data for part in pieces)


def decode(data: bytes) -> LinkMesh:
    """The meshes that `encode` wrote."""
    (length,) = struct.unpack_from("<Q", data)
    start = 8 + length
    header = orjson.loads(data[8:start])
    pieces = []
    for record in header["pieces"]:
        size = record["data"]
        colour = tuple(record["colour"]) if record["colour"] else None
        pieces.append(Piece(**{**record, "colour": colour, "data": data[start : start + size]}))
        start += size
    collision = pieces.pop() if header["collision"] else None
    findings = tuple(Finding(**finding) for finding in header["findings"])
    return LinkMesh(tuple(pieces), collision, findings)
