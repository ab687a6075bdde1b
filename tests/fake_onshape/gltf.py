"""What Onshape says about a part studio as binary glTF: one node and one mesh a body."""

import json
import struct

import numpy as np


def gltf(parts, *, appearances, up="z", name=lambda part, index: f"Body {index}", order=None):
    """The file. `up`: "z" keeps the studio's axes, "y" turns coordinates so that its z is glTF's y.

    glTF says that y points up; what Onshape does is not known, so both can be served. `name` gives
    a node its name; `order` permutes the nodes.
    """
    buffer = bytearray()
    data = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}
    for key in ("nodes", "meshes", "materials", "accessors", "bufferViews"):
        data[key] = []
    for index in order if order is not None else range(len(parts)):
        part = parts[index]
        primitives = [
            _primitive(data, buffer, part, faces, colour, up)
            for colour, faces in _by_colour(part, appearances)
        ]
        data["scenes"][0]["nodes"].append(len(data["nodes"]))
        data["nodes"].append({"name": name(part, index), "mesh": len(data["meshes"])})
        data["meshes"].append({"primitives": primitives})
    data["buffers"] = [{"byteLength": len(buffer)}]
    text = json.dumps(data, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    chunks += struct.pack("<II", len(buffer), 0x004E4942) + bytes(buffer)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _by_colour(part, appearances):
    """(colour, faces) of a part; one pair where colours of faces are not asked for."""
    colours = {}
    for face in part.solid.faces:
        own = part.face_colours.get(face.name, part.colour) if appearances else part.colour
        colours.setdefault(tuple(own), []).append(face)
    return list(colours.items())


def _primitive(data, buffer, part, faces, colour, up):
    points, normals, indices = [], [], []
    for face in faces:  # faces share no points, as they share no normals
        used = np.unique(face.triangles)
        indices.append(np.searchsorted(used, face.triangles) + sum(map(len, points)))
        points.append(part.solid.vertices[used])
        corners = part.solid.vertices[face.triangles]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        summed = np.zeros((len(used), 3))
        np.add.at(summed, np.searchsorted(used, face.triangles).ravel(), normal.repeat(3, axis=0))
        normals.append(summed / np.maximum(np.linalg.norm(summed, axis=1, keepdims=True), 1e-30))
    points, normals = np.concatenate(points), np.concatenate(normals)
    if up == "y":
        points, normals = points[:, [0, 2, 1]] * [1, 1, -1], normals[:, [0, 2, 1]] * [1, 1, -1]
    data["materials"].append({"pbrMetallicRoughness": {"baseColorFactor": _linear(colour)}})
    bounds = {"min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()}
    return {
        "attributes": {
            "POSITION": _accessor(data, buffer, points.astype("<f4"), 5126, "VEC3", 34962, **bounds),
            "NORMAL": _accessor(data, buffer, normals.astype("<f4"), 5126, "VEC3", 34962),
        },
        "indices": _accessor(data, buffer, np.concatenate(indices).astype("<u4"), 5125, "SCALAR", 34963),
        "material": len(data["materials"]) - 1,
    }


def _accessor(data, buffer, array, component, kind, target, **bounds):
    view = {"buffer": 0, "byteOffset": len(buffer), "byteLength": array.nbytes, "target": target}
    buffer += array.tobytes()
    data["bufferViews"].append(view)
    record = {"bufferView": len(data["bufferViews"]) - 1, "componentType": component, "type": kind}
    data["accessors"].append(record | {"count": array.size if kind == "SCALAR" else len(array)} | bounds)
    return len(data["accessors"]) - 1


def _linear(colour):
    shown = [channel / 255 for channel in colour]
    light = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in shown[:3]]
    return [*light, shown[3] if len(shown) > 3 else 1.0]
