"""Wavefront OBJ: points and triangles alone, metres, the same surface always the same bytes."""

import numpy as np

from stages.mesh.surface import Surface


def write(surface: Surface) -> bytes:
    """The file of a surface: `v` and `f` only; numbers in single precision, as short as they are exact."""
    points = (surface.vertices.astype(np.float32) + np.float32(0.0)).astype(str)
    lines = [f"v {' '.join(number.removesuffix('.0') for number in row)}" for row in points.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (surface.triangles + 1).tolist()]
    return ("\n".join(lines) + "\n").encode()
