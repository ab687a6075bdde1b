"""Reads triangles from glTF 2 files, binary or as JSON with their buffers in them.

A few bytes of such a file can claim any size, so every count, stride and offset is checked against the file's
content before it is used. Images are not read.
"""

import base64
import binascii
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import orjson

from linkwright.stages.formats.damaged import Damaged
from linkwright.stages.formats.meshes.gltf_conventions import is_own, srgb_from_linear
from linkwright.stages.robot.errors import ProtocolError
from linkwright.stages.robot.model.geometry import NEUTRAL, Colour

MAGIC = b"glTF"

_JSON_CHUNK, _BINARY_CHUNK = 0x4E4F534A, 0x004E4942
"""The types of a GLB's chunks."""

_DTYPES = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
"""glTF's code of a type of numbers → NumPy's."""

_WIDTHS = {"SCALAR": 1, "VEC3": 3}
"""glTF's type of an element → the number of its numbers."""

_TRIANGLES = 4
"""glTF's code of a primitive that is a list of triangles: those below are points and lines, those above are
strips and fans."""

_MAX_DEPTH = 64
"""Largest depth of nested nodes."""

MAX_VALUES = 1 << 23
"""Largest number of values in the JSON, by its brackets and commas; base64 has none of these."""

_MAX_NUMBERS = 1 << 26
"""Largest number of coordinates and indices in all nodes of any file."""

_FREE_NUMBERS, _NUMBERS_PER_BYTE = 1 << 22, 64
"""Limits of the coordinates and indices in all nodes. Meshes may be used several times, but beyond 4 million
numbers a file may have at most 64 for each of its bytes."""

NUMBERS_OF_PRIMITIVE = 256
"""Numbers that a primitive counts as besides its own: it takes time, even with few numbers."""

_MAX_NODES = 1 << 16
"""Largest number of nodes of a scene."""

MAX_STRIDE = 252
"""Largest stride of a buffer that glTF allows [bytes]."""

_HINT = "run the same command again; if it fails each time, the API has changed"

_Array = npt.NDArray[np.float64]
_Record = Mapping[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """A node with triangles."""

    name: str
    points: _Array
    """(n, 3) in the scene's frame [m]."""

    corners: npt.NDArray[np.int64]
    """(m, 3), indices into `points`."""

    colours: tuple[Colour, ...]
    """The colour of each primitive, in sRGB."""

    which: npt.NDArray[np.int64]
    """(m,), each triangle's index in `colours`."""


def read(reply: bytes) -> list[Node]:
    """Returns the nodes of a glTF file that have triangles. Raises ProtocolError if it is malformed."""
    try:
        return list(_GltfFile(reply).nodes())
    except (
        AttributeError,
        IndexError,
        KeyError,
        TypeError,
        ValueError,  # also errors of JSON and Damaged
        OverflowError,
        RecursionError,
        struct.error,
        binascii.Error,
    ) as error:
        msg = f"the reply with triangles is not in the form of glTF 2 ({type(error).__name__}: {error})"
        raise ProtocolError(msg, hint=_HINT) from None


class _GltfFile:
    """A glTF 2 file, binary or as JSON with its buffers in it."""

    def __init__(self, data: bytes) -> None:
        text, self._chunk = chunks(data)
        if value_count(text) > MAX_VALUES:
            msg = "its JSON is larger than the limit"
            raise ValueError(msg)
        self._numbers_left = number_budget(len(data))
        self._json = orjson.loads(text)
        extensions = self._json.get("extensionsRequired")
        if extensions:
            msg = f"it needs the extensions {', '.join(map(str, extensions))}"
            raise ValueError(msg)
        self._buffers = [self._buffer(record) for record in self._json.get("buffers") or ()]

    def nodes(self) -> Iterator[Node]:
        """Yields the nodes with meshes of the scene, in order, each placed in the scene's frame; in a file of
        ours, in the frame of its link."""
        scenes, nodes = self._json.get("scenes") or (), self._json.get("nodes") or ()
        if scenes:
            roots = scenes[self._json.get("scene", 0)].get("nodes") or ()
        else:
            inner = {child for record in nodes for child in record.get("children") or ()}
            roots = [index for index in range(len(nodes)) if index not in inner]
        waiting = [(index, np.eye(4), 0) for index in reversed(roots)]
        visited: set[int] = set()
        while waiting:
            index, parent, depth = waiting.pop()
            if depth > _MAX_DEPTH:
                msg = "its nodes are nested too deeply"
                raise ValueError(msg)
            if len(visited) > _MAX_NODES:
                msg = f"it has more than {_MAX_NODES} nodes"
                raise ValueError(msg)
            if index in visited:
                msg = f"node {index} has two parents"
                raise ValueError(msg)
            visited.add(index)
            record = nodes[index]
            # The node of a file of ours only turns the link's frame into glTF's.
            transform = parent if is_own(self._json) else parent @ _parent_from_node(record)
            if "mesh" in record:
                yield self._node(record, transform)
            children = record.get("children") or ()
            waiting += [(child, transform, depth + 1) for child in reversed(children)]

    def _node(self, record: _Record, transform: _Array) -> Node:
        """Returns the triangles of a node; `transform`: scene_from_node (4, 4)."""
        mesh = self._json["meshes"][record["mesh"]]
        points, corners, which = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], []
        colours: list[Colour] = []
        point_count = 0
        for primitive in mesh["primitives"]:
            mode = primitive.get("mode", _TRIANGLES)
            if mode < _TRIANGLES:
                continue
            if mode > _TRIANGLES:
                msg = "it has strips or fans of triangles"
                raise ValueError(msg)
            positions = self._accessor(primitive["attributes"]["POSITION"], "VEC3")
            self._spend(positions.size + NUMBERS_OF_PRIMITIVE)
            local_points = positions.astype(np.float64)
            if "indices" in primitive:
                indices = self._accessor(primitive["indices"], "SCALAR")
                self._spend(indices.size)
                index = indices.astype(np.int64).ravel()
            else:
                self._spend(len(local_points))
                index = np.arange(len(local_points), dtype=np.int64)
            if len(index) and not 0 <= index.min() <= index.max() < len(local_points):
                msg = f"an index lies outside of the {len(local_points)} points"
                raise IndexError(msg)
            points.append(local_points @ transform[:3, :3].T + transform[:3, 3])
            corners.append(index.reshape(-1, 3) + point_count)
            which.append(np.full(len(index) // 3, len(colours), dtype=np.int64))
            colours.append(self._colour(primitive))
            point_count += len(local_points)
        node_points, node_corners = np.concatenate(points), np.concatenate(corners)
        if not np.isfinite(node_points).all():
            msg = "a coordinate is not a finite number"
            raise ValueError(msg)
        # A reflection turns the triangles inside out.
        if np.linalg.det(transform[:3, :3]) < 0:
            node_corners = node_corners[:, ::-1]
        faces = np.concatenate(which) if which else np.empty(0, dtype=np.int64)
        return Node(str(record.get("name", "")), node_points, node_corners, tuple(colours), faces)

    def _colour(self, primitive: _Record) -> Colour:
        """Returns the colour of a primitive's material: white if it has none, grey without a material."""
        if "material" not in primitive:
            return NEUTRAL
        record = self._json["materials"][primitive["material"]].get("pbrMetallicRoughness") or {}
        red, green, blue, alpha = record.get("baseColorFactor") or (1.0, 1.0, 1.0, 1.0)
        opacity = round(min(max(float(alpha), 0.0), 1.0), 6)
        return (srgb_from_linear(red), srgb_from_linear(green), srgb_from_linear(blue), opacity)

    def _spend(self, numbers: int) -> None:
        """Counts further numbers. Raises ValueError if they exceed the limit for a file of this size."""
        self._numbers_left -= numbers
        if self._numbers_left < 0:
            msg = "its meshes are used too often"
            raise ValueError(msg)

    def _accessor(self, index: int, kind: str) -> npt.NDArray[Any]:
        """Returns the numbers (count, 1 or 3) of an accessor, as a view of its buffer. Raises ValueError if
        the accessor is sparse or of another type, IndexError if it reaches beyond its buffer."""
        record = self._json["accessors"][index]
        if record["type"] != kind or "sparse" in record or "bufferView" not in record:
            msg = f"accessor {index} is not a plain {kind}"
            raise ValueError(msg)
        view = self._json["bufferViews"][record["bufferView"]]
        dtype, count = np.dtype(_DTYPES[record["componentType"]]), natural(record, "count")
        width = _WIDTHS[kind]
        element_size = width * dtype.itemsize
        stride = natural(view, "byteStride", 0) or element_size
        if not element_size <= stride <= MAX_STRIDE:
            msg = f"accessor {index} has a stride of {stride} bytes"
            raise ValueError(msg)
        buffer = self._buffers[natural(view, "buffer", 0)]
        first, inside = natural(view, "byteOffset", 0), natural(record, "byteOffset", 0)
        length = natural(view, "byteLength")
        end = inside + ((count - 1) * stride + element_size if count else 0)
        if end > length or first + length > len(buffer):
            msg = f"accessor {index} reaches beyond the {len(buffer)} bytes of its buffer"
            raise IndexError(msg)
        return np.ndarray((count, width), dtype, buffer, first + inside, (stride, dtype.itemsize))

    def _buffer(self, record: _Record) -> bytes:
        """Returns the content of a buffer: the binary chunk, or the base64 in its URI."""
        uri = record.get("uri")
        if uri is None:
            return self._chunk
        head, comma, content = str(uri).partition(",")
        if not head.startswith("data:") or not head.endswith(";base64") or not comma:
            msg = "a buffer lies outside of the file"
            raise ValueError(msg)
        return base64.b64decode(content, validate=True)


def number_budget(size: int) -> int:
    """Returns the largest number of coordinates and indices in all nodes of a file of this size [bytes]."""
    return min(max(_FREE_NUMBERS, _NUMBERS_PER_BYTE * size), _MAX_NUMBERS)


def value_count(text: bytes) -> int:
    """Estimates the number of values of a JSON text, without parsing it."""
    return sum(map(text.count, (b",", b"[", b"{")))


def natural(record: _Record, key: str, default: int | None = None) -> int:
    """Returns a number that counts something. Raises KeyError if it is missing, Damaged for anything else."""
    value = record[key] if default is None else record.get(key, default)
    if type(value) is not int or value < 0:
        msg = f"{key} is not a whole number of at least 0"
        raise Damaged(msg)
    return value


def chunks(data: bytes) -> tuple[bytes, bytes]:
    """Returns the JSON of a file and its binary chunk (empty if it has none). Raises ValueError, KeyError or
    struct.error for a malformed GLB."""
    if not data.startswith(MAGIC):
        return data, b""
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2 or length != len(data):
        msg = f"it is of version {version} and has {len(data)} bytes where {length} are announced"
        raise ValueError(msg)
    chunk_by_kind: dict[int, bytes] = {}
    at = 12
    while at < length:
        size, kind = struct.unpack_from("<II", data, at)
        at += 8
        if at + size > length:
            msg = "a chunk was cut short"
            raise ValueError(msg)
        chunk_by_kind.setdefault(kind, data[at : at + size])
        at += size
    return chunk_by_kind[_JSON_CHUNK], chunk_by_kind.get(_BINARY_CHUNK, b"")


def _parent_from_node(record: _Record) -> _Array:
    """Returns the transform (4, 4) of a node in its parent: from a matrix by columns, or from translation,
    rotation and scale."""
    if "matrix" in record:
        return np.array(record["matrix"], dtype=np.float64).reshape(4, 4).T
    transform = np.eye(4)
    x, y, z, w = record.get("rotation") or (0.0, 0.0, 0.0, 1.0)
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    transform[:3, :3] = turn * np.array(record.get("scale") or (1.0, 1.0, 1.0))
    transform[:3, 3] = record.get("translation") or (0.0, 0.0, 0.0)
    return transform
