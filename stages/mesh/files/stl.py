"""Binary STL: metres, single precision, the same surface always the same bytes."""

import struct

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.points import STL_FACE, STL_HEADER, mesh_points
from linkwright.stages.formats.meshes.surface import Surface

HEADER = b"linkwright".ljust(STL_HEADER, b"\0")


def write(surface: Surface) -> bytes:
    """The file of a surface; a triangle without area has the normal (0, 0, 0), as STL allows."""
    faces = np.zeros(len(surface.triangles), dtype=STL_FACE)
    normals = surface.normals()
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    faces["normal"] = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0) + 0.0
    faces["corners"] = surface.corners
    return HEADER + struct.pack("<I", len(faces)) + faces.tobytes()


def read(data: bytes) -> npt.NDArray[np.float64]:
    """(m, 3, 3): the corners of each triangle of a file that `write` made."""
    return mesh_points(".stl", data).reshape(-1, 3, 3)
