"""The files of the engine's copy of the model: the colliders' meshes, with names of their own."""

import struct
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.mujoco.names import index_of
from linkwright.stages.robot.text.plural import count
from linkwright.stages.show.live.engine.version import is_newer_shape
from linkwright.stages.show.live.triangles import hull_of

LARGE = 4_000_000
"""Meshes of colliders with more bytes in all are replaced by their convex hulls, which is what collides."""

_PROCESSED = ("scale", "refpos", "refquat", "builtin", "params", "content_type", "inertia", "maxhullvert")
"""Attributes that made what the compiled mesh already is."""


def with_assets(root: Element, model: Any, folder: Path) -> tuple[dict[str, bytes], list[dict[str, str]]]:
    """Removes the assets that nothing uses from a document, in place, and renames the files of the others.

    Returns the content of each file by its new name, and what they lack.
    """
    kept = list(_used(root))
    base = _base(root)
    given = {asset: (folder / base / asset.get("file")).read_bytes() for asset in kept if asset.get("file")}
    large = sum(map(len, given.values())) > LARGE
    files: dict[str, bytes] = {}
    hulls = 0
    for number, asset in enumerate(kept):
        suffix = PurePosixPath(asset.get("file", "")).suffix.lower()
        data = given.get(asset)
        if tag(asset) == "mesh" and (large or is_newer_shape(asset)):
            suffix, data = ".msh", _hull(asset, model)
            hulls += 1
        if data is not None:
            asset.set("file", f"{number}{suffix}")
            files[f"{number}{suffix}"] = data
    lack = {"what": f"the triangles of {count(hulls, 'mesh', 'meshes')}", "place": "colliders"}
    return files, [{**lack, "instead": "the convex hulls, by which MuJoCo collides"}] if hulls else []


def _used(root: Element) -> Iterator[Element]:
    """The meshes and height fields that something uses, each with a name; removes the others."""
    used = {(kind, node.get(kind)) for node in root.iter() for kind in ("mesh", "hfield") if node.get(kind)}
    for section in root.iterchildren("asset"):
        for asset in [one for one in section if tag(one) in ("mesh", "hfield")]:
            name = asset.get("name") or PurePosixPath(asset.get("file", "")).stem
            if (tag(asset), name) in used:
                asset.set("name", name)
                yield asset
            else:
                section.remove(asset)


def _base(root: Element) -> PurePosixPath:
    """The folder of the meshes, by the last compiler element that names one."""
    base = ""
    for compiler in root.iterchildren("compiler"):
        base = compiler.get("meshdir") or compiler.get("assetdir") or base
    return PurePosixPath(base)


def _hull(asset: Element, model: Any) -> bytes:
    """The points of a mesh's convex hull in the frame of its file, as MuJoCo's own format MSH."""
    index = index_of(model, mujoco.mjtObj.mjOBJ_MESH, asset.get("name"))
    first, number = int(model.mesh_vertadr[index]), int(model.mesh_vertnum[index])
    points = model.mesh_vert[first : first + number].astype(np.float64)
    hull = hull_of(model, index)
    if len(hull):
        points = points[np.unique(hull)]
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.mesh_quat[index])
    placed = points @ turn.reshape(3, 3).T + model.mesh_pos[index]
    for attribute in _PROCESSED:
        asset.attrib.pop(attribute, None)
    content: bytes = placed.astype("<f4").tobytes()
    return struct.pack("<4i", len(placed), 0, 0, 0) + content
