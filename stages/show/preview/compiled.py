"""What is seen of a robot that MuJoCo compiled, at its keyframe `home`."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.compile import NotCompiled, compiled_text
from linkwright.stages.mujoco.names import index_of, name_of
from linkwright.stages.mujoco.state import at_key, keyframe_of
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.show.preview.look import Blob, Geom, Look, Solid, Vector
from linkwright.stages.show.preview.model_text import Mesh, mjcf_text, urdf_text
from linkwright.stages.show.raster import Numbers

_BARE = (0.45, 0.49, 0.54, 1.0)
_MARKED = (0.93, 0.45, 0.16, 1.0)
"""Colours of what is drawn of a robot without any geometry: bones, and joints."""

_UNSEEN = 0.02
_NO_GEOM_COLOUR = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's default, which says that the material's colour holds."""

_THREE_QUARTER = (0.668, -0.602, 0.401)
"""Where the camera stands where the scene has none: in front, to the robot's right, above."""

_DIGITS = 9
"""Of a place [m], and of a direction: less than that is rounding noise."""


def look_of_files(path: str, files: Mapping[str, bytes]) -> Look:
    """What is seen of a robot whose file at `path` is a scene or a URDF. SourceError where MuJoCo cannot
    compile it."""
    try:
        if path.endswith(".urdf"):
            text, own = urdf_text(path, files)
            return look_of(compiled_text(text, own), _home(files["robot.json"]))
        for whole in (False, True):
            made = mjcf_text(path, files, whole=whole)
            try:
                return look_of(compiled_text(made.text, made.files), {}, made.meshes)
            except NotCompiled:
                # Without its meshes a body may have no mass.
                if whole or not made.meshes:
                    raise
    except (ValueError, KeyError) as error:
        words = " ".join(str(error).split())[:300]
        raise SourceError(f"MuJoCo cannot compile {path}: {words}", path) from None
    raise AssertionError


def _home(robot: bytes) -> dict[str, float]:
    """The joints' values at home, for a model that has no keyframe."""
    for keyframe in json.loads(robot).get("keyframes", []):
        if keyframe["name"] == "home":
            values = keyframe["values"].items()
            return {name: float(value) for name, value in values if isinstance(value, int | float)}
    return {}


def look_of(model: Any, values: Mapping[str, float], meshes: Mapping[str, Mesh] | None = None) -> Look:
    """What is seen of a model at `home`, or, where it has no such keyframe, with the joints' `values`
    [rad, m] by name and the others at zero. `meshes`: those of geoms by name, in place of MuJoCo's own."""
    home = keyframe_of(model, "home")
    data = at_key(model, home)
    for joint in range(model.njnt if home < 0 else 0):
        name = name_of(model, mujoco.mjtObj.mjOBJ_JOINT, joint)
        if name in values:
            data.qpos[model.jnt_qposadr[joint]] = values[name]
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)
    blobs = _Blobs(model, meshes or {})
    geoms = [_geom(model, data, geom, blobs) for geom in _shown(model)] or list(_bones(model, data))
    return Look(tuple(geoms), _backward(model, data), tuple(blobs.found))


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


def _geom(model: Any, data: Any, geom: int, blobs: _Blobs) -> Geom:
    solid, size, blob, scale = _solid(model, geom, blobs)
    image, repeat, tint = blobs.texture(geom, placed=blob >= 0)
    return Geom(
        solid,
        size,
        _vector(data.geom_xpos[geom]),
        _vector(data.geom_xmat[geom]),
        _vector(_colour(model, geom) * [*tint, 1.0]),
        blob,
        scale,
        image,
        _vector(repeat),
    )


def _solid(model: Any, geom: int, blobs: _Blobs) -> tuple[Solid, Vector, int, Vector]:
    """The solid of a geom, its size, and of a mesh its blob and its scale."""
    size, whole = _vector(model.geom_size[geom]), (1.0, 1.0, 1.0)
    mesh = blobs.meshes.get(name_of(model, mujoco.mjtObj.mjOBJ_GEOM, geom))
    if mesh is not None:
        return "mesh", (), blobs.stl(mesh), mesh.scale
    kinds = mujoco.mjtGeom
    match mujoco.mjtGeom(int(model.geom_type[geom])):
        case kinds.mjGEOM_SPHERE:
            return "ellipsoid", size[:1] * 3, -1, whole
        case kinds.mjGEOM_ELLIPSOID:
            return "ellipsoid", size, -1, whole
        case kinds.mjGEOM_CAPSULE:
            return "capsule", size[:2], -1, whole
        case kinds.mjGEOM_CYLINDER:
            return "cylinder", size[:2], -1, whole
        case kinds.mjGEOM_BOX:
            return "box", size, -1, whole
        case _:
            return "mesh", (), blobs.mesh(int(model.geom_dataid[geom])), whole


class _Blobs:
    """The meshes and images of a model, each once. `meshes`: those of geoms, by name."""

    def __init__(self, model: Any, meshes: Mapping[str, Mesh]) -> None:
        self.meshes = meshes
        self.found: list[Blob] = []
        self._model = model
        self._known: dict[object, int] = {}

    def stl(self, mesh: Mesh) -> int:
        """The number of the blob with the file of a mesh."""
        return self._kept(mesh.path, lambda: Blob("stl", mesh.data))

    def mesh(self, mesh: int) -> int:
        """The number of the blob with a mesh as MuJoCo compiled it."""
        return self._kept(("mesh", mesh), lambda: Blob("corners", self._corners(mesh)))

    def _kept(self, key: object, made: Any) -> int:
        if key not in self._known:
            self._known[key] = len(self.found)
            self.found.append(made())
        return self._known[key]

    def _corners(self, mesh: int) -> bytes:
        """The corners of a mesh, and where they are in an image, if the mesh says so."""
        model = self._model
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        vertices = np.asarray(model.mesh_vert[first : first + count], dtype="<f4")
        start, number = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        corners = vertices[np.asarray(model.mesh_face[start : start + number])]
        places = np.zeros((number, 3, 2), dtype="<f4")
        if (at := int(model.mesh_texcoordadr[mesh])) >= 0:
            which = np.asarray(model.mesh_facetexcoord[start : start + number])
            places = np.asarray(model.mesh_texcoord, dtype="<f4")[at + which]
        return bytes(corners.tobytes() + places.tobytes())

    def texture(self, geom: int, *, placed: bool) -> tuple[int, Numbers, Numbers]:
        """The blob of the image of a geom (-1 for none), how often it repeats, and the colour that stands for
        an image that is laid on by MuJoCo's own rules."""
        model = self._model
        plain = -1, np.ones(2), np.ones(3)
        material = int(model.geom_matid[geom])
        if material < 0:
            return plain
        texture = int(np.reshape(model.mat_texid[material], -1)[int(mujoco.mjtTextureRole.mjTEXROLE_RGB)])
        if texture < 0:
            return plain
        pixels = self._pixels(texture)
        is_flat = int(model.tex_type[texture]) == int(mujoco.mjtTexture.mjTEXTURE_2D)
        mesh = int(model.geom_dataid[geom])
        if not placed or not is_flat or mesh < 0 or int(model.mesh_texcoordadr[mesh]) < 0:
            return -1, np.ones(2), pixels.reshape(-1, 3).mean(axis=0) / 255.0
        image = self._kept(("image", texture), lambda: Blob("image", pixels.tobytes(), len(pixels)))
        return image, np.asarray(model.mat_texrepeat[material], dtype=np.float64), np.ones(3)

    def _pixels(self, texture: int) -> Any:
        """(height, width, 3) of bytes."""
        model = self._model
        channels = int(model.tex_nchannel[texture])
        shape = int(model.tex_height[texture]), int(model.tex_width[texture]), channels
        start = int(model.tex_adr[texture])
        data = np.asarray(model.tex_data[start : start + int(np.prod(shape))]).reshape(shape)
        return np.ascontiguousarray(data[:, :, :3] if channels >= 3 else np.repeat(data[:, :, :1], 3, axis=2))


def _bones(model: Any, data: Any) -> Iterator[Geom]:
    """Of a robot without geometry a ball at each body and a bone to its parent."""
    places = np.asarray(data.xpos[1:]) if model.nbody > 1 else np.zeros((1, 3))
    extent = float(np.ptp(places, axis=0).max()) or 0.1
    for body, place in enumerate(places, start=1):
        ball = (0.035 * extent,) * 3
        yield Geom("ellipsoid", ball, _vector(place), _vector(np.eye(3)), _MARKED)
        parent = int(model.body_parentid[body]) if model.nbody > 1 else 0
        along = place - data.xpos[parent] if parent else np.zeros(3)
        length = float(np.linalg.norm(along))
        if length > 0:
            z = along / length
            x = np.cross(z, np.eye(3)[int(np.abs(z).argmin())])
            x = x / np.linalg.norm(x)
            turn = np.stack([x, np.cross(z, x), z], axis=1)
            size = (0.014 * extent, length / 2)
            yield Geom("capsule", size, _vector(place - along / 2), _vector(turn), _BARE)


def _backward(model: Any, data: Any) -> Vector:
    """The direction from which the scene's camera `overview` looks."""
    camera = index_of(model, mujoco.mjtObj.mjOBJ_CAMERA, "overview")
    if camera < 0:
        return _THREE_QUARTER
    return _vector(np.array(data.cam_xmat[camera]).reshape(3, 3)[:, 2])


def _vector(numbers: Any) -> Vector:
    return tuple(round(float(number), _DIGITS) + 0.0 for number in np.reshape(numbers, -1))
