"""What is seen of a robot: the triangles of MuJoCo's compiled model at its keyframe `home`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from pipeline.preview import solids
from pipeline.preview.creases import normals_of
from pipeline.preview.solids import Skin
from pipeline.preview.thinning import thinned
from stages.mesh.view.raster import Corners, Indices, Numbers

_BARE = (0.45, 0.49, 0.54, 1.0)
_MARKED = (0.93, 0.45, 0.16, 1.0)
"""Colours of what is drawn of a robot without any geometry: bones, and joints."""

_UNSEEN = 0.02
_NO_GEOM_COLOUR = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's default, which says that the material's colour holds."""

_MANY = 600_000
"""Triangles that are all drawn."""

_CELLS = 600
"""Cells across a robot with more: one is about a pixel of the picture."""

_THREE_QUARTER = np.array([0.668, -0.602, 0.401])
"""Where the camera stands where the scene has none: in front, to the robot's right, above."""


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """`corners` and `normals` (m, 3, 3) in the world [m], `colours` (m, 4) in sRGB from 0 to 1, `places`
    (m, 3, 2) in the image of each triangle, `image` (m,): which of `images` (height, width, 3), or -1.
    `backward` (3,): the direction from the robot to the camera; `floor`: the height of the ground [m]."""

    corners: Corners
    normals: Corners
    colours: Numbers
    places: Numbers
    image: Indices
    images: tuple[Numbers, ...]
    backward: Numbers
    floor: float


def seen_in(model: Any, values: dict[str, float]) -> Seen:
    """What is seen of a model at `home`, or, where it has no such keyframe, with the joints' `values`
    [rad, m] by name and the others at zero."""
    data = mujoco.MjData(model)
    home = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, "home")
    if home >= 0:
        mujoco.mj_resetDataKeyframe(model, data, home)
    for joint in range(model.njnt if home < 0 else 0):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, joint)
        if name in values:
            data.qpos[model.jnt_qposadr[joint]] = values[name]
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)
    textures = _Textures(model)
    shown = _shown(model)
    cell = _coarse(model, data, shown)
    pieces = [_geom(model, data, geom, textures, cell) for geom in shown] or list(_bones(model, data))
    corners = np.concatenate([piece[0] for piece in pieces])
    finite = np.isfinite(corners).all(axis=(1, 2))
    corners, normals, colours, places, image = (
        np.concatenate([piece[part] for piece in pieces])[finite] for part in range(5)
    )
    if not len(corners):
        raise ValueError("no part of the robot has a place")
    lowest = float(corners[:, :, 2].min())
    images = tuple(textures.images)
    return Seen(corners, normals, colours, places, image, images, _backward(model, data), lowest)


def _shown(model: Any) -> list[int]:
    """The geoms that are seen: those that collide with nothing, and of a robot without any the colliders;
    never the ground."""
    kinds = mujoco.mjtGeom
    solid = {int(kinds.mjGEOM_PLANE), int(kinds.mjGEOM_HFIELD)}
    geoms = [geom for geom in range(model.ngeom) if int(model.geom_type[geom]) not in solid]
    free = [geom for geom in geoms if not model.geom_contype[geom] and not model.geom_conaffinity[geom]]
    for some in (free, geoms):
        found = [geom for geom in some if _colour(model, geom)[3] > _UNSEEN]
        if found:
            return found
    return []


def _colour(model: Any, geom: int) -> Numbers:
    own = np.asarray(model.geom_rgba[geom], dtype=np.float64)
    material = int(model.geom_matid[geom])
    if material >= 0 and np.allclose(own, _NO_GEOM_COLOUR):
        return np.asarray(model.mat_rgba[material], dtype=np.float64)
    return own


_Piece = tuple[Corners, Corners, Numbers, Numbers, Indices]


def _coarse(model: Any, data: Any, geoms: list[int]) -> float:
    """The width of the cells [m] in which all corners of a mesh are one; 0 for a robot with few enough
    triangles to show them all."""
    meshes = [int(model.geom_dataid[geom]) for geom in geoms if int(model.geom_dataid[geom]) >= 0]
    if sum(int(model.mesh_facenum[mesh]) for mesh in meshes) <= _MANY:
        return 0.0
    reach = np.asarray(model.geom_rbound)[geoms, None]
    places = np.asarray(data.geom_xpos)[geoms]
    return float(np.ptp(np.concatenate([places - reach, places + reach]), axis=0).max()) / _CELLS


def _geom(model: Any, data: Any, geom: int, textures: _Textures, cell: float) -> _Piece:
    """The triangles of a geom in the world; of a mesh those that are left in cells of this width [m]."""
    size = np.asarray(model.geom_size[geom])
    kinds = mujoco.mjtGeom
    places = None
    match mujoco.mjtGeom(int(model.geom_type[geom])):
        case kinds.mjGEOM_SPHERE:
            solid = solids.ellipsoid(np.full(3, size[0]))
        case kinds.mjGEOM_ELLIPSOID:
            solid = solids.ellipsoid(size)
        case kinds.mjGEOM_CAPSULE:
            solid = solids.capsule(size[0], size[1])
        case kinds.mjGEOM_CYLINDER:
            solid = solids.cylinder(size[0], size[1])
        case kinds.mjGEOM_BOX:
            solid = solids.box(size)
        case _:
            solid, places = _mesh(model, int(model.geom_dataid[geom]), cell)
    image, repeat, tint = textures.of(model, geom, places is not None)
    colour = _colour(model, geom) * [*tint, 1.0]
    turn = np.asarray(data.geom_xmat[geom]).reshape(3, 3)
    count = len(solid.corners)
    return (
        solid.corners @ turn.T + data.geom_xpos[geom],
        solid.normals @ turn.T,
        np.broadcast_to(colour, (count, 4)),
        np.zeros((count, 3, 2)) if places is None else places * repeat,
        np.full(count, image),
    )


def _mesh(model: Any, mesh: int, cell: float) -> tuple[Skin, Numbers | None]:
    """A mesh, and where its corners are in an image, if the mesh says so."""
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    vertices = np.asarray(model.mesh_vert[first : first + count], dtype=np.float64)
    start, number = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    faces = np.asarray(model.mesh_face[start : start + number], dtype=np.int64)
    places = None
    if cell > 0:
        corners = thinned(vertices[faces], cell)
        return Skin(
            corners, normals_of(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
        ), None
    if (at := int(model.mesh_texcoordadr[mesh])) >= 0:
        which = np.asarray(model.mesh_facetexcoord[start : start + number], dtype=np.int64)
        places = np.asarray(model.mesh_texcoord, dtype=np.float64)[at + which]
    return Skin(vertices[faces], normals_of(vertices, faces)), places


class _Textures:
    """The images of a model's textures, each once."""

    def __init__(self, model: Any) -> None:
        self.images: list[Numbers] = []
        self._known: dict[int, int] = {}

    def of(self, model: Any, geom: int, placed: bool) -> tuple[int, Numbers, Numbers]:
        """The image of a geom (-1 for none), how often it repeats, and the colour that stands for an image
        that is laid on by MuJoCo's own rules."""
        plain = -1, np.ones(2), np.ones(3)
        material = int(model.geom_matid[geom])
        if material < 0:
            return plain
        texture = int(np.reshape(model.mat_texid[material], -1)[int(mujoco.mjtTextureRole.mjTEXROLE_RGB)])
        if texture < 0:
            return plain
        image = self._image(model, texture)
        if not placed or int(model.tex_type[texture]) != int(mujoco.mjtTexture.mjTEXTURE_2D):
            return -1, np.ones(2), self.images[image].reshape(-1, 3).mean(axis=0)
        return image, np.asarray(model.mat_texrepeat[material], dtype=np.float64), np.ones(3)

    def _image(self, model: Any, texture: int) -> int:
        if texture not in self._known:
            channels = int(model.tex_nchannel[texture])
            shape = int(model.tex_height[texture]), int(model.tex_width[texture]), channels
            start = int(model.tex_adr[texture])
            data = np.asarray(model.tex_data[start : start + int(np.prod(shape))]).reshape(shape) / 255.0
            self._known[texture] = len(self.images)
            self.images.append(data[:, :, :3] if channels >= 3 else np.repeat(data[:, :, :1], 3, axis=2))
        return self._known[texture]


def _bones(model: Any, data: Any) -> list[_Piece]:
    """Of a robot without geometry a ball at each body and a bone to its parent."""
    places = np.asarray(data.xpos[1:]) if model.nbody > 1 else np.zeros((1, 3))
    extent = float(np.ptp(places, axis=0).max()) or 0.1
    pieces = []
    for body, place in enumerate(places, start=1):
        pieces.append(_plain(solids.ellipsoid(np.full(3, 0.035 * extent)), np.eye(3), place, _MARKED))
        parent = int(model.body_parentid[body]) if model.nbody > 1 else 0
        along = place - data.xpos[parent] if parent else np.zeros(3)
        length = float(np.linalg.norm(along))
        if length > 0:
            z = along / length
            x = np.cross(z, np.eye(3)[int(np.abs(z).argmin())])
            x = x / np.linalg.norm(x)
            turn = np.stack([x, np.cross(z, x), z], axis=1)
            bone = solids.capsule(0.014 * extent, length / 2)
            pieces.append(_plain(bone, turn, place - along / 2, _BARE))
    return pieces


def _plain(solid: Skin, turn: Numbers, place: Numbers, colour: tuple[float, ...]) -> _Piece:
    count = len(solid.corners)
    return (
        solid.corners @ turn.T + place,
        solid.normals @ turn.T,
        np.broadcast_to(np.array(colour), (count, 4)),
        np.zeros((count, 3, 2)),
        np.full(count, -1),
    )


def _backward(model: Any, data: Any) -> Numbers:
    """The direction from which the scene's camera `overview` looks."""
    camera = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_CAMERA, "overview")
    if camera < 0:
        return _THREE_QUARTER
    return np.array(data.cam_xmat[camera]).reshape(3, 3)[:, 2]
