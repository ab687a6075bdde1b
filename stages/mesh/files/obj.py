"""Wavefront OBJ: points, triangles, texture coordinates; metres, the same surface always the same bytes."""

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.robot.model.geometry import Colour


def write(surface: Surface) -> bytes:
    """The file of a surface: `v` and `f` only, and `vt` where it has texture coordinates; numbers in single
    precision, as short as they are exact."""
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
    """(m, 3, 3): the corners of each triangle of a file that `write` made, with a material or without."""
    lines = data.decode().splitlines()
    points = np.array([line.split()[1:] for line in lines if line.startswith("v ")], dtype=np.float64)
    faces = [[word.partition("/")[0] for word in line.split()[1:]] for line in lines if line.startswith("f ")]
    corners: npt.NDArray[np.float64] = points.reshape(-1, 3)[
        np.array(faces, dtype=np.int64).reshape(-1, 3) - 1
    ]
    return corners


def with_material(data: bytes, library: str, material: str) -> bytes:
    """The file with all triangles in a material of the library, a file beside it."""
    return f"mtllib {library}\nusemtl {material}\n".encode() + data


def library(material: str, colour: Colour, image: str) -> bytes:
    """The library of materials (MTL) with one: an image, beside the file, times a colour."""
    red, green, blue, alpha = (f"{channel:.9g}" for channel in colour)
    return f"newmtl {material}\nKd {red} {green} {blue}\nd {alpha}\nmap_Kd {image}\n".encode()


def _lines(word: str, numbers: npt.NDArray[np.float32]) -> list[str]:
    rows = (numbers + np.float32(0.0)).astype(str).tolist()
    return [f"{word} {' '.join(number.removesuffix('.0') for number in row)}" for row in rows]
