"""Writes and reads Wavefront OBJ: points, triangles and texture coordinates, in metres; equal surfaces give
equal bytes."""

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.robot.model.geometry import Colour


def write(surface: Surface) -> bytes:
    """Returns the OBJ file of a surface: lines of `v` and `f`, and of `vt` if it has texture coordinates.

    Each number is the shortest decimal that gives the same number in single precision.
    """
    lines = _number_lines("v", surface.vertices.astype(np.float32))
    # OBJ counts vertices from 1.
    faces = (surface.triangles + 1).tolist()
    if surface.texcoords is None:
        lines += [f"f {a} {b} {c}" for a, b, c in faces]
    else:
        coordinates, indices = np.unique(surface.texcoords.reshape(-1, 2), axis=0, return_inverse=True)
        lines += _number_lines("vt", coordinates)
        texture_faces = (indices.reshape(-1, 3) + 1).tolist()
        lines += [
            f"f {a}/{d} {b}/{e} {c}/{f}" for (a, b, c), (d, e, f) in zip(faces, texture_faces, strict=True)
        ]
    return ("\n".join(lines) + "\n").encode()


def read(data: bytes) -> npt.NDArray[np.float64]:
    """Returns the corners (m, 3, 3) [m] of the triangles of a file that `write` or `with_material` made."""
    lines = data.decode().splitlines()
    points = np.array([line.split()[1:] for line in lines if line.startswith("v ")], dtype=np.float64)
    # An entry of a face is a vertex, or a vertex and a texture coordinate, as in "5/2".
    faces = [
        [entry.partition("/")[0] for entry in line.split()[1:]] for line in lines if line.startswith("f ")
    ]
    indices = np.array(faces, dtype=np.int64).reshape(-1, 3) - 1
    corners: npt.NDArray[np.float64] = points.reshape(-1, 3)[indices]
    return corners


def with_material(data: bytes, mtl_name: str, material: str) -> bytes:
    """Returns the OBJ file `data` with all triangles in a material. `mtl_name`: the name of the MTL file
    beside it that defines the material."""
    return f"mtllib {mtl_name}\nusemtl {material}\n".encode() + data


def write_material(material: str, colour: Colour, image: str) -> bytes:
    """Returns an MTL file with a single material: an image multiplied by a colour. `image`: the name of the
    image file beside it."""
    red, green, blue, alpha = (f"{channel:.9g}" for channel in colour)
    return f"newmtl {material}\nKd {red} {green} {blue}\nd {alpha}\nmap_Kd {image}\n".encode()


def _number_lines(keyword: str, rows: npt.NDArray[np.float32]) -> list[str]:
    """Returns a line for each row of numbers, such as "v 0.1 0 2"."""
    # Adding 0 turns -0 into 0, so that equal surfaces give equal bytes.
    texts = (rows + np.float32(0.0)).astype(str).tolist()
    return [f"{keyword} {' '.join(text.removesuffix('.0') for text in row)}" for row in texts]
