"""Reads the triangles of a compiled model's meshes."""

from __future__ import annotations

import re
from collections.abc import Sequence
from hashlib import sha256

import mujoco
import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes import body_arrays
from linkwright.stages.mujoco.bodies import pose_of
from linkwright.stages.robot.model.geometry import NEUTRAL, Colour
from linkwright.stages.robot.model.robot import Array, MeshRef


class Meshes:
    """Converts the meshes of a model to triangles: a blob for each mesh in each requested colour and texture.

    `keys`: key of a mesh → the digest of its triangles; `blobs`: digest → the triangles in the compact form.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model = model
        self.keys: dict[str, str] = {}
        self.blobs: dict[str, bytes] = {}

    def ref(self, mesh: int, colour: Colour | None, image: str = "") -> MeshRef:
        """Returns the reference to the triangles of a mesh in this colour, times the image of this digest, if
        any."""
        model = self._model
        name = model.mesh(mesh).name
        identity = (mesh, name, colour, *filter(None, [image]))
        digest = sha256(repr(identity).encode()).hexdigest()[:12]
        key = f"{re.sub(r'[^A-Za-z0-9_]+', '_', name)[:40]}-{digest}"
        if key not in self.keys:
            body = body_arrays.encode([self._body(key, mesh, colour or NEUTRAL, image)])
            self.keys[key] = sha256(body).hexdigest()
            self.blobs[self.keys[key]] = body
        return MeshRef(self.keys[key], key)

    def ellipsoid(self, size: Sequence[float], colour: Colour | None) -> MeshRef:
        """Returns the reference to the triangles of an ellipsoid whose diameters along x, y and z [m] are
        `size`; the ellipsoid lies within the triangles."""
        identity = ("ellipsoid", *map(float, size), colour)
        key = f"ellipsoid-{sha256(repr(identity).encode()).hexdigest()[:12]}"
        if key not in self.keys:
            points, faces = _ball()
            ranks = np.zeros(len(faces), dtype=np.uint16)
            body = body_arrays.Body(
                key, points * np.array(size) / 2, faces, (colour or NEUTRAL,), ranks, (), None
            )
            data = body_arrays.encode([body])
            self.keys[key] = sha256(data).hexdigest()
            self.blobs[self.keys[key]] = data
        return MeshRef(self.keys[key], key)

    def asset_from_mesh(self, mesh: int) -> Array:
        """Returns the transform (4, 4) by which MuJoCo turns a mesh, and each of its geoms, to the principal
        axes about its centre."""
        return pose_of(self._model.mesh_pos[mesh], self._model.mesh_quat[mesh])

    def _body(self, key: str, mesh: int, colour: Colour, image: str) -> body_arrays.Body:
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
        return body_arrays.Body(key, points, faces, (colour,), ranks, (image,) if image else (), texcoords)


_POINTS_AROUND, _STEPS_UP = 32, 16
"""Number of points around the axis of a ball, and of steps from pole to pole."""


def _ball() -> tuple[Array, npt.NDArray[np.int32]]:
    """Returns the corners (n, 3) and triangles (m, 3) of a polyhedron around the ball of radius 1."""
    turns = np.arange(_POINTS_AROUND) * (2 * np.pi / _POINTS_AROUND)
    tilts = np.arange(1, _STEPS_UP) * (np.pi / _STEPS_UP)
    rings = [[np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)] for a in tilts for b in turns]
    points = np.array([[0.0, 0.0, 1.0], *rings, [0.0, 0.0, -1.0]])
    last = len(points) - 1
    faces: list[tuple[int, int, int]] = []
    for column in range(_POINTS_AROUND):
        next_column = (column + 1) % _POINTS_AROUND
        faces.append((0, 1 + column, 1 + next_column))
        for ring in range(_STEPS_UP - 2):
            ring_start = 1 + ring * _POINTS_AROUND
            a, b, c, d = (
                ring_start + column,
                ring_start + next_column,
                ring_start + _POINTS_AROUND + column,
                ring_start + _POINTS_AROUND + next_column,
            )
            faces += [(a, c, b), (b, c, d)]
        last_ring = 1 + (_STEPS_UP - 2) * _POINTS_AROUND
        faces.append((last_ring + column, last, last_ring + next_column))
    corners = np.array(faces, dtype=np.int32)
    normals = np.cross(
        points[corners[:, 1]] - points[corners[:, 0]], points[corners[:, 2]] - points[corners[:, 0]]
    )
    face_distances = np.abs((normals * points[corners[:, 0]]).sum(axis=1)) / np.linalg.norm(normals, axis=1)
    # Scaled so that the ball touches its nearest face, and lies within the polyhedron.
    return points / face_distances.min(), corners
