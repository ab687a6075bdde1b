"""Sorts the geoms of a body of a compiled model into visual geoms, colliders, and geoms that are neither."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.fetch.mjcf.compiled.meshes import Meshes
from linkwright.stages.fetch.mjcf.compiled.textures import Textures
from linkwright.stages.formats.mjcf.model import MjcfGeom, MjcfGeomKind, MjcfPlaced
from linkwright.stages.mujoco.bodies import pose_of
from linkwright.stages.mujoco.elements import geom, geom_attributes
from linkwright.stages.mujoco.fields import bare
from linkwright.stages.robot.model.geom_form import ContactProperties, GeomForm
from linkwright.stages.robot.model.geometry import Colour
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array, frozen

GEOMS: Mapping[int, MjcfGeomKind] = {
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "sphere",
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder",
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): "capsule",
    int(mujoco.mjtGeom.mjGEOM_ELLIPSOID): "mesh",
    int(mujoco.mjtGeom.mjGEOM_MESH): "mesh",
}
"""MuJoCo's type of geom → kind. An ellipsoid is a mesh in every format except MJCF."""

_ELLIPSOID, _PLANE = int(mujoco.mjtGeom.mjGEOM_ELLIPSOID), int(mujoco.mjtGeom.mjGEOM_PLANE)

_DEFAULT_COLOUR = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's default colour of a geom; a geom with this colour has its material's colour."""

_FIRST_HIDDEN_GROUP = 3
"""Geoms of this group or above are hidden in MuJoCo's viewer by default."""

_REAL_PROPERTIES = ("friction", "solref", "solimp", "margin", "solmix", "gap")
_INTEGER_PROPERTIES = ("condim", "priority", "contype", "conaffinity")


def can_collide(model: Any, number: int) -> bool:
    """Tells whether another geom can collide with this geom: whether any of its contact bits is set."""
    return bool(model.geom_contype[number] or model.geom_conaffinity[number])


def rgba_of(model: Any, number: int) -> Colour:
    """Returns the geom's own colour; if that is MuJoCo's default, the colour of its material."""
    rgba, material = _colour(model.geom_rgba[number]), int(model.geom_matid[number])
    return rgba if rgba != _DEFAULT_COLOUR or material < 0 else _colour(model.mat_rgba[material])


def is_visual_only(model: Any, number: int) -> bool:
    """Tells whether a geom of the robot is visible and cannot collide."""
    return not can_collide(model, number) and model.geom_bodyid[number] > 0 and rgba_of(model, number)[3] > 0


def is_extra(model: Any, number: int) -> bool:
    """Tells whether only an MJCF can have a geom.

    That is a plane, a primitive that is neither visible nor collides, or a primitive on which a fluid acts,
    next to its visible shape.
    """
    kind = int(model.geom_type[number])
    if kind == _PLANE:
        return True
    is_primitive = kind in GEOMS and (GEOMS[kind] != "mesh" or kind == _ELLIPSOID)
    is_unseen = not is_visual_only(model, number) or model.geom_fluid[number][0] > 0
    return is_primitive and not can_collide(model, number) and bool(is_unseen)


class Geoms:
    """Reader of the geoms of a model; the triangles of its meshes go to `meshes`."""

    def __init__(self, model: Any, meshes: Meshes, textures: Textures) -> None:
        self._model, self._meshes, self._textures = model, meshes, textures
        self._shown = any(is_visual_only(model, number) for number in range(model.ngeom))

    def geoms_of(self, body: int) -> Iterator[MjcfGeom]:
        """Yields a body's shapes.

        A collision geom is visual too if the body has no visual geom of another group, unless it is in a
        hidden group of a model that has visual geoms: viewers draw group by group.
        """
        model = self._model
        visual_groups = {
            int(model.geom_group[number]) for number in self._numbers(body) if is_visual_only(model, number)
        }
        for number in self._numbers(body):
            collides, group = can_collide(model, number), int(model.geom_group[number])
            is_hidden = bool(visual_groups - {group}) or (self._shown and group >= _FIRST_HIDDEN_GROUP)
            is_visible = rgba_of(model, number)[3] > 0 and not (collides and is_hidden)
            if int(model.geom_type[number]) in GEOMS and (collides or is_visible):
                yield self._geom(number, collides, is_visible)

    def _geom(self, number: int, collides: bool, is_visible: bool) -> MjcfGeom:
        model, kind = self._model, int(self._model.geom_type[number])
        rgba = rgba_of(model, number)
        image = self._textures.of(number) if is_visible else ""
        colour = rgba if is_visible and (rgba != _DEFAULT_COLOUR or image) else None
        pose = pose_of(model.geom_pos[number], model.geom_quat[number])
        form, mesh = _form(model, number, collides), None
        if kind == _ELLIPSOID:
            mesh = self._meshes.ellipsoid(form.ellipsoid, colour)
        elif GEOMS[kind] == "mesh":
            data = int(model.geom_dataid[number])
            mesh = self._meshes.ref(data, colour, image)
            pose = pose @ inverse(self._meshes.asset_from_mesh(data))
        size = _size(GEOMS[kind], model.geom_size[number])
        return MjcfGeom(form, GEOMS[kind], size, mesh, frozen(pose), colour, collides, is_visible)

    def unseen(self, body: int) -> tuple[MjcfPlaced, ...]:
        """Returns the geoms that are neither visible nor collide, except meshes, and the geoms that only an
        MJCF can have, such as planes."""
        model = self._model
        return tuple(
            MjcfPlaced(
                frozen(pose_of(model.geom_pos[number], model.geom_quat[number])),
                _extra_element(model, number),
            )
            for number in self._numbers(body)
            if is_extra(model, number)
        )

    def _numbers(self, body: int) -> range:
        """Returns the numbers of the geoms of a body."""
        first = int(self._model.body_geomadr[body])
        return range(first, first + int(self._model.body_geomnum[body]))


def _extra_element(model: Any, number: int) -> Any:
    """Returns a geom as an element, without mass. A geom for a fluid is invisible, as its visible shape is
    elsewhere."""
    element = geom(model, number)
    values = dict(element.attributes) | {"mass": "0"}
    if is_visual_only(model, number) and int(model.geom_type[number]) != _PLANE:
        values["rgba"] = "0 0 0 0"
    return replace(element, attributes=tuple(values.items()))


def _form(model: Any, number: int, collides: bool) -> GeomForm:
    """Returns the name of a geom, its contacts, if any, and its properties that no other format has. If this
    geom is only visible, a fluid acts on another geom."""
    name = model.geom(number).name
    if not collides and is_extra(model, number):
        name = ""
    kind = int(model.geom_type[number])
    attributes = dict(geom_attributes(model, number))
    if not collides:
        attributes.pop("fluidshape", None)
        attributes.pop("fluidcoef", None)
    lengths = tuple(2 * float(half) for half in model.geom_size[number]) if kind == _ELLIPSOID else ()
    return GeomForm(name, _contact(model, number) if collides else None, tuple(attributes.items()), lengths)


def _contact(model: Any, number: int) -> ContactProperties | None:
    """Returns the contact properties of a geom that differ from MuJoCo's defaults."""
    differing: dict[str, Any] = {}
    for name in (*_REAL_PROPERTIES, *_INTEGER_PROPERTIES):
        value, default = getattr(model, f"geom_{name}")[number], getattr(bare(), f"geom_{name}")[-1]
        if not np.array_equal(value, default):
            if name in _INTEGER_PROPERTIES:
                differing[name] = int(value)
            else:
                differing[name] = tuple(map(float, value)) if np.ndim(value) else float(value)
    return ContactProperties(**differing) if differing else None


def _size(kind: MjcfGeomKind, size: Array) -> tuple[float, ...]:
    """Returns the full size: MuJoCo stores radii and half lengths."""
    x, y, z = (float(value) for value in size)
    if kind == "mesh":
        return ()
    if kind == "box":
        return 2 * x, 2 * y, 2 * z
    return (x,) if kind == "sphere" else (x, 2 * y)


def _colour(rgba: Array) -> Colour:
    # Single precision as it is typed: 0.8, not 0.800000011920929.
    r, g, b, a = (float(str(value)) for value in rgba)
    return r, g, b, a
