"""Reads the images of a glTF's materials, without an array library."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from linkwright.stages.formats.damaged import Damaged
from linkwright.stages.formats.meshes.gltf_conventions import is_own, srgb_from_linear

MALFORMED = (AttributeError, IndexError, KeyError, TypeError, ValueError)
"""The errors that an unknown structure or invalid base64 causes."""

_MAGIC = b"glTF"
_FLOAT = 5126
_FIRST_COORDINATES = "TEXCOORD_0"
_EMBEDDED = "data:"
_WHITE = [1.0, 1.0, 1.0, 1.0]
_MAX_VALUES = 1 << 23
"""Largest number of values in the JSON, counted by its brackets and commas."""

Content = bytes | str
"""The content of an image, or the reason why it cannot be used."""

_Record = Mapping[str, Any]


def buffers(data: bytes) -> list[str]:
    """Returns the names of the files that are a glTF's buffers."""
    tree = _root(data)
    return _files(lambda: [record.get("uri") for record in tree.get("buffers") or ()])


def images(data: bytes) -> list[str]:
    """Returns the names of the files that give a glTF's materials their colours."""
    tree = _root(data)
    return _files(lambda: [tree["images"][index].get("uri") for _, index, _ in _uses(tree)])


def unused_images(data: bytes) -> tuple[str, ...]:
    """Returns the names of the images that give no material its colour, sorted."""
    tree = _root(data)
    try:
        used_indices = {index for _, index, _ in _uses(tree)}
        numbered = enumerate(tree.get("images") or ())
        return tuple(sorted({_name(record) for index, record in numbered if index not in used_indices}))
    except MALFORMED:
        return ()


def prepare(
    data: bytes, files: Mapping[str, bytes], images: Mapping[str, Content]
) -> tuple[bytes, dict[str, tuple[str, Content]]]:
    """Returns a glTF that is ready for the mesh library, and the images of its materials.

    In the glTF, materials are named by their numbers and have their colours as screens show them; images are
    removed, and the texture coordinates of each material's colour come first. The second value maps the name
    of each material with a colour image to the image's name in messages, and its content or the reason why it
    cannot be used. A GLB that Linkwright wrote is in the frame of its link, so the rotation of its up axis is
    removed.

    `files`, `images`: the buffers and images that the glTF names. Raises one of `MALFORMED`, or struct.error,
    if it cannot be read.
    """
    text, binary_part = _split(data)
    tree = json.loads(text)
    for node in tree["nodes"] if is_own(tree) else ():
        node.pop("rotation", None)
    contents: dict[int, Content] = {}
    image_of_material = {}
    for material, index, why in _uses(tree):
        record = tree["images"][index]
        if index not in contents:
            contents[index] = _image(tree, record, binary_part, files, images)
        image_of_material[material] = (_name(record), why or contents[index])
    for index, record in enumerate(tree.get("materials") or ()):
        record["name"] = str(index)
        material_colour = record.get("pbrMetallicRoughness") or {}
        if index in image_of_material:
            material_colour.setdefault("baseColorFactor", _WHITE)
        if "baseColorFactor" in material_colour:
            *rgb, alpha = material_colour["baseColorFactor"]
            material_colour["baseColorFactor"] = [*map(srgb_from_linear, rgb), alpha]
    for mesh in tree.get("meshes") or ():
        for primitive in mesh.get("primitives") or ():
            if primitive.get("material") in image_of_material:
                _choose_coordinates(primitive["attributes"], tree, primitive["material"])
    tree.pop("images", None)
    content = json.dumps(tree).encode()
    content = _packed(content, binary_part) if data.startswith(_MAGIC) else content
    return content, {str(material): image for material, image in image_of_material.items()}


def _uses(tree: _Record) -> Iterator[tuple[int, int, str]]:
    """Yields each material with a colour image, the number of the image, and why it cannot be used."""
    count = len(tree.get("images") or ())
    for material, record in enumerate(tree.get("materials") or ()):
        try:
            use = record["pbrMetallicRoughness"]["baseColorTexture"]
            index = tree["textures"][use["index"]]["source"]
            has_transform = "KHR_texture_transform" in use.get("extensions", ())
        except MALFORMED:
            continue  # it has no image, or the image has an unknown form
        if index in range(count):
            yield (
                material,
                index,
                "it is moved by KHR_texture_transform, which is not supported" if has_transform else "",
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
    """Returns the names of files among URIs; none if the structure is unknown."""
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
    """Moves the coordinates that a material's colour uses to the front; removes them if they are not
    floats."""
    use = tree["materials"][material]["pbrMetallicRoughness"]["baseColorTexture"]
    accessor = attributes.get(f"TEXCOORD_{use.get('texCoord', 0)}")
    if accessor is not None and tree["accessors"][accessor]["componentType"] == _FLOAT:
        attributes[_FIRST_COORDINATES] = accessor
    else:
        attributes.pop(_FIRST_COORDINATES, None)


def _root(data: bytes) -> dict[str, Any]:
    """Returns the JSON of a glTF or GLB; {} if it is missing or too large."""
    try:
        text, _ = _split(data)
        if sum(map(text.count, (b",", b"[", b"{"))) > _MAX_VALUES:
            return {}
        tree = json.loads(text)
    except (struct.error, ValueError, RecursionError):
        return {}
    return tree if isinstance(tree, dict) else {}


def _split(data: bytes) -> tuple[bytes, bytes]:
    """Returns the JSON of a file, and the bytes after it in a GLB."""
    if not data.startswith(_MAGIC):
        return data, b""
    (length,) = struct.unpack_from("<I", data, 12)
    return data[20 : 20 + length], data[20 + length :]


def _chunk(rest: bytes) -> bytes:
    """Returns the content of the chunk at the beginning of `rest`; empty if it is missing."""
    return rest[8 : 8 + int.from_bytes(rest[:4], "little")]


def _packed(text: bytes, rest: bytes) -> bytes:
    """Returns a GLB of JSON and the bytes after it."""
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sII", _MAGIC, 2, 20 + len(text) + len(rest))
    return head + struct.pack("<I4s", len(text), b"JSON") + text + rest
