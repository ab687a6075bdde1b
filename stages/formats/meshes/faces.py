"""Reads the surfaces of the mesh files that are written, by index: binary STL and Wavefront OBJ."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.body_arrays import distinct
from linkwright.stages.formats.meshes.points import mesh_points
from linkwright.stages.formats.meshes.surface import Surface, unit_vectors


@dataclass(frozen=True, slots=True, eq=False)
class MeshFaces:
    """The surface of a mesh file."""

    points: npt.NDArray[np.float64]
    """(n, 3) [m]."""

    triangles: npt.NDArray[np.int64]
    """(m, 3), indices into `points`."""

    texcoords: npt.NDArray[np.float64] | None = None
    """(m, 3, 2): the (u, v) of each corner; None without a texture."""


def mesh_corners(file: str, data: bytes) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64] | None]:
    """Returns the corners (m, 3, 3) of the triangles of a file of ours [m], and their texture coordinates (m,
    3, 2), or None without a texture."""
    if file.endswith(".stl"):
        return mesh_points(file, data).reshape(-1, 3, 3), None
    faces = mesh_faces(file, data)
    return faces.points[faces.triangles], faces.texcoords


def mesh_faces(file: str, data: bytes) -> MeshFaces:
    """Returns the surface of a file of ours; equal points of an STL are merged. In an OBJ every corner has
    texture coordinates, or none has."""
    if file.endswith(".stl"):
        points, index = distinct(mesh_points(file, data))
        return MeshFaces(points, index.reshape(-1, 3))
    lines = [line.split() for line in data.decode().splitlines()]
    corners = [word.split("/") for words in lines if words[:1] == ["f"] for word in words[1:]]
    triangles = np.array([int(corner[0]) - 1 for corner in corners], dtype=np.int64).reshape(-1, 3)
    pairs = np.array([words[1:] for words in lines if words[:1] == ["vt"]], dtype=np.float64).reshape(-1, 2)
    texcoords = None
    if len(pairs):
        pair_of_corner = np.array([int(corner[1]) - 1 for corner in corners], dtype=np.int64)
        texcoords = pairs[pair_of_corner].reshape(-1, 3, 2)
    return MeshFaces(mesh_points(file, data), triangles, texcoords)


def normals(faces: MeshFaces) -> npt.NDArray[np.float64]:
    """Returns the unit normals (m, 3) of the triangles; along z for triangles without area."""
    # −0 counts as 0.
    return np.asarray(unit_vectors(Surface(faces.points, faces.triangles).normals()) + 0.0)
