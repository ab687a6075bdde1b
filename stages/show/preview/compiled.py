"""Takes the look of a robot from the model that MuJoCo compiled, at its keyframe `home`."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.compile import NotCompiled, compiled_text
from linkwright.stages.mujoco.names import index_of, name_of
from linkwright.stages.mujoco.state import at_keyframe_index, keyframe_index
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.show.preview.bones import bones
from linkwright.stages.show.preview.look import (
    THREE_QUARTER,
    UNSEEN,
    Blob,
    Geom,
    Look,
    Solid,
    Vector,
)
from linkwright.stages.show.preview.model_text import ScaledStl, mjcf_text, urdf_text
from linkwright.stages.show.preview.vectors import vector
from linkwright.stages.show.raster import Numbers

_NO_GEOM_COLOUR = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's default colour of geoms; a geom with this colour has the colour of its material."""


def look_of_files(path: str, files: Mapping[str, bytes]) -> Look:
    """Returns the look of a robot whose file at `path` is a scene or a URDF. Raises SourceError if MuJoCo
    cannot compile it."""
    try:
        if path.endswith(".urdf"):
            model = urdf_text(path, files)
            return look_of(compiled_text(model.text, model.files), _home_values(files["robot.json"]))
        for keeps_meshes in (False, True):
            model = mjcf_text(path, files, keep_meshes=keeps_meshes)
            try:
                return look_of(compiled_text(model.text, model.files), {}, model.meshes)
            except NotCompiled:
                # Without its meshes a body may have no mass.
                if keeps_meshes or not model.meshes:
                    raise
    except (ValueError, KeyError) as error:
        words = " ".join(str(error).split())[:300]
        raise SourceError(f"MuJoCo cannot compile {path}: {words}", path) from None
    raise AssertionError


def _home_values(robot: bytes) -> dict[str, float]:
    """Returns the joints' values at home from robot.json, for a model without keyframes."""
    for keyframe in json.loads(robot).get("keyframes", []):
        if keyframe["name"] == "home":
            values = keyframe["values"].items()
            return {name: float(value) for name, value in values if isinstance(value, int | float)}
    return {}


def look_of(model: Any, values: Mapping[str, float], meshes: Mapping[str, ScaledStl] | None = None) -> Look:
    """Returns the look of a model at `home`, or, without such a keyframe, with the joints' `values` [rad, m]
    by name and the other joints at zero. `meshes`: the meshes of geoms by name, in place of MuJoCo's own."""
    home = keyframe_index(model, "home")
    data = at_keyframe_index(model, home)
    for joint in range(model.njnt if home < 0 else 0):
        name = name_of(model, mujoco.mjtObj.mjOBJ_JOINT, joint)
        if name in values:
            data.qpos[model.jnt_qposadr[joint]] = values[name]
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)
    blobs = _Blobs(model, meshes or {})
    geoms = [_geom(model, data, geom, blobs) for geom in _visible_geoms(model)] or list(_bones(model, data))
    return Look(tuple(geoms), _backward(model, data), tuple(blobs.blobs))


def _visible_geoms(model: Any) -> list[int]:
    """Returns the visible geoms: the purely visual geoms, else the colliders; never the ground."""
    kinds = mujoco.mjtGeom
    ground = {int(kinds.mjGEOM_PLANE), int(kinds.mjGEOM_HFIELD)}
    geoms = [geom for geom in range(model.ngeom) if int(model.geom_type[geom]) not in ground]
    visual = [geom for geom in geoms if not model.geom_contype[geom] and not model.geom_conaffinity[geom]]
    for candidates in (visual, geoms):
        visible = [geom for geom in candidates if _colour(model, geom)[3] > UNSEEN]
        if visible:
            return visible
    return []


def _colour(model: Any, geom: int) -> Numbers:
    rgba = np.asarray(model.geom_rgba[geom], dtype=np.float64)
    material = int(model.geom_matid[geom])
    if material >= 0 and np.allclose(rgba, _NO_GEOM_COLOUR):
        return np.asarray(model.mat_rgba[material], dtype=np.float64)
    return rgba


def _geom(model: Any, data: Any, geom: int, blobs: _Blobs) -> Geom:
    solid, size, blob, scale = _solid(model, geom, blobs)
    image, repeat, tint = blobs.texture(geom, has_own_mesh=blob >= 0)
    return Geom(
        solid,
        size,
        vector(data.geom_xpos[geom]),
        vector(data.geom_xmat[geom]),
        vector(_colour(model, geom) * [*tint, 1.0]),
        blob,
        scale,
        image,
        vector(repeat),
    )


def _solid(model: Any, geom: int, blobs: _Blobs) -> tuple[Solid, Vector, int, Vector]:
    """Returns the solid of a geom, its size, and for a mesh its blob and its scale."""
    size, unscaled = vector(model.geom_size[geom]), (1.0, 1.0, 1.0)
    mesh = blobs.meshes.get(name_of(model, mujoco.mjtObj.mjOBJ_GEOM, geom))
    if mesh is not None:
        return "mesh", (), blobs.stl(mesh), mesh.scale
    kinds = mujoco.mjtGeom
    match mujoco.mjtGeom(int(model.geom_type[geom])):
        case kinds.mjGEOM_SPHERE:
            return "ellipsoid", size[:1] * 3, -1, unscaled
        case kinds.mjGEOM_ELLIPSOID:
            return "ellipsoid", size, -1, unscaled
        case kinds.mjGEOM_CAPSULE:
            return "capsule", size[:2], -1, unscaled
        case kinds.mjGEOM_CYLINDER:
            return "cylinder", size[:2], -1, unscaled
        case kinds.mjGEOM_BOX:
            return "box", size, -1, unscaled
        case _:
            return "mesh", (), blobs.mesh(int(model.geom_dataid[geom])), unscaled


class _Blobs:
    """Collects the meshes and images of a model, each once. `meshes`: the meshes of geoms, by name."""

    def __init__(self, model: Any, meshes: Mapping[str, ScaledStl]) -> None:
        self.meshes = meshes
        self.blobs: list[Blob] = []
        self._model = model
        self._numbers: dict[object, int] = {}

    def stl(self, mesh: ScaledStl) -> int:
        """Returns the index of the blob with the file of a mesh."""
        return self._stored(mesh.path, lambda: Blob("stl", mesh.data))

    def mesh(self, mesh: int) -> int:
        """Returns the index of the blob with a mesh as MuJoCo compiled it."""
        return self._stored(("mesh", mesh), lambda: Blob("corners", self._corners(mesh)))

    def _stored(self, key: object, make: Any) -> int:
        if key not in self._numbers:
            self._numbers[key] = len(self.blobs)
            self.blobs.append(make())
        return self._numbers[key]

    def _corners(self, mesh: int) -> bytes:
        """Returns the corners of a mesh, then their places in an image (0 without texture coordinates), as in
        `Blob.data`."""
        model = self._model
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        vertices = np.asarray(model.mesh_vert[first : first + count], dtype="<f4")
        start, number = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        corners = vertices[np.asarray(model.mesh_face[start : start + number])]
        places = np.zeros((number, 3, 2), dtype="<f4")
        if (texcoord_start := int(model.mesh_texcoordadr[mesh])) >= 0:
            texcoord_indices = np.asarray(model.mesh_facetexcoord[start : start + number])
            places = np.asarray(model.mesh_texcoord, dtype="<f4")[texcoord_start + texcoord_indices]
        return bytes(corners.tobytes() + places.tobytes())

    def texture(self, geom: int, *, has_own_mesh: bool) -> tuple[int, Numbers, Numbers]:
        """Returns the index of the blob with a geom's image (-1 without one), its repetition, and a factor of
        the geom's colour: the mean colour of an image that MuJoCo maps by its own rules, else white."""
        model = self._model
        without_image = -1, np.ones(2), np.ones(3)
        material = int(model.geom_matid[geom])
        if material < 0:
            return without_image
        texture = int(np.reshape(model.mat_texid[material], -1)[int(mujoco.mjtTextureRole.mjTEXROLE_RGB)])
        if texture < 0:
            return without_image
        pixels = self._pixels(texture)
        is_flat = int(model.tex_type[texture]) == int(mujoco.mjtTexture.mjTEXTURE_2D)
        mesh = int(model.geom_dataid[geom])
        if not has_own_mesh or not is_flat or mesh < 0 or int(model.mesh_texcoordadr[mesh]) < 0:
            return -1, np.ones(2), pixels.reshape(-1, 3).mean(axis=0) / 255.0
        image = self._stored(("image", texture), lambda: Blob("image", pixels.tobytes(), len(pixels)))
        return image, np.asarray(model.mat_texrepeat[material], dtype=np.float64), np.ones(3)

    def _pixels(self, texture: int) -> Any:
        """Returns the pixels (height, width, 3) of a texture as bytes."""
        model = self._model
        channels = int(model.tex_nchannel[texture])
        shape = int(model.tex_height[texture]), int(model.tex_width[texture]), channels
        start = int(model.tex_adr[texture])
        data = np.asarray(model.tex_data[start : start + int(np.prod(shape))]).reshape(shape)
        return np.ascontiguousarray(data[:, :, :3] if channels >= 3 else np.repeat(data[:, :, :1], 3, axis=2))


def _bones(model: Any, data: Any) -> Iterator[Geom]:
    """Returns the shapes of a robot without geometry."""
    if model.nbody == 1:
        return bones(np.zeros((1, 3)), [None])
    parents = [int(parent) - 1 if parent else None for parent in model.body_parentid[1:]]
    return bones(np.asarray(data.xpos[1:]), parents)


def _backward(model: Any, data: Any) -> Vector:
    """Returns the direction from the robot to the scene's camera `overview`, else a three-quarter view."""
    camera = index_of(model, mujoco.mjtObj.mjOBJ_CAMERA, "overview")
    if camera < 0:
        return THREE_QUARTER
    return vector(np.array(data.cam_xmat[camera]).reshape(3, 3)[:, 2])
