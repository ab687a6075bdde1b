"""Writes binary STL, and reads the points of the mesh files that are written: binary STL and Wavefront
OBJ."""

import struct

import numpy as np
import numpy.typing as npt

STL_HEADER = 80
"""Length of a binary STL's header [bytes]; the number of triangles comes after it."""

_HEADER = b"linkwright".ljust(STL_HEADER, b"\0")

STL_FACE = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def is_binary_stl(data: bytes) -> bool:
    """Tells whether the length of a file is that of a binary STL with the number of triangles in its
    header."""
    start = STL_HEADER + 4
    return (
        len(data) >= start
        and len(data) == start + STL_FACE.itemsize * struct.unpack_from("<I", data, STL_HEADER)[0]
    )


def binary_stl(corners: npt.NDArray[np.float64], normals: npt.NDArray[np.float64] | None = None) -> bytes:
    """Returns the binary STL of triangles (m, 3, 3), with normals (m, 3), which most readers compute
    themselves; a triangle without area has the normal (0, 0, 0), as STL allows."""
    faces = np.zeros(len(corners), dtype=STL_FACE)
    if normals is not None:
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        faces["normal"] = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0) + 0.0
    faces["corners"] = corners
    return _HEADER + struct.pack("<I", len(faces)) + faces.tobytes()


def mesh_points(file: str, data: bytes) -> npt.NDArray[np.float64]:
    """Returns the points (n, 3) [m] of a file of ours; of an STL, each corner of each triangle."""
    if file.endswith(".stl"):
        (count,) = struct.unpack_from("<I", data, STL_HEADER)
        faces = np.frombuffer(data, dtype=STL_FACE, count=count, offset=STL_HEADER + 4)
        return faces["corners"].reshape(-1, 3).astype(np.float64)
    rows = [line.split()[1:4] for line in data.decode().splitlines() if line.startswith("v ")]
    return np.array(rows, dtype=np.float64).reshape(-1, 3)
