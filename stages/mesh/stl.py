"""Binary STL: metres, single precision, the same surface always the same bytes."""

import struct

import numpy as np
import numpy.typing as npt

from stages.mesh.surface import Surface

HEADER = b"linkwright".ljust(80, b"\0")

_FACE = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def write(surface: Surface) -> bytes:
    """The file of a surface; a triangle without area has the normal (0, 0, 0), as STL allows."""
    faces = np.zeros(len(surface.triangles), dtype=_FACE)
    normals = surface.normals()
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    faces["normal"] = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0) + 0.0
    faces["corners"] = surface.corners
    return HEADER + struct.pack("<I", len(faces)) + faces.tobytes()


def read(data: bytes) -> npt.NDArray[np.float64]:
    """(m, 3, 3): the corners of each triangle of a file that `write` made."""
    (count,) = struct.unpack_from("<I", data, len(HEADER))
    faces = np.frombuffer(data, dtype=_FACE, count=count, offset=len(HEADER) + 4)
    return faces["corners"].astype(np.float64)
