"""Faults of mesh files."""

import random
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from tests.support.mutations.edits import named
from tests.support.mutations.kind import Files, Kinds, NothingToChange, Planted
from tests.support.mutations.mjcf_shapes import of_geom

KINDS = Kinds("assets")


def stl(files: Files, rng: random.Random) -> Path:
    found = sorted((files.folder / "assets").glob("*.stl"))
    if not found:
        raise NothingToChange
    return rng.choice(found)


def of_mesh(files: Files, path: Path) -> Planted:
    """Findings name the mesh by its name or its file, or a geom that has it, or the link that does."""
    geoms = [one for one in files.mjcf.xpath("//body/geom[@mesh]") if one.get("mesh") == path.stem]
    users = [of_geom(one)[0] for one in geoms if one.get("name")]
    links = [
        one for one in files.urdf.iter("link") if one.xpath(f".//mesh[contains(@filename, '/{path.name}')]")
    ]
    users += [named("link", one) for one in links]
    return Planted(
        f'mesh "{path.stem}"', ("mesh", "file", ""), (f'"assets/{path.name}"', f'"{path.name}"', *users)
    )


@KINDS.add("mesh 3 mm off in its file", "C-SHAPE")
def _(files: Files, rng: random.Random) -> Planted:
    path = stl(files, rng)
    changed(path, lambda points: points + np.float32(0.003) * np.eye(3, dtype="<f4")[rng.randrange(3)])
    return of_mesh(files, path)


@KINDS.add("mesh turned in its file", "C-SHAPE")
def _(files: Files, rng: random.Random) -> Planted:
    path = stl(files, rng)
    changed(path, lambda points: points @ np.array([[0, 0.8, 0.6], [1, 0, 0], [0, 0.6, -0.8]], "<f4"))
    return of_mesh(files, path)


@KINDS.add("mesh in millimetres", "C-SHAPE", simcheck="millimetre units")
def _(files: Files, rng: random.Random) -> Planted:
    path = stl(files, rng)
    scaled(path, 1000.0)
    return of_mesh(files, path)


def scaled(path: Path, factor: float) -> None:
    """The same binary STL, `factor` times as large."""
    changed(path, lambda points: points * factor)


def changed(path: Path, change: Callable[[Any], Any]) -> None:
    """The same binary STL with other corners, of (N, 3)."""
    data = bytearray(path.read_bytes())
    faces = np.frombuffer(data, dtype=np.dtype([("floats", "<f4", 12), ("rest", "<u2")]), offset=84)
    faces["floats"][:, 3:] = change(faces["floats"][:, 3:].reshape(-1, 3)).reshape(-1, 9)
    path.write_bytes(bytes(data))


@KINDS.add("mesh 1 % too large", "C-SHAPE")
def _(files: Files, rng: random.Random) -> Planted:
    path = stl(files, rng)
    scaled(path, 1.01)
    return of_mesh(files, path)


@KINDS.add("mesh replaced by another", "C-SHAPE", "C-ASSET")
def _(files: Files, rng: random.Random) -> Planted:
    path = stl(files, rng)
    others = [one for one in sorted(path.parent.glob("*.stl")) if one.read_bytes() != path.read_bytes()]
    different = [one for one in others if one.stat().st_size != path.stat().st_size]
    if not different:
        raise NothingToChange
    shutil.copy(rng.choice(different), path)
    return of_mesh(files, path)


@KINDS.add("mesh cut short", "C-ASSET", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    path = stl(files, rng)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    return of_mesh(files, path)


@KINDS.add("mesh empty", "C-ASSET", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    path = stl(files, rng)
    path.write_bytes(b"")
    return of_mesh(files, path)


@KINDS.add("mesh missing", "C-ASSET", "C-COMPILE", "C-PRESENT", simcheck="broken mesh path")
def _(files: Files, rng: random.Random) -> Planted:
    path = stl(files, rng)
    path.unlink()
    return of_mesh(files, path)
