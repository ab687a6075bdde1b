"""The points of the mesh files that are written: binary STL and Wavefront OBJ."""

import struct

import numpy as np
import numpy.typing as npt

STL_HEADER = 80
"""Length of a binary STL's header [bytes]; the number of triangles comes after it."""

STL_FACE = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def is_binary_stl(data: bytes) -> bool:
    """Whether the length of a file is that of a binary STL with as many triangles as it says."""
    start = STL_HEADER + 4
    return (
        len(data) >= start
        and len(data) == start + STL_FACE.itemsize * struct.unpack_from("<I", data, STL_HEADER)[0]
    )


def mesh_points(file: str, data: bytes) -> npt.NDArray[np.float64]:
    """(n, 3) [m]: the points of a file of ours; of an STL each corner of each triangle."""
    if file.endswith(".stl"):
        (count,) = struct.unpack_from("<I", data, STL_HEADER)
        faces = np.frombuffer(data, dtype=STL_FACE, count=count, offset=STL_HEADER + 4)
        return faces["corners"].reshape(-1, 3).astype(np.float64)
    rows = [line.split()[1:4] for line in data.decode().splitlines() if line.startswith("v ")]
    return np.array(rows, dtype=np.float64).reshape(-1, 3)
