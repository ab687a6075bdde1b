"""The triangles of a compiled model's meshes."""

from __future__ import annotations

import re
from hashlib import sha256

import mujoco
import numpy as np

from stages.formats import triangles
from stages.robot.geometry import NEUTRAL, Colour
from stages.robot.model import Array, MeshRef, frozen
from stages.robot.poses import from_parts, rotation_from_quat


class Meshes:
    """The triangles of a model's meshes, a blob for each mesh in each colour and texture that is asked for.

    `keys`: the digest of each by its key; `blobs`: the compact form by digest.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model = model
        self.keys: dict[str, str] = {}
        self.blobs: dict[str, bytes] = {}

    def ref(self, mesh: int, colour: Colour | None, image: str = "") -> MeshRef:
        """The reference to the triangles of a mesh in this colour, times the image of this digest, if any."""
        model = self._model
        name = model.mesh(mesh).name
        identity = (mesh, name, colour, *filter(None, [image]))
        digest = sha256(repr(identity).encode()).hexdigest()[:12]
        key = f"{re.sub(r'[^A-Za-z0-9_]+', '_', name)[:40]}-{digest}"
        if key not in self.keys:
            body = triangles.encode([self._body(key, mesh, colour or NEUTRAL, image)])
            self.keys[key] = sha256(body).hexdigest()
            self.blobs[self.keys[key]] = body
        return MeshRef(self.keys[key], key)

    def asset_from_mesh(self, mesh: int) -> Array:
        """(4, 4): MuJoCo turns a mesh to its principal axes about its centre, and each geom with it."""
        return placed(self._model.mesh_pos[mesh], self._model.mesh_quat[mesh])

    def _body(self, key: str, mesh: int, colour: Colour, image: str) -> triangles.Body:
        model = self._model
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        pose = self.asset_from_mesh(mesh)
        points = model.mesh_vert[first : first + count].astype(np.float64) @ pose[:3, :3].T + pose[:3, 3]
        first, count = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        faces = np.array(model.mesh_face[first : first + count], dtype=np.int32)
        texcoords = None
        if image:
            pairs = model.mesh_texcoord[int(model.mesh_texcoordadr[mesh]) :]
            # MuJoCo's v runs downwards from the upper left corner.
            corners = pairs[model.mesh_facetexcoord[first : first + count]]
            texcoords = np.stack([corners[..., 0], 1 - corners[..., 1]], axis=-1)
        ranks = np.zeros(len(faces), dtype=np.uint16)
        return triangles.Body(key, points, faces, (colour,), ranks, (image,) if image else (), texcoords)


def placed(position: Array, quat: Array) -> Array:
    """The pose (4, 4) of MuJoCo's position and quaternion (w, x, y, z)."""
    return frozen(from_parts(rotation_from_quat(quat), np.asarray(position, dtype=np.float64)))
