"""The geoms of a body of a compiled model: what is seen, what collides, and what is neither."""

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
"""An ellipsoid is a mesh to all but MuJoCo."""

_ELLIPSOID, _PLANE = int(mujoco.mjtGeom.mjGEOM_ELLIPSOID), int(mujoco.mjtGeom.mjGEOM_PLANE)

_DEFAULT = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's default colour of a geom; with it, the material's colour is used."""

_SHOWN = 3
"""Geoms of this group or above are hidden in MuJoCo's viewer by default."""

_NUMBERS = ("friction", "solref", "solimp", "margin", "solmix", "gap")
_WHOLE = ("condim", "priority", "contype", "conaffinity")


def touches(model: Any, number: int) -> bool:
    """Whether another geom can collide with this one by its bits."""
    return bool(model.geom_contype[number] or model.geom_conaffinity[number])


def rgba_of(model: Any, number: int) -> Colour:
    """The geom's own colour, else its material's."""
    own, material = _colour(model.geom_rgba[number]), int(model.geom_matid[number])
    return own if own != _DEFAULT or material < 0 else _colour(model.mat_rgba[material])


def shows(model: Any, number: int) -> bool:
    """Whether a geom is only visual."""
    return not touches(model, number) and model.geom_bodyid[number] > 0 and rgba_of(model, number)[3] > 0


def is_extra(model: Any, number: int) -> bool:
    """Whether a geom is an MJCF's alone: a plane, and a primitive that is neither seen nor collides, or that
    a fluid acts on beside what is seen of it."""
    kind = int(model.geom_type[number])
    if kind == _PLANE:
        return True
    primitive = kind in GEOMS and (GEOMS[kind] != "mesh" or kind == _ELLIPSOID)
    unseen = not shows(model, number) or model.geom_fluid[number][0] > 0
    return primitive and not touches(model, number) and bool(unseen)


class Geoms:
    """Reads the geoms of a model; the triangles of its meshes go to `meshes`."""

    def __init__(self, model: Any, meshes: Meshes, textures: Textures) -> None:
        self._model, self._meshes, self._textures = model, meshes, textures
        self._shown = any(shows(model, number) for number in range(model.ngeom))

    def of(self, body: int) -> Iterator[MjcfGeom]:
        """A body's shapes. A collision geom is visual too where the body has no visual geom of another group,
        unless it is in a hidden group of a model that has visual geoms: viewers draw group by group."""
        model = self._model
        dress = {int(model.geom_group[number]) for number in self._numbers(body) if shows(model, number)}
        for number in self._numbers(body):
            collides, group = touches(model, number), int(model.geom_group[number])
            hidden = bool(dress - {group}) or (self._shown and group >= _SHOWN)
            seen = rgba_of(model, number)[3] > 0 and not (collides and hidden)
            if int(model.geom_type[number]) in GEOMS and (collides or seen):
                yield self._geom(number, collides, seen)

    def _geom(self, number: int, collides: bool, seen: bool) -> MjcfGeom:
        model, kind = self._model, int(self._model.geom_type[number])
        rgba = rgba_of(model, number)
        image = self._textures.of(number) if seen else ""
        colour = rgba if seen and (rgba != _DEFAULT or image) else None
        pose = pose_of(model.geom_pos[number], model.geom_quat[number])
        form, mesh = _form(model, number, collides), None
        if kind == _ELLIPSOID:
            mesh = self._meshes.ellipsoid(form.ellipsoid, colour)
        elif GEOMS[kind] == "mesh":
            data = int(model.geom_dataid[number])
            mesh = self._meshes.ref(data, colour, image)
            pose = pose @ inverse(self._meshes.asset_from_mesh(data))
        size = _size(GEOMS[kind], model.geom_size[number])
        return MjcfGeom(form, GEOMS[kind], size, mesh, frozen(pose), colour, collides, seen)

    def unseen(self, body: int) -> tuple[MjcfPlaced, ...]:
        """What is neither seen nor collides, but for meshes, and what only an MJCF has, as planes."""
        model = self._model
        return tuple(
            MjcfPlaced(
                frozen(pose_of(model.geom_pos[number], model.geom_quat[number])), _unseen(model, number)
            )
            for number in self._numbers(body)
            if is_extra(model, number)
        )

    def _numbers(self, body: int) -> range:
        first = int(self._model.body_geomadr[body])
        return range(first, first + int(self._model.body_geomnum[body]))


def _unseen(model: Any, number: int) -> Any:
    """A geom as an element, without mass; what a fluid acts on is not seen a second time."""
    found = geom(model, number)
    own = dict(found.attributes) | {"mass": "0"}
    if shows(model, number) and int(model.geom_type[number]) != _PLANE:
        own["rgba"] = "0 0 0 0"
    return replace(found, attributes=tuple(own.items()))


def _form(model: Any, number: int, collides: bool) -> GeomForm:
    """The name of a geom, its contacts where it has some, and what no other format has of it; what a fluid
    acts on is another geom where this is only seen."""
    own = model.geom(number).name
    if not collides and is_extra(model, number):
        own = ""
    kind = int(model.geom_type[number])
    more = dict(geom_attributes(model, number))
    if not collides:
        more.pop("fluidshape", None)
        more.pop("fluidcoef", None)
    lengths = tuple(2 * float(half) for half in model.geom_size[number]) if kind == _ELLIPSOID else ()
    return GeomForm(own, _contact(model, number) if collides else None, tuple(more.items()), lengths)


def _contact(model: Any, number: int) -> ContactProperties | None:
    """What a geom has otherwise than MuJoCo's default."""
    given: dict[str, Any] = {}
    for name in (*_NUMBERS, *_WHOLE):
        value, usual = getattr(model, f"geom_{name}")[number], getattr(bare(), f"geom_{name}")[-1]
        if not np.array_equal(value, usual):
            if name in _WHOLE:
                given[name] = int(value)
            else:
                given[name] = tuple(map(float, value)) if np.ndim(value) else float(value)
    return ContactProperties(**given) if given else None


def _size(kind: MjcfGeomKind, size: Array) -> tuple[float, ...]:
    """The full size: MuJoCo stores radii, and half lengths."""
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
