"""Faults of a build's mesh files."""

import shutil

import numpy as np

from tests.support.faults.edits import file_of, holder
from tests.support.faults.fault import NothingToChange, table
from tests.support.faults.mjcf import of_geom


def stl(edit):
    """Edits a mesh. Findings name it by its name or its file, or a geom or a link that has it."""

    def plant(files, rng):
        path = file_of(files.folder, "assets/*.stl", rng)
        edit(path, rng)
        geoms = files.tree("mjcf").xpath("//body/geom[@mesh = $name][@name]", name=path.stem)
        links = files.tree("urdf").xpath("//link[.//mesh[contains(@filename, $file)]]", file=f"/{path.name}")
        users = [*(of_geom(geom)[0] for geom in geoms), *map(holder, links)]
        return (f'mesh "{path.stem}"', f'"assets/{path.name}"', f'"{path.name}"', *users)

    return plant


def corners(change):
    """Other corners, of (N, 3), in a binary STL."""

    def edit(path, rng):
        data = bytearray(path.read_bytes())
        faces = np.frombuffer(data, dtype=np.dtype([("floats", "<f4", 12), ("rest", "<u2")]), offset=84)
        faces["floats"][:, 3:] = change(faces["floats"][:, 3:].reshape(-1, 3), rng).reshape(-1, 9)
        path.write_bytes(bytes(data))

    return edit


def another(path, rng):
    size = path.stat().st_size
    different = [other for other in sorted(path.parent.glob("*.stl")) if other.stat().st_size != size]
    if not different:
        raise NothingToChange
    shutil.copy(rng.choice(different), path)


def first_half(path, _):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


TURN = np.array([[0, 0.8, 0.6], [1, 0, 0], [0, 0.6, -0.8]], "<f4")
AXES = np.eye(3, dtype="<f4")

FAULTS = table(
    "assets",
    ("mesh 3 mm off in its file",
     stl(corners(lambda points, rng: points + np.float32(0.003) * AXES[rng.randrange(3)])),
     "C-SHAPE: mesh | file | "),
    ("mesh turned in its file", stl(corners(lambda points, _: points @ TURN)), "C-SHAPE: mesh | file | "),
    ("mesh in millimetres", stl(corners(lambda points, _: points * 1000.0)), "C-SHAPE: mesh | file | ",
     "millimetre units"),
    ("mesh 1 % too large", stl(corners(lambda points, _: points * 1.01)), "C-SHAPE: mesh | file | "),
    ("mesh replaced by another", stl(another), "C-SHAPE C-ASSET: mesh | file | "),
    ("mesh cut short", stl(first_half), "C-ASSET C-COMPILE: mesh | file | "),
    ("mesh empty", stl(lambda path, _: path.write_bytes(b"")), "C-ASSET C-COMPILE: mesh | file | "),
    ("mesh missing", stl(lambda path, _: path.unlink()), "C-ASSET C-COMPILE C-PRESENT: mesh | file | ",
     "broken mesh path"),
)  # fmt: skip
