"""What a part or a link collides with, how it came about, and how near it is to the part; as bytes too."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import numpy as np
import orjson

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.files import mesh_file
from linkwright.stages.mesh.files.mesh_file import MeshFile
from linkwright.stages.mesh.measure import Measures
from linkwright.stages.mesh.surfaces.pieces import Piece, placed
from linkwright.stages.robot import codec
from linkwright.stages.robot.model.geometry import NEUTRAL
from linkwright.stages.robot.model.robot import Array, Primitive

Collider = MeshFile | Primitive


@dataclass(frozen=True, slots=True, eq=False)
class Collision:
    """The collider of a part, or of several parts together, in the frame of what it is made for.

    `pieces`: their union is the collider. `faces`: how many triangles the part has, cleaned.
    `measures`, `tolerance` [m]: what it was judged by, None where it was not. `rung`: what it is, in a word:
    "box", "hull", "pieces" ... `meets`: whether it is as near to the part as it should be. `note`: why it is
    no better, in words. `convex`: whether its surfaces are convex pieces, and not a part's own mesh.
    `failed`: whether it may be better next time. `reason`: why a collider by contact is what it is, in words.
    """

    pieces: tuple[Piece, ...] = ()
    faces: int = 0
    measures: Measures | None = None
    rung: str = "none"
    tolerance: float | None = None
    meets: bool = True
    note: str = ""
    convex: bool = True
    failed: bool = False
    reason: str = ""

    def with_note(self, note: str) -> Collision:
        return replace(self, note=note)


def colliders(collision: Collision, link_from_part: Array) -> Iterator[Collider]:
    """The collider as mesh files and primitives in the frame of the link. `link_from_part`: (4, 4)."""
    moves = not np.array_equal(link_from_part, np.eye(4))
    for one in collision.pieces:
        piece = placed(one, link_from_part) if moves else one
        if isinstance(piece, Primitive):
            yield piece
        elif collision.convex:
            yield mesh_file.collider(piece)
        else:
            for file in mesh_file.visuals(piece, NEUTRAL):
                yield replace(file, colour=None)


def encode(collision: Collision) -> bytes:
    """A collision as bytes: the length of a JSON header, the header, the points and triangles."""
    pieces = [
        {"primitive": codec.plain(one)}
        if isinstance(one, Primitive)
        else {"vertices": len(one.vertices), "triangles": len(one.triangles)}
        for one in collision.pieces
    ]
    table = {one.name: getattr(collision, one.name) for one in fields(collision)}
    measures = asdict(collision.measures) if collision.measures else None
    header = orjson.dumps({**table, "pieces": pieces, "measures": measures})
    arrays = [
        array.tobytes()
        for one in collision.pieces
        if isinstance(one, Surface)
        for array in (one.vertices.astype("<f8"), one.triangles.astype("<i8"))
    ]
    return struct.pack("<Q", len(header)) + header + b"".join(arrays)


def digest(pieces: Sequence[Piece]) -> str:
    """Of the shapes of pieces."""
    return hashlib.sha256(encode(Collision(tuple(pieces)))).hexdigest()


def decode(data: bytes) -> Collision:
    """The collision that `encode` wrote."""
    (length,) = struct.unpack_from("<Q", data)
    header = orjson.loads(data[8 : 8 + length])
    measures = Measures(**header["measures"]) if header["measures"] else None
    pieces = tuple(_pieces(header["pieces"], memoryview(data)[8 + length :]))
    return Collision(**{**header, "pieces": pieces, "measures": measures})


def _pieces(records: Sequence[dict[str, Any]], arrays: memoryview) -> Iterator[Piece]:
    at = 0
    for record in records:
        if "primitive" in record:
            primitive: Primitive = codec.typed(Primitive, record["primitive"])
            yield primitive
            continue
        middle = at + 24 * record["vertices"]
        end = middle + 24 * record["triangles"]
        vertices = np.frombuffer(arrays[at:middle], "<f8").reshape(-1, 3)
        yield Surface(vertices, np.frombuffer(arrays[middle:end], "<i8").reshape(-1, 3).astype(np.int64))
        at = end
