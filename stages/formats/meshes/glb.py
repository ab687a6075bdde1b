"""Writes GLB files (binary glTF 2) that show a link, and reads the coloured triangles of glTF files.

A written file has a mesh with a primitive for each piece of the link, and its images. Lengths are in metres;
the same pieces always give the same bytes.
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
from linkwright.stages.formats.meshes.gltf_conventions import GENERATOR, linear_from_srgb
from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.robot.model.geometry import Colour

ROUGHNESS, METALLIC = 0.5, 0.0
"""The roughness and the metallic factor of every piece, since CAD's appearances have neither. Metal would be
black in a viewer without surroundings to reflect."""

UpAxis = Literal["z", "y"]
"""The axis of the scene along which the link's z axis points. z: the scene's frame is the link's; y: as in
glTF's standard, by a turn of the only node."""

_JSON_CHUNK, _BINARY_CHUNK = 0x4E4F534A, 0x004E4942
"""The types of a GLB's chunks."""

_HEADER_SIZE = 12
"""Size of a GLB's header [bytes]."""

_GLB_VERSION = 2
"""Version of the container, which the header names."""

_FLOAT_TYPE, _SHORT_TYPE, _INT_TYPE = 5126, 5123, 5125
"""glTF's codes of the types of numbers: float32, uint16 and uint32."""

_VERTEX_TARGET, _INDEX_TARGET = 34962, 34963
"""glTF's codes of the uses of a buffer view."""

_MAX_SHORT_VERTICES = 0xFFFF
"""Largest number of vertices whose indices have 16 bits: the index 0xFFFF itself is reserved."""

_Y_UP_FROM_Z_UP = (-(0.5**0.5), 0.0, 0.0, 0.5**0.5)
"""The turn by −90° about x, as a quaternion (x, y, z, w)."""


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A surface of a single colour or image."""

    surface: Surface
    colour: Colour
    image: bytes = b""
    """A PNG whose colours are multiplied by `colour`; b"" without an image."""


def write(pieces: Sequence[Piece], up_axis: UpAxis = "z") -> bytes:
    """Returns the content of a GLB file with the pieces of a link."""
    return _GlbFile().content(pieces, up_axis)


def coloured_triangles(data: bytes) -> list[tuple[npt.NDArray[np.float64], Colour]]:
    """Returns (corners (m, 3, 3) of triangles, their colour) for each colour of each node in a glTF file;
    images are not read. Raises ProtocolError if the file is malformed."""
    return [
        (node.points[node.corners[node.which == index]], colour)
        for node in gltf.read(data)
        for index, colour in enumerate(node.colours)
    ]


class _GlbFile:
    """The arrays of a file while it is written, and the content of its buffer."""

    def __init__(self) -> None:
        self._buffer: list[bytes] = []
        self._views: list[dict[str, Any]] = []
        self._accessors: list[dict[str, Any]] = []
        self._materials: list[dict[str, Any]] = []
        self._images: list[bytes] = []
        self._image_views: list[int] = []
        """The index of the buffer view of each image."""

    def content(self, pieces: Sequence[Piece], up_axis: UpAxis) -> bytes:
        """Returns the content of the file."""
        primitives = [self._add_primitive(piece) for piece in pieces]
        node = {"name": "visual", "mesh": 0, **({"rotation": _Y_UP_FROM_Z_UP} if up_axis == "y" else {})}
        images = [{"bufferView": view, "mimeType": "image/png"} for view in self._image_views]
        buffer = b"".join(self._buffer)
        document = {
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
            "buffers": [{"byteLength": len(buffer)}],
        }
        # The standard forbids empty lists.
        json_bytes = orjson.dumps({key: value for key, value in document.items() if value != []})
        # Chunks end at a multiple of four bytes.
        json_bytes += b" " * (-len(json_bytes) % 4)
        chunks = _chunk(_JSON_CHUNK, json_bytes) + _chunk(_BINARY_CHUNK, buffer)
        return b"glTF" + struct.pack("<II", _GLB_VERSION, _HEADER_SIZE + len(chunks)) + chunks

    def _add_primitive(self, piece: Piece) -> dict[str, Any]:
        """Adds the arrays and the material of a piece, and returns its primitive."""
        surface = piece.surface
        normal_indices, normals = corner_normals(surface)
        first_corners, corner_vertices, texcoords = _merge_corners(
            normal_indices, surface.texcoords if piece.image else None
        )
        points = surface.vertices[surface.triangles.ravel()[first_corners]]
        attributes = {
            "POSITION": self._add_vectors(points, with_bounds=True),
            "NORMAL": self._add_vectors(normals[normal_indices.ravel()[first_corners]]),
        }
        if texcoords is not None:
            attributes["TEXCOORD_0"] = self._add_vectors(texcoords)
        return {
            "attributes": attributes,
            "indices": self._add_indices(corner_vertices, len(first_corners)),
            "material": self._add_material(piece),
        }

    def _add_vectors(self, vectors: npt.NDArray[Any], *, with_bounds: bool = False) -> int:
        """Adds an accessor of vectors (n, 2) or (n, 3), and returns its index. `with_bounds`: the accessor
        has their smallest and largest entries, which glTF requires of points."""
        # + 0 makes −0 a 0.
        rows = np.ascontiguousarray(vectors.astype("<f4") + np.float32(0.0))
        accessor = {"componentType": _FLOAT_TYPE, "count": len(rows), "type": f"VEC{rows.shape[1]}"}
        if with_bounds:
            accessor |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        return self._add_accessor(accessor, rows.tobytes(), _VERTEX_TARGET)

    def _add_indices(self, indices: npt.NDArray[np.int64], vertex_count: int) -> int:
        """Adds an accessor of indices into the vertices, and returns its own index."""
        is_short = vertex_count <= _MAX_SHORT_VERTICES
        number_type, dtype = (_SHORT_TYPE, "<u2") if is_short else (_INT_TYPE, "<u4")
        accessor = {"componentType": number_type, "count": indices.size, "type": "SCALAR"}
        return self._add_accessor(accessor, indices.astype(dtype).tobytes(), _INDEX_TARGET)

    def _add_accessor(self, accessor: dict[str, Any], data: bytes, target: int) -> int:
        """Adds data, its view and its accessor; returns the accessor's index. `target`: the view's use."""
        self._accessors.append({"bufferView": self._add_view(data, target=target), **accessor})
        return len(self._accessors) - 1

    def _add_view(self, data: bytes, **more: int) -> int:
        """Adds data to the buffer, and returns the index of its view. `more`: other keys of the view."""
        offset = sum(map(len, self._buffer))
        self._buffer.append(data + bytes(-len(data) % 4))
        self._views.append({"buffer": 0, "byteOffset": offset, "byteLength": len(data), **more})
        return len(self._views) - 1

    def _add_material(self, piece: Piece) -> int:
        """Returns the index of a piece's material, which is added if no earlier piece has the same."""
        *rgb, alpha = piece.colour
        appearance: dict[str, Any] = {
            "baseColorFactor": [*map(linear_from_srgb, rgb), alpha],
            "metallicFactor": METALLIC,
            "roughnessFactor": ROUGHNESS,
        }
        if piece.image:
            appearance["baseColorTexture"] = {"index": self._add_image(piece.image)}
        material = {
            "pbrMetallicRoughness": appearance,
            **({"alphaMode": "BLEND"} if alpha < 1.0 else {}),
            # Triangles of an open surface can be seen from behind.
            **({} if piece.surface.is_closed() else {"doubleSided": True}),
        }
        if material not in self._materials:
            self._materials.append(material)
        return self._materials.index(material)

    def _add_image(self, image: bytes) -> int:
        """Returns the index of an image, which is added if the file does not have it yet."""
        if image not in self._images:
            self._images.append(image)
            self._image_views.append(self._add_view(image))
        return self._images.index(image)


def _chunk(chunk_type: int, content: bytes) -> bytes:
    return struct.pack("<II", len(content), chunk_type) + content


def _merge_corners(
    normal_indices: npt.NDArray[np.int64], texcoords: npt.NDArray[np.float32] | None
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[np.float32] | None]:
    """Merges corners of triangles with the same normal and (u, v) into vertices. Corners with the same normal
    are at the same point.

    `normal_indices`: the index of each corner's normal (m, 3); `texcoords`: each corner's (u, v) (m, 3, 2).
    Returns the first corner of each vertex (n,), the vertex of each corner (3 m,), and the vertices' (u, v)
    (n, 2), counted from the upper left corner of the image. Vertices are in the order of their first corners.
    """
    if texcoords is None:
        # Normals are numbered in the order of their first corners already.
        _, first_corners = np.unique(normal_indices, return_index=True)
        return first_corners, normal_indices.ravel(), None
    keys = np.concatenate([normal_indices.reshape(-1, 1), texcoords.reshape(-1, 2)], axis=1)
    _, first_corners, key_indices = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    # `np.unique` sorts by key.
    order = np.argsort(first_corners)
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    first_corners, corner_vertices = first_corners[order], rank[key_indices.ravel()]
    # In glTF v is measured from the top of the image, in a Surface from the bottom.
    u, v = texcoords.reshape(-1, 2)[first_corners].T
    return first_corners, corner_vertices, np.stack([u, 1 - v], axis=1)
