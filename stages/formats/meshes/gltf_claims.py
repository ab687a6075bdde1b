"""Checks the sizes that a glTF file claims against its content, before a library reads it.

An accessor without a buffer is any number of zeros, a stride of 1 makes 64 bytes of each byte, a node with
two parents counts twice, and reading a node that is its own child never ends.
"""

from collections.abc import Mapping, Sequence
from typing import Any
from urllib.parse import unquote

import orjson

from linkwright.stages.formats.damaged import Damaged
from linkwright.stages.formats.meshes.gltf import (
    MAX_STRIDE,
    MAX_VALUES,
    NUMBERS_OF_PRIMITIVE,
    chunks,
    natural,
    number_budget,
    value_count,
)

_COMPONENT_SIZES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
"""glTF's code of a type of numbers → its size [bytes]."""

_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
"""glTF's type of an element → the number of its numbers."""

_Record = Mapping[str, Any]


def check_claims(data: bytes, companions: Mapping[str, bytes]) -> None:
    """Raises Damaged, or another error for an unknown structure, if a file claims more than it contains.

    `companions`: the content of the files that it names, by their URIs.
    """
    text, chunk = chunks(data)
    if value_count(text) > MAX_VALUES:
        msg = "its JSON is larger than the limit"
        raise Damaged(msg)
    root = orjson.loads(text)
    lengths = [_length(record, len(chunk), companions) for record in root.get("buffers") or ()]
    views = root.get("bufferViews") or ()
    for index, view in enumerate(views):
        if natural(view, "byteOffset", 0) + natural(view, "byteLength") > lengths[natural(view, "buffer", 0)]:
            msg = f"view {index} reaches beyond its buffer"
            raise Damaged(msg)
    accessors = root.get("accessors") or ()
    for index, accessor in enumerate(accessors):
        _require_within(index, accessor, views, len(data))
    _require_tree(root.get("nodes") or (), root.get("scenes") or ())
    _require_few(root.get("nodes") or (), root.get("meshes") or (), accessors, number_budget(len(data)))


def _length(record: _Record, chunk: int, companions: Mapping[str, bytes]) -> int:
    """Returns the largest size of a buffer [bytes]; 0 if it is missing."""
    uri = record.get("uri")
    if uri is None:
        return chunk
    if uri.startswith("data:"):
        return len(uri) * 3 // 4
    return len(companions.get(uri) or companions.get(unquote(uri)) or b"")


def _require_within(index: int, accessor: _Record, views: Sequence[_Record], size: int) -> None:
    """Raises Damaged if an accessor reaches beyond its view, or has more zeros than a file of this size
    [bytes]."""
    count = natural(accessor, "count")
    element_size = _COMPONENT_SIZES[accessor["componentType"]] * _WIDTHS[accessor["type"]]
    if "bufferView" not in accessor:
        # All zeros, except the values that an extension or a list of exceptions gives.
        end, length = count * element_size, size
    else:
        view = views[natural(accessor, "bufferView")]
        stride = natural(view, "byteStride", 0) or element_size
        if not element_size <= stride <= MAX_STRIDE:
            msg = f"accessor {index} has a stride of {stride} bytes"
            raise Damaged(msg)
        start, length = natural(accessor, "byteOffset", 0), natural(view, "byteLength")
        end = start + ((count - 1) * stride + element_size if count else 0)
    if end > length:
        msg = f"accessor {index} has {count} elements of {element_size} bytes, which are not there"
        raise Damaged(msg)


def _require_tree(nodes: Sequence[_Record], scenes: Sequence[_Record]) -> None:
    """Raises Damaged if a node has two parents, or the root of a scene has a parent."""
    children = [child for node in nodes for child in node.get("children") or ()]
    roots = {root for scene in scenes for root in scene.get("nodes") or ()}
    if len(set(children)) < len(children) or roots.intersection(children):
        msg = "its nodes do not form a tree"
        raise Damaged(msg)


def _require_few(
    nodes: Sequence[_Record], meshes: Sequence[_Record], accessors: Sequence[_Record], budget: int
) -> None:
    """Raises Damaged if the meshes have more numbers than twice the `budget`: each mesh once, and again for
    each node that has it."""
    sizes = [
        sum(_numbers(primitive, accessors) for primitive in mesh.get("primitives") or ()) for mesh in meshes
    ]
    total = sum(sizes) + sum(sizes[natural(node, "mesh")] for node in nodes if "mesh" in node)
    if total > 2 * budget:
        msg = "its meshes are used too often"
        raise Damaged(msg)


def _numbers(primitive: _Record, accessors: Sequence[_Record]) -> int:
    """Returns the cost of a primitive: the numbers in its accessors, and a constant."""
    used_accessors = [
        *primitive.get("attributes", {}).values(),
        *([primitive["indices"]] if "indices" in primitive else []),
    ]
    records = [accessors[accessor] for accessor in used_accessors]
    return NUMBERS_OF_PRIMITIVE + sum(int(record["count"]) * _WIDTHS[record["type"]] for record in records)
