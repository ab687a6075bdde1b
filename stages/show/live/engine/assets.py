"""Collects the files of the engine's copy of the model: the colliders' meshes, under new names."""

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

MAX_MESH_BYTES = 4_000_000
"""Largest size [bytes] of all meshes of colliders together; larger meshes are replaced by their convex hulls,
by which MuJoCo collides anyway."""

_APPLIED_ATTRIBUTES = (
    "scale",
    "refpos",
    "refquat",
    "builtin",
    "params",
    "content_type",
    "inertia",
    "maxhullvert",
)
"""Attributes that MuJoCo has already applied to the compiled mesh."""


def with_assets(root: Element, model: Any, folder: Path) -> tuple[dict[str, bytes], list[dict[str, str]]]:
    """Removes the unused assets from a document, in place, and renames the files of the used assets. Returns
    the content of each file by its new name, and what the files lack.
    """
    used_assets = list(_keep_used(root))
    base = _mesh_folder(root)
    contents = {
        asset: (folder / base / asset.get("file")).read_bytes() for asset in used_assets if asset.get("file")
    }
    exceeds_limit = sum(map(len, contents.values())) > MAX_MESH_BYTES
    files: dict[str, bytes] = {}
    hulls = 0
    for number, asset in enumerate(used_assets):
        suffix = PurePosixPath(asset.get("file", "")).suffix.lower()
        data = contents.get(asset)
        if tag(asset) == "mesh" and (exceeds_limit or is_newer_shape(asset)):
            suffix, data = ".msh", _hull(asset, model)
            hulls += 1
        if data is not None:
            asset.set("file", f"{number}{suffix}")
            files[f"{number}{suffix}"] = data
    replacement = {"what": f"the triangles of {count(hulls, 'mesh', 'meshes')}", "place": "colliders"}
    return files, [{**replacement, "instead": "the convex hulls, by which MuJoCo collides"}] if hulls else []


def _keep_used(root: Element) -> Iterator[Element]:
    """Yields the used meshes and height fields, each with a name, and removes the unused ones."""
    used_names = {
        (kind, node.get(kind)) for node in root.iter() for kind in ("mesh", "hfield") if node.get(kind)
    }
    for section in root.iterchildren("asset"):
        for asset in [node for node in section if tag(node) in ("mesh", "hfield")]:
            name = asset.get("name") or PurePosixPath(asset.get("file", "")).stem
            if (tag(asset), name) in used_names:
                asset.set("name", name)
                yield asset
            else:
                section.remove(asset)


def _mesh_folder(root: Element) -> PurePosixPath:
    """Returns the folder of the meshes that the last compiler element with such a folder names."""
    base = ""
    for compiler in root.iterchildren("compiler"):
        base = compiler.get("meshdir") or compiler.get("assetdir") or base
    return PurePosixPath(base)


def _hull(asset: Element, model: Any) -> bytes:
    """Returns the points of a mesh's convex hull in the frame of its file, as MuJoCo's own format MSH."""
    index = index_of(model, mujoco.mjtObj.mjOBJ_MESH, asset.get("name"))
    first, number = int(model.mesh_vertadr[index]), int(model.mesh_vertnum[index])
    points = model.mesh_vert[first : first + number].astype(np.float64)
    hull = hull_of(model, index)
    if len(hull):
        points = points[np.unique(hull)]
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.mesh_quat[index])
    points_in_file = points @ rotation.reshape(3, 3).T + model.mesh_pos[index]
    for attribute in _APPLIED_ATTRIBUTES:
        asset.attrib.pop(attribute, None)
    content: bytes = points_in_file.astype("<f4").tobytes()
    return struct.pack("<4i", len(points_in_file), 0, 0, 0) + content
