"""Writes GLB files (binary glTF 2) that show a link: a mesh, with a part for each colour or image.

Lengths are in metres; the same surfaces always give the same bytes. Images are in the file.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import orjson

from linkwright.stages.formats.meshes import gltf
from linkwright.stages.formats.meshes.corner_normals import corner_normals
from linkwright.stages.formats.meshes.gltf_conventions import GENERATOR, linear
from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.robot.model.geometry import Colour

ROUGHNESS, METALLIC = 0.5, 0.0
"""The roughness and the metallic factor of every surface: CAD's appearances have neither. Metal is black in a
reader without surroundings to reflect."""

Up = Literal["z", "y"]
"""The axis of the scene that is the z axis of the link. z: the scene's frame is the link's; y: as in glTF's
standard, by a turn of the only node."""

_JSON, _BIN = 0x4E4F534A, 0x004E4942
"""The types of a GLB's chunks."""

_FLOAT, _SHORT, _INT = 5126, 5123, 5125
"""glTF's codes of the types of numbers."""

_POINTS, _INDICES = 34962, 34963
"""glTF's codes of the uses of a buffer."""

_MAX_SHORT = 0xFFFF
"""Largest number of points of a mesh whose indices have 16 bits: the last index ends a strip."""

_TO_Y_UP = (-(0.5**0.5), 0.0, 0.0, 0.5**0.5)
"""A quarter turn about x, as x, y, z, w."""


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A surface of a single colour."""

    surface: Surface
    colour: Colour
    image: bytes = b""
    """A PNG whose colours are multiplied by `colour`; b"" without an image."""


def write(pieces: Sequence[Piece], up: Up = "z") -> bytes:
    """Returns the file of the pieces, in the frame of their link."""
    return _GlbFile().written(pieces, up)


def coloured(data: bytes) -> list[tuple[npt.NDArray[np.float64], Colour]]:
    """Returns the corners (m, 3, 3) of the triangles of each colour in a glTF file, without images. Raises
    ProtocolError if the file is malformed."""
    return [
        (node.points[node.corners[node.which == index]], colour)
        for node in gltf.read(data)
        for index, colour in enumerate(node.colours)
    ]


class _GlbFile:
    """The tables of a file while it is written, and its bytes."""

    def __init__(self) -> None:
        self._bytes: list[bytes] = []
        self._views: list[dict[str, Any]] = []
        self._accessors: list[dict[str, Any]] = []
        self._materials: list[dict[str, Any]] = []
        self._images: list[bytes] = []
        self._views_of_images: list[int] = []

    def written(self, pieces: Sequence[Piece], up: Up) -> bytes:
        primitives = [self._primitive(piece) for piece in pieces]
        node = {"name": "visual", "mesh": 0, **({"rotation": _TO_Y_UP} if up == "y" else {})}
        images = [{"bufferView": view, "mimeType": "image/png"} for view in self._views_of_images]
        content = b"".join(self._bytes)
        table = {
            "asset": {"version": "2.0", "generator": GENERATOR},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [node],
            "meshes": [{"name": "visual", "primitives": primitives}],
            "materials": self._materials,
            "textures": [{"source": index} for index in range(len(images))],
            "images": images,
            "accessors": self._accessors,
            "bufferViews": self._views,
            "buffers": [{"byteLength": len(content)}],
        }
        # Empty lists are against the standard.
        text = orjson.dumps({key: value for key, value in table.items() if value})
        text += b" " * (-len(text) % 4)
        length = 12 + 8 + len(text) + 8 + len(content)
        head = b"glTF" + struct.pack("<II", 2, length)
        return b"".join(
            [
                head,
                struct.pack("<II", len(text), _JSON),
                text,
                struct.pack("<II", len(content), _BIN),
                content,
            ]
        )

    def _primitive(self, piece: Piece) -> dict[str, Any]:
        surface = piece.surface
        which, normals = corner_normals(surface)
        corner, places, texcoords = _vertices(which, surface.texcoords if piece.image else None)
        attributes = {
            "POSITION": self._numbers(surface.vertices[surface.triangles.ravel()[corner]], bounded=True),
            "NORMAL": self._numbers(normals[which.ravel()[corner]]),
        }
        if texcoords is not None:
            attributes["TEXCOORD_0"] = self._numbers(texcoords)
        return {
            "attributes": attributes,
            "indices": self._indices(places, len(corner)),
            "material": self._material(piece),
        }

    def _numbers(self, numbers: npt.NDArray[Any], *, bounded: bool = False) -> int:
        """Adds an accessor of vectors; `bounded`: with their smallest and largest values."""
        rows = np.ascontiguousarray(numbers.astype("<f4") + np.float32(0.0))
        record = {"componentType": _FLOAT, "count": len(rows), "type": f"VEC{rows.shape[1]}"}
        if bounded:
            record |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        return self._accessor(record, rows.tobytes(), _POINTS)

    def _indices(self, places: npt.NDArray[np.int64], count: int) -> int:
        kind, dtype = (_SHORT, "<u2") if count <= _MAX_SHORT else (_INT, "<u4")
        record = {"componentType": kind, "count": places.size, "type": "SCALAR"}
        return self._accessor(record, places.astype(dtype).tobytes(), _INDICES)

    def _accessor(self, record: dict[str, Any], data: bytes, target: int) -> int:
        self._accessors.append({"bufferView": self._view(data, target=target), **record})
        return len(self._accessors) - 1

    def _view(self, data: bytes, **more: int) -> int:
        start = sum(map(len, self._bytes))
        self._bytes.append(data + bytes(-len(data) % 4))
        self._views.append({"buffer": 0, "byteOffset": start, "byteLength": len(data), **more})
        return len(self._views) - 1

    def _material(self, piece: Piece) -> int:
        *rgb, alpha = piece.colour
        look: dict[str, Any] = {
            "baseColorFactor": [*map(linear, rgb), alpha],
            "metallicFactor": METALLIC,
            "roughnessFactor": ROUGHNESS,
        }
        if piece.image:
            look["baseColorTexture"] = {"index": self._image(piece.image)}
        record = {
            "pbrMetallicRoughness": look,
            **({"alphaMode": "BLEND"} if alpha < 1.0 else {}),
            # What is open is seen from behind.
            **({} if piece.surface.closed() else {"doubleSided": True}),
        }
        if record not in self._materials:
            self._materials.append(record)
        return self._materials.index(record)

    def _image(self, image: bytes) -> int:
        if image not in self._images:
            self._images.append(image)
            self._views_of_images.append(self._view(image))
        return self._images.index(image)


def _vertices(
    which: npt.NDArray[np.int64], texcoords: npt.NDArray[np.float32] | None
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[np.float32] | None]:
    """Merges corners with the same normal and (u, v) into vertices.

    Returns the first corner of each vertex (n,), the vertex of every corner (3 m,), and the (u, v) (n, 2) of
    the vertices from the upper left corner of the image.
    """
    if texcoords is None:
        # Normals are in the order of their first corners.
        _, first = np.unique(which, return_index=True)
        return first, which.ravel(), None
    keys = np.concatenate([which.reshape(-1, 1), texcoords.reshape(-1, 2)], axis=1)
    _, first, place = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    first, places = first[order], rank[place.ravel()]
    # An image of glTF begins at its upper left corner, a Surface's at its lower left.
    u, v = texcoords.reshape(-1, 2)[first].T
    return first, places, np.stack([u, 1 - v], axis=1)
