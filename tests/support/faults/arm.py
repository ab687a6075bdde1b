"""An arm of three links as a URDF and an MJCF that come alone, in which faults of bare files are planted."""

import struct

import numpy as np

from tests.support.places import MODELS


def box_stl(x, y, z):
    """A box around its origin, of these lengths, as a binary STL."""
    corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * (x / 2, y / 2, z / 2)
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [(a, b, c) for a, b, c, _ in sides] + [(a, c, d) for a, _, c, d in sides]
    rows = [struct.pack("<12fH", 0, 0, 0, *corners[list(face)].ravel(), 0) for face in faces]
    return b"\0" * 80 + struct.pack("<I", len(rows)) + b"".join(rows)


URDF, MJCF = ((MODELS / f"arm.{ending}").read_text() for ending in ("urdf", "xml"))


def write_arm(folder):
    """Writes both files and their meshes."""
    for name in ("base", "upper", "lower"):
        (folder / f"{name}.stl").write_bytes(box_stl(0.07, 0.07, 0.2))
    (folder / "arm.urdf").write_text(URDF)
    (folder / "arm.xml").write_text(MJCF)
    return folder


def replace_last(path, old, new):
    """Replaces the last place of a text in a file: that of the last link or joint."""
    before, middle, after = path.read_text().rpartition(old)
    assert middle, old
    path.write_text(before + new + after)


def problems(checks):
    """Code, element and attribute of the findings of checks that do not pass."""
    return {
        (check.code, finding.element, finding.attribute)
        for check in checks
        if not check.passed
        for finding in check.findings
    }
