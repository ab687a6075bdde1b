"""Converts a model that MuJoCo compiled to values of our own."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import mujoco
import numpy as np

from stages.fetch.mjcf.actuation import Numbers, actuator, driven, sensor
from stages.fetch.mjcf.effort import efforts
from stages.fetch.mjcf.keyframes import keyframes
from stages.fetch.mjcf.meshes import Meshes, placed
from stages.fetch.mjcf.textures import Textures
from stages.fetch.mjcf.unsupported import carried, left_out
from stages.formats.mjcf import (
    Mjcf,
    MjcfBody,
    MjcfClosure,
    MjcfGeom,
    MjcfGeomKind,
    MjcfJoint,
    MjcfJointType,
    MjcfRelation,
    MjcfSite,
)
from stages.robot.errors import SourceError
from stages.robot.geometry import Colour
from stages.robot.inertia import moved
from stages.robot.model import Array, Dynamics, Inertial, Limits, frozen
from stages.robot.poses import inverse

JOINTS: Mapping[int, MjcfJointType] = {
    mujoco.mjtJoint.mjJNT_HINGE: "hinge",
    mujoco.mjtJoint.mjJNT_SLIDE: "slide",
    mujoco.mjtJoint.mjJNT_BALL: "ball",
    mujoco.mjtJoint.mjJNT_FREE: "free",
}

GEOMS: Mapping[int, MjcfGeomKind] = {
    mujoco.mjtGeom.mjGEOM_BOX: "box",
    mujoco.mjtGeom.mjGEOM_SPHERE: "sphere",
    mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder",
    mujoco.mjtGeom.mjGEOM_CAPSULE: "capsule",
    mujoco.mjtGeom.mjGEOM_MESH: "mesh",
}

_OPEN = 1e6
"""A bound [rad or m] beyond which a side counts as open: MuJoCo has no one-sided range."""

_PLAIN = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's default colour of a geom; with it, the material's colour is used."""

_SHOWN = 3
"""Geoms of this group or above are hidden in MuJoCo's viewer by default."""

_FINITE = (
    *("qpos0", "body_pos", "body_quat", "body_mass", "body_ipos", "body_iquat", "body_inertia"),
    *("jnt_pos", "jnt_axis", "jnt_range", "geom_pos", "geom_quat", "geom_size", "site_pos", "site_quat"),
    *("eq_data", "dof_damping", "dof_frictionloss", "dof_armature", "key_qpos"),
)
"""Arrays that must be finite: MuJoCo compiles a NaN with only a warning."""


def convert(
    model: mujoco.MjModel, spec: mujoco.MjSpec, meshes: Meshes, textures: Textures, where: str
) -> Mjcf:
    """The model as a value; `spec` is what it was compiled from, and `where` names its file. SourceError
    where a number is not finite.

    Mocap bodies are no part of a robot and are left out with all below them.
    """
    if model.nbody < 2:
        msg = "not readable as an MJCF: it has no body"
        raise SourceError(msg, where, "a robot's links are the <body>s of its <worldbody>")
    _require_finite(model, where)
    kept = _kept(model)
    numbers = {body: number for number, body in enumerate(kept)}
    joints = [joint for joint in range(model.njnt) if int(model.jnt_bodyid[joint]) in numbers]
    sites = _of_bodies(model.site_bodyid)
    shown = any(geom_shows(model, geom) for geom in range(model.ngeom))
    limits = efforts(model)
    bodies = []
    for body in kept:
        first = int(model.body_jntadr[body])
        own = range(first, first + int(model.body_jntnum[body]))
        bodies.append(
            MjcfBody(
                name=model.body(body).name,
                parent=numbers[int(model.body_parentid[body])],
                parent_from_body=placed(model.body_pos[body], model.body_quat[body]),
                inertial=_inertial(model, body),
                joints=tuple(_joint(model, joint, limits) for joint in own),
                geoms=tuple(_geoms(model, body, meshes, textures, shown)) if body else (),
                sites=tuple(_site(model, site) for site in sites.get(body, ()) if model.site(site).name),
            )
        )
    order = {joint: number for number, joint in enumerate(joints)}
    acting = driven(model, numbers)
    places = _numbers(model, numbers, order, acting, kept, sites)
    sensors = {one: sensor(model, one, places) for one in range(model.nsensor)}
    measured = {one: found for one, found in sensors.items() if found is not None}
    return Mjcf(
        name=model.names.split(b"\0", 1)[0].decode(errors="replace"),
        bodies=tuple(bodies),
        closures=tuple(_closures(model, numbers)),
        relations=tuple(_relations(model, numbers, order)),
        diagnostics=tuple(left_out(model, spec, set(numbers), textures, where, acting, list(measured))),
        actuators=tuple(actuator(model, one, order) for one in acting),
        sensors=tuple(measured.values()),
        keyframes=keyframes(model, order),
    )


def _numbers(
    model: mujoco.MjModel,
    bodies: Mapping[int, int],
    joints: Mapping[int, int],
    acting: Iterable[int],
    kept: Iterable[int],
    sites: Mapping[int, list[int]],
) -> Numbers:
    """By kind of object: MuJoCo's numbers → those of the model."""
    named = [site for body in kept for site in sites.get(body, ()) if model.site(site).name]
    return {
        "joint": joints,
        "actuator": {one: number for number, one in enumerate(acting)},
        "site": {site: number for number, site in enumerate(named)},
        "body": bodies,
        "xbody": bodies,
    }


def geom_shows(model: mujoco.MjModel, geom: int) -> bool:
    """Whether a geom is only visual."""
    touches = model.geom_contype[geom] or model.geom_conaffinity[geom]
    return not touches and bool(model.geom_bodyid[geom]) and _rgba(model, geom)[3] > 0


def _require_finite(model: mujoco.MjModel, where: str) -> None:
    wrong = [name for name in _FINITE if not np.isfinite(getattr(model, name)).all()]
    if wrong:
        msg = f"invalid MJCF: NaN or infinite values in {', '.join(wrong)}"
        raise SourceError(msg, where, "look for nan and inf in the file")


def _kept(model: mujoco.MjModel) -> list[int]:
    """The bodies that are not a mocap body nor below one; the world is the first."""
    kept: dict[int, None] = {}
    for body in range(model.nbody):
        if model.body_mocapid[body] < 0 and (body == 0 or int(model.body_parentid[body]) in kept):
            kept[body] = None
    return list(kept)


def _of_bodies(bodies: Iterable[int]) -> dict[int, list[int]]:
    """The indices of the elements on each of `bodies`."""
    found: dict[int, list[int]] = {}
    for thing, body in enumerate(bodies):
        found.setdefault(int(body), []).append(thing)
    return found


def _inertial(model: mujoco.MjModel, body: int) -> Inertial | None:
    mass = float(model.body_mass[body])
    if body == 0 or mass == 0.0:
        return None
    own = Inertial(mass, np.zeros(3), np.diag(model.body_inertia[body]))
    return moved(own, placed(model.body_ipos[body], model.body_iquat[body]))


def _joint(model: mujoco.MjModel, joint: int, limits: Mapping[int, float]) -> MjcfJoint:
    kind = JOINTS[int(model.jnt_type[joint])]
    scalar = kind in ("hinge", "slide")
    dof = int(model.jnt_dofadr[joint])
    low, high = (float(bound) for bound in model.jnt_range[joint])
    ranged = scalar and model.jnt_limited[joint]

    def unless_zero(value: float) -> float | None:
        return float(value) if kind != "free" and value else None

    return MjcfJoint(
        name=model.joint(joint).name,
        type=kind,
        anchor=frozen(np.zeros(3) if kind == "free" else model.jnt_pos[joint]),
        axis=frozen(model.jnt_axis[joint] if scalar else np.zeros(3)),
        ref=float(model.qpos0[model.jnt_qposadr[joint]]) if scalar else 0.0,
        limits=Limits(
            low if ranged and low > -_OPEN else None,
            high if ranged and high < _OPEN else None,
        ),
        dynamics=Dynamics(
            damping=unless_zero(model.dof_damping[dof]),
            friction=unless_zero(model.dof_frictionloss[dof]),
            armature=unless_zero(model.dof_armature[dof]),
            effort=limits.get(joint),
        ),
    )


def _geoms(
    model: mujoco.MjModel, body: int, meshes: Meshes, textures: Textures, shown: bool
) -> Iterator[MjcfGeom]:
    """A body's shapes. A collision geom is visual too where the body has no other visual geom, unless
    it is in a hidden group of a model that has visual geoms."""
    first = int(model.body_geomadr[body])
    geoms = range(first, first + int(model.body_geomnum[body]))
    dressed = any(geom_shows(model, geom) for geom in geoms)
    for geom in geoms:
        kind = GEOMS.get(int(model.geom_type[geom]))
        if kind is None:
            continue
        collides = bool(model.geom_contype[geom] or model.geom_conaffinity[geom])
        hidden = dressed or (shown and model.geom_group[geom] >= _SHOWN)
        rgba = _rgba(model, geom)
        seen = rgba[3] > 0 and not (collides and hidden)
        if not (collides or seen):
            continue
        image = textures.of(geom) if seen else ""
        colour = rgba if seen and (rgba != _PLAIN or image) else None
        pose = placed(model.geom_pos[geom], model.geom_quat[geom])
        mesh = None
        if kind == "mesh":
            number = int(model.geom_dataid[geom])
            mesh = meshes.ref(number, colour, image)
            pose = frozen(pose @ inverse(meshes.asset_from_mesh(number)))
        size = _size(kind, model.geom_size[geom])
        yield MjcfGeom(model.geom(geom).name, kind, size, mesh, pose, colour, collides, seen)


def _size(kind: MjcfGeomKind, size: Array) -> tuple[float, ...]:
    """The full size: MuJoCo stores radii, and half lengths."""
    x, y, z = (float(value) for value in size)
    if kind == "mesh":
        return ()
    if kind == "box":
        return 2 * x, 2 * y, 2 * z
    return (x,) if kind == "sphere" else (x, 2 * y)


def _rgba(model: mujoco.MjModel, geom: int) -> Colour:
    """The geom's own colour, else its material's."""
    own, material = _colour(model.geom_rgba[geom]), int(model.geom_matid[geom])
    return own if own != _PLAIN or material < 0 else _colour(model.mat_rgba[material])


def _colour(rgba: Array) -> Colour:
    # Single precision as it is typed: 0.8, not 0.800000011920929.
    r, g, b, a = (float(str(value)) for value in rgba)
    return r, g, b, a


def _site(model: mujoco.MjModel, site: int) -> MjcfSite:
    return MjcfSite(model.site(site).name, placed(model.site_pos[site], model.site_quat[site]))


def _closures(model: mujoco.MjModel, numbers: Mapping[int, int]) -> Iterator[MjcfClosure]:
    """Connects and welds. Between bodies, `eq_data` of a connect is the point in both; of a weld the point
    in the second, the same in the first, and first_from_second as a quaternion."""
    for eq in range(model.neq):
        kind = int(model.eq_type[eq])
        if kind == mujoco.mjtEq.mjEQ_JOINT or not carried(model, eq, numbers):
            continue
        ends = int(model.eq_obj1id[eq]), int(model.eq_obj2id[eq])
        by_sites = model.eq_objtype[eq] == mujoco.mjtObj.mjOBJ_SITE
        bodies = tuple(int(model.site_bodyid[end]) for end in ends) if by_sites else ends
        data = model.eq_data[eq]
        still = np.array([1.0, 0, 0, 0])
        sites = ("", "")
        if by_sites:
            sites = (model.site(ends[0]).name, model.site(ends[1]).name)
            frames = [placed(model.site_pos[end], model.site_quat[end]) for end in ends]
        elif kind == mujoco.mjtEq.mjEQ_CONNECT:
            frames = [placed(data[0:3], still), placed(data[3:6], still)]
        else:
            frames = [placed(data[3:6], data[6:10]), placed(data[0:3], still)]
        yield MjcfClosure(
            name=model.equality(eq).name,
            type="connect" if kind == mujoco.mjtEq.mjEQ_CONNECT else "weld",
            bodies=(numbers[bodies[0]], numbers[bodies[1]]),
            sites=sites,
            a_from_frame=frames[0],
            b_from_frame=frames[1],
        )


def _relations(
    model: mujoco.MjModel, numbers: Mapping[int, int], order: Mapping[int, int]
) -> Iterator[MjcfRelation]:
    """Linear joint equalities: y − y₀ = a₀ + a₁ (x − x₀)."""
    for eq in range(model.neq):
        if model.eq_type[eq] != mujoco.mjtEq.mjEQ_JOINT or not carried(model, eq, numbers):
            continue
        follower, driver = int(model.eq_obj1id[eq]), int(model.eq_obj2id[eq])
        y, x = (float(model.qpos0[model.jnt_qposadr[joint]]) for joint in (follower, driver))
        constant, slope = (float(value) for value in model.eq_data[eq][:2])
        yield MjcfRelation(
            model.equality(eq).name, order[follower], order[driver], slope, y + constant - slope * x
        )
