"""What a part or a link collides with, how it came about, and how near it is to the part; as bytes too."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import orjson

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
    """A collision as bytes."""
    return orjson.dumps(codec.plain(collision))


def decode(data: bytes) -> Collision:
    """The collision that `encode` wrote."""
    return codec.typed(Collision, orjson.loads(data))  # type: ignore[no-any-return]


def digest(pieces: Sequence[Piece]) -> str:
    """Of the shapes of pieces."""
    return hashlib.sha256(encode(Collision(tuple(pieces)))).hexdigest()
