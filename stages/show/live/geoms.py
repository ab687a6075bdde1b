"""Describes the geoms for the header: visual, colliding, and the ground."""

from typing import Any

import mujoco
import numpy as np

from linkwright.stages.show.live.compiled import LiveModel
from linkwright.stages.show.live.rounding import rounded_list

_GEOM = mujoco.mjtObj.mjOBJ_GEOM
_TYPES = {
    mujoco.mjtGeom.mjGEOM_PLANE: "plane",
    mujoco.mjtGeom.mjGEOM_HFIELD: "mesh",
    mujoco.mjtGeom.mjGEOM_SPHERE: "sphere",
    mujoco.mjtGeom.mjGEOM_CAPSULE: "capsule",
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: "ellipsoid",
    mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder",
    mujoco.mjtGeom.mjGEOM_BOX: "box",
    mujoco.mjtGeom.mjGEOM_MESH: "mesh",
    mujoco.mjtGeom.mjGEOM_SDF: "mesh",
}
_DEFAULT_COLOUR = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's default colour of a geom; a geom with this colour has the colour of its material."""

_COLOUR_ROLES = (mujoco.mjtTextureRole.mjTEXROLE_RGB, mujoco.mjtTextureRole.mjTEXROLE_RGBA)
"""The roles of a material's textures that colour it."""

_FIRST_HIDDEN_GROUP = 3
"""MuJoCo's viewers hide geom groups from this number on; by convention colliders are in hidden groups."""

Source = tuple[str, int]
"""The triangles of a geom in the model: ("mesh" or "hfield", index)."""


def geoms(live: LiveModel) -> list[tuple[dict[str, Any], Source | None]]:
    """Returns the geoms, with `mesh` not yet set, and the source of each geom's triangles.

    A collider in a group that viewers show, as in a file of another tool, is listed twice: as visual and as
    collider. For a robot without any visual geom the colliders are visual too.
    """
    # The groups in a URDF's model are MuJoCo's own, not the author's.
    groups = _FIRST_HIDDEN_GROUP if live.document is not None else 0
    pairs = {*live.model.pair_geom1.tolist(), *live.model.pair_geom2.tolist()}
    roles_of_geoms = [(index, _roles(live.model, index, groups, pairs)) for index in range(live.model.ngeom)]
    if not any("visual" in roles for _, roles in roles_of_geoms):
        roles_of_geoms = [(index, [*roles, *_as_visual(roles)]) for index, roles in roles_of_geoms]
    return [
        (_entry(live, index, role), _source(live.model, index))
        for index, roles in roles_of_geoms
        for role in roles
    ]


def _as_visual(roles: list[str]) -> list[str]:
    return ["visual"] if "collision" in roles else []


def _roles(model: Any, index: int, first_hidden_group: int, pairs: set[int]) -> list[str]:
    kind = mujoco.mjtGeom(int(model.geom_type[index]))
    if kind not in _TYPES:
        return []
    if model.geom_bodyid[index] == 0 and kind in (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_HFIELD):
        return ["ground"]
    collides = bool(model.geom_contype[index] or model.geom_conaffinity[index] or index in pairs)
    is_visible = not collides or model.geom_group[index] < first_hidden_group
    return [*(["visual"] if is_visible else []), *(["collision"] if collides else [])]


def _entry(live: LiveModel, index: int, role: str) -> dict[str, Any]:
    model = live.model
    return {
        "body": int(model.geom_bodyid[index]),
        "role": role,
        "type": _TYPES[mujoco.mjtGeom(int(model.geom_type[index]))],
        "size": rounded_list(model.geom_size[index]),
        "pos": rounded_list(model.geom_pos[index]),
        "quat": rounded_list(model.geom_quat[index]),
        "rgba": _colour(model, index),
        "mesh": None,
        "name": live.name(_GEOM, index),
    }


def _source(model: Any, index: int) -> Source | None:
    kind = mujoco.mjtGeom(int(model.geom_type[index]))
    if _TYPES[kind] != "mesh":
        return None
    return ("hfield" if kind == mujoco.mjtGeom.mjGEOM_HFIELD else "mesh", int(model.geom_dataid[index]))


def _colour(model: Any, index: int) -> list[float]:
    """Returns the geom's colour, times the mean colour of its image: the page shows no textures."""
    rgba = model.geom_rgba[index].astype(np.float64)
    material = int(model.geom_matid[index])
    if material < 0 or not np.allclose(rgba, _DEFAULT_COLOUR):
        return _rounded(rgba)
    colour = model.mat_rgba[material].astype(np.float64)
    # A material may also have textures without a colour, such as normals.
    for texture in (int(model.mat_texid[material, int(role)]) for role in _COLOUR_ROLES):
        if texture >= 0:
            colour[:3] *= _mean_colour(model, texture)
    return _rounded(colour)


def _mean_colour(model: Any, texture: int) -> Any:
    """Returns the mean colour (3,) of a texture, from 0 to 1."""
    channels = int(model.tex_nchannel[texture])
    size = int(model.tex_width[texture]) * int(model.tex_height[texture]) * channels
    start = int(model.tex_adr[texture])
    pixels = model.tex_data[start : start + size].reshape(-1, channels)
    return np.resize(pixels.mean(axis=0)[:3] / 255.0, 3)


def _rounded(colour: Any) -> list[float]:
    return [round(float(channel), 4) + 0.0 for channel in np.clip(colour, 0.0, 1.0)]
