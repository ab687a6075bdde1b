"""Reads the masses and sizes of the bodies of an MJCF, as MuJoCo compiled it."""

from typing import Any

import mujoco
import numpy as np

from linkwright.stages.robot.model.poses import from_parts
from linkwright.stages.robot.model.robot import Inertial
from linkwright.stages.validate.bare.figures import BareBody, ShapeFigures
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.model.body_shapes import geom_points, outermost_of
from linkwright.stages.validate.model.poses import rotation

_FIRST_HIDDEN_GROUP = 3
"""Number of the first group of geoms that MuJoCo's viewer does not draw by default."""


def figures(model: Any) -> list[BareBody]:
    """Returns every body except the world, in the order of the model. A body with a skin counts as one whose
    shapes could not all be read."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return [_body(model, data, body) for body in range(1, model.nbody)]


def body_name(model: Any, body: int) -> str:
    """Returns the name of a body, or its number if it has no name."""
    return str(model.body(body).name) or f"number {body}"


def _body(model: Any, data: Any, body: int) -> BareBody:
    name = body_name(model, body)
    turn = rotation(model.body_iquat[body])
    inertia = turn @ np.diag(model.body_inertia[body]) @ turn.T
    first = int(model.body_geomadr[body])
    geoms = range(first, first + int(model.body_geomnum[body]))
    shapes = (_shape(model, geom, name) for geom in geoms)
    parent = int(model.body_parentid[body])
    at = f'inertial of body "{name}"'
    return BareBody(
        name,
        body_name(model, parent) if parent else "",
        not model.body_jntnum[body],
        from_parts(data.xmat[body].reshape(3, 3), data.xpos[body]),
        Inertial(float(model.body_mass[body]), model.body_ipos[body].copy(), inertia),
        tuple(shape for shape in shapes if shape is not None),
        body not in model.skin_bonebodyid,
        {
            "inertia": (at, "diaginertia"),
            "centre": (at, "pos"),
            "mass": (at, "mass"),
            "shape": (f'geom of body "{name}"', "size"),
        },
    )


def _shape(model: Any, geom: int, body: str) -> ShapeFigures | None:
    """Returns a geom as a shape; None for a plane or a height field, which has no outermost points."""
    points = geom_points(model, geom)
    if not len(points):
        return None
    collides = bool(model.geom_contype[geom] or model.geom_conaffinity[geom])
    seen = bool(model.geom_group[geom] < _FIRST_HIDDEN_GROUP and model.geom_rgba[geom][3] > 0.0)
    mesh = bool(model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH)
    name = model.geom(geom).name
    title = named("geom", name) if name else named("geom of body", body)
    element, attribute = title, "size"
    if mesh:
        element, attribute = named("mesh", model.mesh(int(model.geom_dataid[geom])).name), "scale"
    group = int(model.geom_group[geom])
    return ShapeFigures(outermost_of(points), collides, seen, mesh, element, attribute, (title, "pos"), group)
