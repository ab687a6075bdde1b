"""Writes and reads binary STL, in metres and single precision; equal surfaces give equal bytes."""

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.points import binary_stl, mesh_points
from linkwright.stages.formats.meshes.surface import Surface


def write(surface: Surface) -> bytes:
    """Returns the STL file of a surface."""
    return binary_stl(surface.corners, surface.normals())


def read(data: bytes) -> npt.NDArray[np.float64]:
    """Returns the corners (m, 3, 3) of the triangles of a file that `write` made."""
    return mesh_points(".stl", data).reshape(-1, 3, 3)
