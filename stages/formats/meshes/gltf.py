"""Triangles out of glTF 2 files, binary or as JSON with their buffers in them.

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

from linkwright.stages.formats.colours import NEUTRAL
from linkwright.stages.formats.damaged import Damaged
from linkwright.stages.robot.errors import ProtocolError
from linkwright.stages.robot.model.geometry import Colour

MAGIC = b"glTF"

_JSON, _BIN = 0x4E4F534A, 0x004E4942
_KINDS = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC3": 3}
_TRIANGLES = 4
_DEEPEST = 64
MOST_VALUES = 1 << 23
"""Values in the JSON, by its brackets and commas; base64 has none of these."""

_MOST_NUMBERS = 1 << 26
_FREE_NUMBERS, _NUMBERS_A_BYTE = 1 << 22, 64
"""Of points and indices in all nodes: meshes may be used several times, but a file that comes to more
than 4 million of them comes to no more than 64 for each of its bytes."""

_PRIMITIVE = 256
"""What a primitive counts beside its numbers: it takes time, however few it has."""

_MOST_NODES = 1 << 16
LARGEST_STRIDE = 252
_HINT = "run the same command again; if it fails each time, the API has changed"

_Array = npt.NDArray[np.float64]
_Record = Mapping[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """A node with triangles: `points` (n, 3) in the scene's frame [m]; `corners` (m, 3) index them.

    `colours`, and `which` (m,): each triangle's index in them.
    """

    name: str
    points: _Array
    corners: npt.NDArray[np.int64]
    colours: tuple[Colour, ...]
    which: npt.NDArray[np.int64]


def read(reply: bytes) -> list[Node]:
    """The nodes of a glTF file that have triangles; ProtocolError where it is malformed."""
    try:
        return list(_GltfFile(reply).nodes())
    except (
        AttributeError,
        IndexError,
        KeyError,
        TypeError,
        ValueError,  # those of base64 and of JSON too
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
        if values(text) > MOST_VALUES:
            msg = "its JSON is larger than the limit"
            raise ValueError(msg)
        self._room = room(len(data))
        self._json = orjson.loads(text)
        needed = self._json.get("extensionsRequired")
        if needed:
            msg = f"it needs the extensions {', '.join(map(str, needed))}"
            raise ValueError(msg)
        self._buffers = [self._buffer(record) for record in self._json.get("buffers") or ()]

    def nodes(self) -> Iterator[Node]:
        """The nodes with meshes of the scene, in its order, each placed in the scene's frame."""
        scenes, nodes = self._json.get("scenes") or (), self._json.get("nodes") or ()
        if scenes:
            roots = scenes[self._json.get("scene", 0)].get("nodes") or ()
        else:
            inner = {child for record in nodes for child in record.get("children") or ()}
            roots = [index for index in range(len(nodes)) if index not in inner]
        waiting = [(index, np.eye(4), 0) for index in reversed(roots)]
        met: set[int] = set()
        while waiting:
            index, parent, depth = waiting.pop()
            if depth > _DEEPEST:
                msg = "its nodes are nested too deeply"
                raise ValueError(msg)
            if len(met) > _MOST_NODES:
                msg = f"it has more than {_MOST_NODES} nodes"
                raise ValueError(msg)
            if index in met:
                msg = f"node {index} has two parents"
                raise ValueError(msg)
            met.add(index)
            record = nodes[index]
            transform = parent @ _local(record)
            if "mesh" in record:
                yield self._node(record, transform)
            children = record.get("children") or ()
            waiting += [(child, transform, depth + 1) for child in reversed(children)]

    def _node(self, record: _Record, transform: _Array) -> Node:
        mesh = self._json["meshes"][record["mesh"]]
        points, corners, which = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], []
        colours: list[Colour] = []
        known = 0
        for primitive in mesh["primitives"]:
            mode = primitive.get("mode", _TRIANGLES)
            if mode < _TRIANGLES:  # points and lines
                continue
            if mode > _TRIANGLES:
                msg = "it has strips or fans of triangles"
                raise ValueError(msg)
            positions = self._accessor(primitive["attributes"]["POSITION"], "VEC3")
            self._take(positions.size + _PRIMITIVE)
            own = positions.astype(np.float64)
            if "indices" in primitive:
                indices = self._accessor(primitive["indices"], "SCALAR")
                self._take(indices.size)
                index = indices.astype(np.int64).ravel()
            else:
                self._take(len(own))
                index = np.arange(len(own), dtype=np.int64)
            if len(index) and not 0 <= index.min() <= index.max() < len(own):
                msg = f"an index lies outside of the {len(own)} points"
                raise IndexError(msg)
            points.append(own @ transform[:3, :3].T + transform[:3, 3])
            corners.append(index.reshape(-1, 3) + known)
            which.append(np.full(len(index) // 3, len(colours), dtype=np.int64))
            colours.append(self._colour(primitive))
            known += len(own)
        placed, turned = np.concatenate(points), np.concatenate(corners)
        if not np.isfinite(placed).all():
            msg = "a coordinate is not a finite number"
            raise ValueError(msg)
        if np.linalg.det(transform[:3, :3]) < 0:
            turned = turned[:, ::-1]
        faces = np.concatenate(which) if which else np.empty(0, dtype=np.int64)
        return Node(str(record.get("name", "")), placed, turned, tuple(colours), faces)

    def _colour(self, primitive: _Record) -> Colour:
        if "material" not in primitive:
            return NEUTRAL
        record = self._json["materials"][primitive["material"]].get("pbrMetallicRoughness") or {}
        red, green, blue, alpha = record.get("baseColorFactor") or (1.0, 1.0, 1.0, 1.0)
        return (_shown(red), _shown(green), _shown(blue), round(min(max(float(alpha), 0.0), 1.0), 6))

    def _take(self, numbers: int) -> None:
        """ValueError where so many more numbers exceed the limit for a file of this size."""
        self._room -= numbers
        if self._room < 0:
            msg = "its meshes are used too often"
            raise ValueError(msg)

    def _accessor(self, index: int, kind: str) -> npt.NDArray[Any]:
        """(count, 1 or 3) numbers."""
        record = self._json["accessors"][index]
        if record["type"] != kind or "sparse" in record or "bufferView" not in record:
            msg = f"accessor {index} is not a plain {kind}"
            raise ValueError(msg)
        view = self._json["bufferViews"][record["bufferView"]]
        dtype, count = np.dtype(_KINDS[record["componentType"]]), natural(record, "count")
        width = _WIDTHS[kind]
        each = width * dtype.itemsize
        stride = natural(view, "byteStride", 0) or each
        if not each <= stride <= LARGEST_STRIDE:
            msg = f"accessor {index} has a stride of {stride} bytes"
            raise ValueError(msg)
        buffer = self._buffers[natural(view, "buffer", 0)]
        first, inside = natural(view, "byteOffset", 0), natural(record, "byteOffset", 0)
        length = natural(view, "byteLength")
        end = inside + ((count - 1) * stride + each if count else 0)
        if end > length or first + length > len(buffer):
            msg = f"accessor {index} reaches beyond the {len(buffer)} bytes of its buffer"
            raise IndexError(msg)
        return np.ndarray((count, width), dtype, buffer, first + inside, (stride, dtype.itemsize))

    def _buffer(self, record: _Record) -> bytes:
        uri = record.get("uri")
        if uri is None:
            return self._chunk
        head, comma, content = str(uri).partition(",")
        if not head.startswith("data:") or not head.endswith(";base64") or not comma:
            msg = "a buffer lies outside of the file"
            raise ValueError(msg)
        return base64.b64decode(content, validate=True)


def room(size: int) -> int:
    """How many numbers of points and indices the nodes of a file of this size [bytes] may come to."""
    return min(max(_FREE_NUMBERS, _NUMBERS_A_BYTE * size), _MOST_NUMBERS)


def values(text: bytes) -> int:
    """How many values a JSON text has, about, without reading it."""
    return sum(map(text.count, (b",", b"[", b"{")))


def natural(record: _Record, key: str, default: int | None = None) -> int:
    """A number that counts something; KeyError where it is missing, Damaged for anything else."""
    value = record[key] if default is None else record.get(key, default)
    if type(value) is not int or value < 0:
        msg = f"{key} is not a whole number of at least 0"
        raise Damaged(msg)
    return value


def chunks(data: bytes) -> tuple[bytes, bytes]:
    """The JSON of a file and its binary chunk (empty where it has none)."""
    if not data.startswith(MAGIC):
        return data, b""
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2 or length != len(data):
        msg = f"it is of version {version} and has {len(data)} bytes where {length} are announced"
        raise ValueError(msg)
    found: dict[int, bytes] = {}
    at = 12
    while at < length:
        size, kind = struct.unpack_from("<II", data, at)
        at += 8
        if at + size > length:
            msg = "a chunk was cut short"
            raise ValueError(msg)
        found.setdefault(kind, data[at : at + size])
        at += size
    return found[_JSON], found.get(_BIN, b"")


def _local(record: _Record) -> _Array:
    """The transform (4, 4) of a node in its parent: a matrix by columns, or parts."""
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


def _shown(linear: float) -> float:
    """A channel as screens show it (sRGB) of one in linear light, as glTF has it."""
    value = min(max(float(linear), 0.0), 1.0)
    return round(12.92 * value if value <= 0.0031308 else 1.055 * value ** (1 / 2.4) - 0.055, 6)
