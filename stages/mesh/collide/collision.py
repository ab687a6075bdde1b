"""Defines the collider of a part or a link, with its figures, and encodes it as bytes."""

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
    """The collider of a part, in the part's frame, or of several parts together, in the link's frame."""

    pieces: tuple[Piece, ...] = ()
    """Pieces whose union is the collider."""
    faces: int = 0
    """Number of triangles of the cleaned part."""
    measures: Measures | None = None
    """Distances and volumes from the part; None if the collider was not judged."""
    rung: str = "none"
    """Kind of the collider, in a word: "box", "hull", "pieces" ..."""
    tolerance: float | None = None
    """Tolerance [m] by which the collider was judged; None if it was not."""
    meets: bool = True
    """Whether the collider is as near to the part as it should be."""
    note: str = ""
    """Reason in words why the collider is no better."""
    convex: bool = True
    """Whether the surfaces are convex pieces, and not the mesh of a part."""
    failed: bool = False
    """Whether another attempt may give a better collider."""
    reason: str = ""
    """Reason in words for the number of pieces of a collider by contact."""

    def with_note(self, note: str) -> Collision:
        """Returns the collider with a note."""
        return replace(self, note=note)


def colliders(collision: Collision, link_from_part: Array) -> Iterator[Collider]:
    """Yields the collider as mesh files and primitives in the link's frame. `link_from_part`: (4, 4)."""
    moves = not np.array_equal(link_from_part, np.eye(4))
    for local in collision.pieces:
        piece = placed(local, link_from_part) if moves else local
        if isinstance(piece, Primitive):
            yield piece
        elif collision.convex:
            yield mesh_file.collider(piece)
        else:
            for file in mesh_file.visuals(piece, NEUTRAL):
                yield replace(file, colour=None)


def encode(collision: Collision) -> bytes:
    """Returns a collision as bytes."""
    return orjson.dumps(codec.plain_data(collision))


def decode(data: bytes) -> Collision:
    """Reads the collision that `encode` wrote."""
    return codec.typed(Collision, orjson.loads(data))  # type: ignore[no-any-return]


def digest(pieces: Sequence[Piece]) -> str:
    """Returns a digest of the shapes of pieces."""
    return hashlib.sha256(encode(Collision(tuple(pieces)))).hexdigest()
