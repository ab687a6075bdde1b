"""The images of a glTF's materials. Needs no array library."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from linkwright.stages.formats.damaged import Damaged

MALFORMED = (AttributeError, IndexError, KeyError, TypeError, ValueError)
"""The errors for an unknown structure, and for base64 that is none."""

_MAGIC = b"glTF"
_FLOAT = 5126
_FIRST = "TEXCOORD_0"
_EMBEDDED = "data:"
_WHITE = [1.0, 1.0, 1.0, 1.0]
_MOST_VALUES = 1 << 23
"""Values in the JSON, by its brackets and commas."""

Content = bytes | str
"""What an image is, or the reason why it cannot be used."""

_Record = Mapping[str, Any]


def buffers(data: bytes) -> list[str]:
    """The names of the files that are a glTF's buffers."""
    tree = _root(data)
    return _files(lambda: [record.get("uri") for record in tree.get("buffers") or ()])


def images(data: bytes) -> list[str]:
    """The names of the files that give a glTF's materials their colours."""
    tree = _root(data)
    return _files(lambda: [tree["images"][index].get("uri") for _, index, _ in _uses(tree)])


def others(data: bytes) -> tuple[str, ...]:
    """The names of the images that give no material its colour, sorted."""
    tree = _root(data)
    try:
        used = {index for _, index, _ in _uses(tree)}
        every = enumerate(tree.get("images") or ())
        return tuple(sorted({_name(record) for index, record in every if index not in used}))
    except MALFORMED:
        return ()


def prepared(
    data: bytes, files: Mapping[str, bytes], images: Mapping[str, Content]
) -> tuple[bytes, dict[str, tuple[str, Content]]]:
    """A glTF whose materials are named by their numbers, without images and with the coordinates of its
    materials' colours first; and of each material with an image for its colour, by that name, the image's
    name in messages and its content, or the reason why that cannot be used.

    `files`, `images`: those that it names. As it is where it has no images. One of `MALFORMED`, or
    struct.error, where it cannot be read.
    """
    text, rest = _split(data)
    tree = json.loads(text)
    if not tree.get("images"):
        return data, {}
    contents: dict[int, Content] = {}
    found = {}
    for material, index, why in _uses(tree):
        record = tree["images"][index]
        if index not in contents:
            contents[index] = _image(tree, record, rest, files, images)
        found[material] = (_name(record), why or contents[index])
    for index, record in enumerate(tree.get("materials") or ()):
        record["name"] = str(index)
        if index in found:
            record["pbrMetallicRoughness"].setdefault("baseColorFactor", _WHITE)
    for mesh in tree.get("meshes") or ():
        for primitive in mesh.get("primitives") or ():
            if primitive.get("material") in found:
                _choose_coordinates(primitive["attributes"], tree, primitive["material"])
    del tree["images"]
    whole = json.dumps(tree).encode()
    whole = _packed(whole, rest) if data.startswith(_MAGIC) else whole
    return whole, {str(material): image for material, image in found.items()}


def _uses(tree: _Record) -> Iterator[tuple[int, int, str]]:
    """Each material with an image for its colour, the number of the image, and why it cannot be used."""
    count = len(tree.get("images") or ())
    for material, record in enumerate(tree.get("materials") or ()):
        try:
            use = record["pbrMetallicRoughness"]["baseColorTexture"]
            index = tree["textures"][use["index"]]["source"]
            moved = "KHR_texture_transform" in use.get("extensions", ())
        except MALFORMED:
            continue  # it has none, or one in a form that is not known
        if index in range(count):
            yield (
                material,
                index,
                "it is moved by KHR_texture_transform, which is not supported" if moved else "",
            )


def _image(
    tree: _Record, record: _Record, rest: bytes, files: Mapping[str, bytes], images: Mapping[str, Content]
) -> Content:
    try:
        uri = record.get("uri")
        if uri is not None:
            return (
                _decoded(uri)
                if uri.startswith(_EMBEDDED)
                else images.get(uri, "it is one of too many images")
            )
        view = tree["bufferViews"][record["bufferView"]]
        uri = tree["buffers"][view.get("buffer", 0)].get("uri")
        if uri is None:
            buffer = _chunk(rest)
        else:
            buffer = _decoded(uri) if uri.startswith(_EMBEDDED) else files[uri]
        first = view.get("byteOffset", 0)
        return buffer[first : first + view["byteLength"]]
    except MALFORMED:
        return "it is damaged"


def _files(uris: Callable[[], list[Any]]) -> list[str]:
    """The names of files among URIs; none where the structure is unknown."""
    try:
        return [uri for uri in uris() if isinstance(uri, str) and not uri.startswith(_EMBEDDED)]
    except MALFORMED:
        return []


def _decoded(uri: str) -> bytes:
    head, _, content = uri.partition(",")
    if not head.endswith(";base64"):
        msg = "it is not base64"
        raise Damaged(msg)
    return base64.b64decode(content, validate=True)


def _name(record: _Record) -> str:
    uri = str(record.get("uri") or "")
    if uri and not uri.startswith(_EMBEDDED):
        return uri
    return str(record.get("name") or "an image in it")


def _choose_coordinates(attributes: dict[str, Any], tree: _Record, material: int) -> None:
    """Makes the coordinates that a material's colour uses the first ones; none where they are not floats."""
    use = tree["materials"][material]["pbrMetallicRoughness"]["baseColorTexture"]
    accessor = attributes.get(f"TEXCOORD_{use.get('texCoord', 0)}")
    if accessor is not None and tree["accessors"][accessor]["componentType"] == _FLOAT:
        attributes[_FIRST] = accessor
    else:
        attributes.pop(_FIRST, None)


def _root(data: bytes) -> dict[str, Any]:
    """The JSON of a glTF or GLB; {} where it has none, or more than is read."""
    try:
        text, _ = _split(data)
        if sum(map(text.count, (b",", b"[", b"{"))) > _MOST_VALUES:
            return {}
        found = json.loads(text)
    except (struct.error, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def _split(data: bytes) -> tuple[bytes, bytes]:
    """The JSON of a file, and what comes after it in a GLB."""
    if not data.startswith(_MAGIC):
        return data, b""
    (length,) = struct.unpack_from("<I", data, 12)
    return data[20 : 20 + length], data[20 + length :]


def _chunk(rest: bytes) -> bytes:
    """The content of the chunk that `rest` begins with; empty where there is none."""
    return rest[8 : 8 + int.from_bytes(rest[:4], "little")]


def _packed(text: bytes, rest: bytes) -> bytes:
    """A GLB of JSON and what comes after it."""
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sII", _MAGIC, 2, 20 + len(text) + len(rest))
    return head + struct.pack("<I4s", len(text), b"JSON") + text + rest
