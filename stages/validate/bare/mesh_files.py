"""Reads the points of a mesh file, in every format that a build reads except PLY."""

import re
import struct
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from linkwright.stages.formats.meshes import gltf
from linkwright.stages.formats.meshes.dae_points import dae_points
from linkwright.stages.formats.meshes.points import mesh_points
from linkwright.stages.robot.errors import LinkwrightError
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.validate.model.body_shapes import MAX_VERTICES, outermost_of

_STL_VERTEX = re.compile(rb"^\s*vertex\s+(\S+)\s+(\S+)\s+(\S+)", re.MULTILINE)


def outermost_points(path: Path) -> Array | None:
    """Returns the outermost points (n, 3) of a mesh, in the unit of its file; None if the file is missing,
    cannot be read, or has no point with finite coordinates."""
    read = _READERS.get(path.suffix.lower())
    if read is None or not path.is_file():
        return None
    try:
        points = read(path.read_bytes())
    except (ValueError, IndexError, struct.error, LinkwrightError):
        return None
    finite = points[np.isfinite(points).all(axis=1)]
    return outermost_of(finite[:: 1 + len(finite) // MAX_VERTICES]) if len(finite) else None


def _stl(data: bytes) -> Array:
    # A binary STL may begin with "solid", too, but its header has no facet.
    if data.lstrip().startswith(b"solid") and b"facet" in data[:2000]:
        return np.array(_STL_VERTEX.findall(data), dtype=np.float64).reshape(-1, 3)
    # Only the ending of the name matters.
    return mesh_points("a.stl", data)


def _obj(data: bytes) -> Array:
    # Only the ending of the name matters.
    return mesh_points("a.obj", data)


def _gltf(data: bytes) -> Array:
    return np.concatenate([np.zeros((0, 3)), *(node.points for node in gltf.read(data))])


_READERS: Mapping[str, Callable[[bytes], Array]] = {
    ".stl": _stl,
    ".obj": _obj,
    ".dae": dae_points,
    ".glb": _gltf,
    ".gltf": _gltf,
}
"""Ending of a mesh file, in lower case → the function that returns its points (n, 3)."""
