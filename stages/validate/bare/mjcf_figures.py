"""The bodies of an MJCF by mass and size, as MuJoCo compiled it."""

from typing import Any

import mujoco
import numpy as np

from stages.validate.bare.figures import ShapeFigures, WeighedBody, box_corners
from stages.validate.findings import named
from stages.validate.mujoco_poses import placed, rotation

_ENDLESS = (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_HFIELD)


def figures(model: Any) -> list[WeighedBody]:
    """Every body but the world, in the order of the model."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return [_body(model, data, body) for body in range(1, model.nbody)]


def body_name(model: Any, body: int) -> str:
    """The name of a body; of one without, its number."""
    return str(model.body(body).name) or f"number {body}"


def _body(model: Any, data: Any, body: int) -> WeighedBody:
    name = body_name(model, body)
    turn = rotation(model.body_iquat[body])
    inertia = turn @ np.diag(model.body_inertia[body]) @ turn.T
    first = int(model.body_geomadr[body])
    geoms = range(first, first + int(model.body_geomnum[body]))
    shapes = tuple(_shape(model, geom, name) for geom in geoms if model.geom_type[geom] not in _ENDLESS)
    parent = int(model.body_parentid[body])
    at = f'inertial of body "{name}"'
    return WeighedBody(
        name,
        body_name(model, parent) if parent else "",
        not model.body_jntnum[body],
        data.xpos[body].copy(),
        float(model.body_mass[body]),
        model.body_ipos[body].copy(),
        inertia,
        shapes,
        True,
        (at, "mass"),
        (at, "diaginertia"),
        (at, "pos"),
    )


def _shape(model: Any, geom: int, body: str) -> ShapeFigures:
    pose = placed(model.geom_quat[geom], model.geom_pos[geom])
    corners = box_corners(model.geom_aabb[geom][:3], model.geom_aabb[geom][3:], pose)
    collides = bool(model.geom_contype[geom] or model.geom_conaffinity[geom])
    mesh = model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH
    own = model.geom(geom).name
    called = named("geom", own) if own else named("geom of body", body)
    element, attribute = called, "size"
    if mesh:
        element, attribute = named("mesh", model.mesh(int(model.geom_dataid[geom])).name), "scale"
    return ShapeFigures(corners, collides, bool(mesh), element, attribute, (called, "pos"))
