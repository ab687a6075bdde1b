"""Writes and reads Wavefront OBJ: points, triangles and texture coordinates, in metres; equal surfaces give
equal bytes."""

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.robot.model.geometry import Colour


def write(surface: Surface) -> bytes:
    """Returns the OBJ file of a surface: lines of `v` and `f`, and of `vt` if it has texture coordinates.
    Numbers are the shortest ones that are exact in single precision."""
    lines = _lines("v", surface.vertices.astype(np.float32))
    corners = (surface.triangles + 1).tolist()
    if surface.texcoords is None:
        lines += [f"f {a} {b} {c}" for a, b, c in corners]
    else:
        pairs, index = np.unique(surface.texcoords.reshape(-1, 2), axis=0, return_inverse=True)
        lines += _lines("vt", pairs)
        places = (index.reshape(-1, 3) + 1).tolist()
        lines += [f"f {a}/{d} {b}/{e} {c}/{f}" for (a, b, c), (d, e, f) in zip(corners, places, strict=True)]
    return ("\n".join(lines) + "\n").encode()


def read(data: bytes) -> npt.NDArray[np.float64]:
    """Returns the corners (m, 3, 3) of the triangles of a file that `write` or `with_material` made."""
    lines = data.decode().splitlines()
    points = np.array([line.split()[1:] for line in lines if line.startswith("v ")], dtype=np.float64)
    faces = [[word.partition("/")[0] for word in line.split()[1:]] for line in lines if line.startswith("f ")]
    corners: npt.NDArray[np.float64] = points.reshape(-1, 3)[
        np.array(faces, dtype=np.int64).reshape(-1, 3) - 1
    ]
    return corners


def with_material(data: bytes, library: str, material: str) -> bytes:
    """Returns the file with all triangles in a material of `library`, the name of an MTL file beside it."""
    return f"mtllib {library}\nusemtl {material}\n".encode() + data


def library(material: str, colour: Colour, image: str) -> bytes:
    """Returns an MTL file with a single material: an image, a file beside it, multiplied by a colour."""
    red, green, blue, alpha = (f"{channel:.9g}" for channel in colour)
    return f"newmtl {material}\nKd {red} {green} {blue}\nd {alpha}\nmap_Kd {image}\n".encode()


def _lines(word: str, numbers: npt.NDArray[np.float32]) -> list[str]:
    rows = (numbers + np.float32(0.0)).astype(str).tolist()
    return [f"{word} {' '.join(number.removesuffix('.0') for number in row)}" for row in rows]
