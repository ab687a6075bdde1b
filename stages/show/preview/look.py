"""Describes the look of a robot as plain data: shapes, their poses at `home`, colours, and the camera.

Two robots with the same look have the same picture: motion, masses and colliders are not part of the look.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from hashlib import sha256
from typing import Any, Literal

Solid = Literal["ellipsoid", "capsule", "cylinder", "box", "mesh"]
Packing = Literal["stl", "corners", "image"]

Vector = tuple[float, ...]

UNSEEN = 0.02
"""Shapes with at most this opacity are not drawn."""

THREE_QUARTER = (0.668, -0.602, 0.401)
"""The default direction (3,) from the robot to the camera: in front, to the robot's right, above."""


@dataclass(frozen=True, slots=True)
class Geom:
    """A visible shape."""

    solid: Solid
    size: Vector
    """The size [m] in MuJoCo's form; empty for a mesh."""

    position: Vector
    """The position (3,) [m] in the world."""

    turn: Vector
    """The rotation matrix (9,), row by row, in the world."""

    colour: Vector
    """Red, green, blue and opacity (4,), from 0 to 1."""

    blob: int = -1
    """The index of the blob with the triangles of a mesh."""

    scale: Vector = (1.0, 1.0, 1.0)
    """The scale (3,) of the triangles of a mesh."""

    image: int = -1
    """The index of the blob with the image that covers the shape; -1 without an image."""

    repeat: Vector = (1.0, 1.0)
    """The repetition (2,) of the image."""


@dataclass(frozen=True, slots=True)
class Blob:
    """The data of a mesh or an image."""

    packing: Packing
    data: bytes
    """stl: a binary STL; corners: the corners (m, 3, 3) and their places in an image (m, 3, 2), as float32;
    image: pixels (height, width, 3), as bytes."""

    height: int = 0
    """The height of an image [pixels]."""


@dataclass(frozen=True, slots=True)
class Look:
    """The visible shapes, the direction `backward` (3,) from the robot to the camera, and the blobs."""

    geoms: tuple[Geom, ...]
    backward: Vector
    blobs: tuple[Blob, ...]

    def key(self) -> dict[str, Any]:
        """Returns all on which a picture of the look depends, as plain data for cache keys."""
        blobs = [[blob.packing, blob.height, sha256(blob.data).hexdigest()] for blob in self.blobs]
        return {"geoms": _plain(self.geoms), "backward": self.backward, "blobs": blobs}


def packed(look: Look) -> bytes:
    """Packs a look as the guest's request: a line of JSON, and the blobs."""
    blobs = [[blob.packing, blob.height, len(blob.data)] for blob in look.blobs]
    head = {"geoms": _plain(look.geoms), "backward": look.backward, "blobs": blobs}
    return b"".join([json.dumps(head).encode(), b"\n", *(blob.data for blob in look.blobs)])


def unpacked(request: bytes) -> Look:
    """Returns the look in a guest's request."""
    offset = request.index(b"\n") + 1
    head = json.loads(request[:offset])
    blobs = []
    for packing, height, length in head["blobs"]:
        blobs.append(Blob(packing, request[offset : offset + length], height))
        offset += length
    geoms = tuple(Geom(**geom) for geom in head["geoms"])
    return Look(geoms, tuple(head["backward"]), tuple(blobs))


def _plain(geoms: Sequence[Geom]) -> list[Mapping[str, Any]]:
    return [asdict(geom) for geom in geoms]
