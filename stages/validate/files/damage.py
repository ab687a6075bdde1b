"""Finds damaged meshes and images: empty files, and truncated copies."""

import struct
from pathlib import Path

import numpy as np

from linkwright.stages.formats.meshes.points import STL_FACE, STL_HEADER
from linkwright.stages.formats.xml import Malformed, parse


def damage(path: Path) -> str:
    """Returns a text on the damage of a file; "" for a complete file or an unknown format."""
    data = path.read_bytes()
    if not data:
        return "is empty"
    damage_of = _DAMAGE_BY_ENDING.get(path.suffix.lower())
    return "" if damage_of is None else damage_of(data)


def _stl_damage(data: bytes) -> str:
    if data.lstrip()[:5].lower() == b"solid" and b"facet" in data[:1000].lower():
        return "" if b"endsolid" in data[-1000:].lower() else "is cut short: it has no endsolid"
    if len(data) < STL_HEADER + 4:
        return "is cut short: it has no triangles"
    (count,) = struct.unpack_from("<I", data, STL_HEADER)
    expected_size = STL_HEADER + 4 + count * STL_FACE.itemsize
    if len(data) < expected_size:
        return f"is cut short: {count} triangles take {expected_size} bytes, it has {len(data)}"
    if not count:
        return "has no triangles"
    faces = np.frombuffer(data, STL_FACE, count, STL_HEADER + 4)
    return "" if np.isfinite(faces["corners"]).all() else "has points that are not finite"


def _obj_damage(data: bytes) -> str:
    point_count = data.count(b"\nv ") + data.startswith(b"v ")
    face_count, largest_index = 0, 0
    for line in data.splitlines():
        if line.startswith(b"f "):
            face_count += 1
            try:
                largest_index = max(largest_index, *(int(word.split(b"/")[0]) for word in line.split()[1:]))
            except (ValueError, TypeError):  # TypeError: a face without corners
                return "has a face that cannot be read"
        elif line.startswith(b"v ") and (b"nan" in line.lower() or b"inf" in line.lower()):
            return "has points that are not finite"
    if not point_count or not face_count:
        return "has no triangles"
    return (
        f"is cut short: a face has point {largest_index} of {point_count}"
        if largest_index > point_count
        else ""
    )


def _png_damage(data: bytes) -> str:
    if not data.startswith(b"\x89PNG\r\n\x1a\n"):
        return "is not a PNG"
    return "" if b"IEND" in data[-16:] else "is cut short: it has no end"


def _glb_damage(data: bytes) -> str:
    if len(data) < 12 or data[:4] != b"glTF":
        return "is not a binary glTF"
    (length,) = struct.unpack_from("<I", data, 8)
    return "" if len(data) >= length else f"is cut short: {length} bytes, it has {len(data)}"


def _xml_damage(data: bytes) -> str:
    try:
        parse(data, large=True)
    except Malformed as error:
        return f"is not XML: {error.place}"
    return ""


_DAMAGE_BY_ENDING = {
    ".stl": _stl_damage,
    ".obj": _obj_damage,
    ".png": _png_damage,
    ".glb": _glb_damage,
    ".dae": _xml_damage,
}
"""Extension of a file → the function that returns a text on the damage of its content; "" without
damage."""
