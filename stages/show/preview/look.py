"""What is seen of a robot, as plain data: shapes, where they are at `home`, their colours, and the camera.

Two robots of one look have one picture: how they move, what they weigh and what they collide with is no part
of it.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from hashlib import sha256
from typing import Any, Literal

Solid = Literal["ellipsoid", "capsule", "cylinder", "box", "mesh"]
Packing = Literal["stl", "corners", "image"]

Vector = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Geom:
    """A shape. `size` [m], as MuJoCo has it; of a mesh the `blob` with its triangles, and their `scale` (3,).
    `position` (3,) [m] and `turn` (9,), row by row, in the world; `colour` (4,), from 0 to 1; the `image`
    that lies over it, a blob, and how often it repeats; -1 for none."""

    solid: Solid
    size: Vector
    position: Vector
    turn: Vector
    colour: Vector
    blob: int = -1
    scale: Vector = (1.0, 1.0, 1.0)
    image: int = -1
    repeat: Vector = (1.0, 1.0)


@dataclass(frozen=True, slots=True)
class Blob:
    """`stl`: a binary STL; `corners`: (m, 3, 3) float32, and where each corner is in an image, (m, 3, 2)
    float32; `image`: (height, width, 3) of bytes, `height` pixels high."""

    packing: Packing
    data: bytes
    height: int = 0


@dataclass(frozen=True, slots=True)
class Look:
    """The shapes that are seen, the direction `backward` (3,) from the robot to the camera, and the blobs."""

    geoms: tuple[Geom, ...]
    backward: Vector
    blobs: tuple[Blob, ...]

    def key(self) -> dict[str, Any]:
        """What identifies it, as plain data."""
        blobs = [[blob.packing, blob.height, sha256(blob.data).hexdigest()] for blob in self.blobs]
        return {"geoms": _plain(self.geoms), "backward": self.backward, "blobs": blobs}


def packed(look: Look, kind: str) -> bytes:
    """A line of JSON, and the blobs: what the guest is asked, with the kind of the preview."""
    blobs = [[blob.packing, blob.height, len(blob.data)] for blob in look.blobs]
    head = {"kind": kind, "geoms": _plain(look.geoms), "backward": look.backward, "blobs": blobs}
    return b"".join([json.dumps(head).encode(), b"\n", *(blob.data for blob in look.blobs)])


def unpacked(request: bytes) -> tuple[Look, str]:
    """The look, and the kind of the preview."""
    at = request.index(b"\n") + 1
    head = json.loads(request[:at])
    blobs = []
    for packing, height, length in head["blobs"]:
        blobs.append(Blob(packing, request[at : at + length], height))
        at += length
    geoms = tuple(Geom(**geom) for geom in head["geoms"])
    return Look(geoms, tuple(head["backward"]), tuple(blobs)), head["kind"]


def _plain(geoms: Sequence[Geom]) -> list[Mapping[str, Any]]:
    return [asdict(geom) for geom in geoms]
