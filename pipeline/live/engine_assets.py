"""The files of the engine's copy of the model: the colliders' meshes, with names of their own."""

from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Any

import mujoco
import numpy as np

from pipeline.live.engine_version import is_newer_shape
from pipeline.live.triangles import hull_of
from stages.formats.xml import Element, tag

LARGE = 4_000_000
"""Meshes of colliders with more bytes in all are replaced by their convex hulls, which is what collides."""

_PROCESSED = ("scale", "refpos", "refquat", "builtin", "params", "content_type", "inertia", "maxhullvert")
"""Attributes that made what the compiled mesh already is."""


def with_assets(root: Element, model: Any, folder: Path) -> dict[str, bytes]:
    """Removes the assets that nothing uses from a document, in place, and renames the files of the others.

    Returns the content of each file by its new name.
    """
    used = {node.get("mesh") for node in root.iter() if node.get("mesh")}
    fields = {node.get("hfield") for node in root.iter() if node.get("hfield")}
    base = _base(root)
    kept: list[tuple[Element, str, bytes | None]] = []
    for asset in list(_assets(root)):
        name = asset.get("name") or PurePosixPath(asset.get("file", "")).stem
        if name not in (used if tag(asset) == "mesh" else fields):
            asset.getparent().remove(asset)
            continue
        asset.set("name", name)
        path = asset.get("file")
        kept.append((asset, name, None if path is None else (folder / base / path).read_bytes()))
    large = sum(len(data) for _, _, data in kept if data is not None) > LARGE
    files: dict[str, bytes] = {}
    for number, (asset, name, data) in enumerate(kept):
        if tag(asset) == "mesh" and (large or is_newer_shape(asset)):
            _hull(asset, name, model)
        elif data is not None:
            own = f"{number}{PurePosixPath(asset.get('file', '')).suffix.lower()}"
            asset.set("file", own)
            files[own] = data
    return files


def _assets(root: Element) -> Iterator[Element]:
    for section in root.iterchildren("asset"):
        yield from (one for one in section if tag(one) in ("mesh", "hfield"))


def _base(root: Element) -> PurePosixPath:
    """The folder of the meshes, by the last compiler element that names one."""
    base = ""
    for compiler in root.iterchildren("compiler"):
        base = compiler.get("meshdir") or compiler.get("assetdir") or base
    return PurePosixPath(base)


def _hull(asset: Element, name: str, model: Any) -> None:
    """Makes a mesh asset the points of its convex hull, in the frame of its file, without that file."""
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_MESH, name)
    first, count = int(model.mesh_vertadr[index]), int(model.mesh_vertnum[index])
    points = model.mesh_vert[first : first + count].astype(np.float64)
    hull = hull_of(model, index)
    if len(hull):
        points = points[np.unique(hull)]
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.mesh_quat[index])
    placed = points @ turn.reshape(3, 3).T + model.mesh_pos[index]
    for attribute in _PROCESSED:
        asset.attrib.pop(attribute, None)
    asset.attrib.pop("file", None)
    asset.set("vertex", " ".join(f"{one:.9g}" for one in placed.ravel()))
