"""Converts a model that MuJoCo compiled to values of our own."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import mujoco
import numpy as np

from linkwright.stages.fetch.mjcf.compiled.actuation import Numbers, actuator, carried_actuators, sensor
from linkwright.stages.fetch.mjcf.compiled.effort import efforts
from linkwright.stages.fetch.mjcf.compiled.equalities import closures, relations
from linkwright.stages.fetch.mjcf.compiled.extras import ExtrasReader
from linkwright.stages.fetch.mjcf.compiled.geoms import Geoms
from linkwright.stages.fetch.mjcf.compiled.joints import joints_of
from linkwright.stages.fetch.mjcf.compiled.keyframes import keyframes
from linkwright.stages.fetch.mjcf.compiled.meshes import Meshes
from linkwright.stages.fetch.mjcf.compiled.textures import Textures
from linkwright.stages.fetch.mjcf.compiled.trees import robot_bodies
from linkwright.stages.fetch.mjcf.compiled.unsupported import omission_reports, scene_reports
from linkwright.stages.formats.mjcf.model import Mjcf, MjcfBody, MjcfSite
from linkwright.stages.mujoco.bodies import pose_of
from linkwright.stages.mujoco.elements import site_attributes
from linkwright.stages.mujoco.fields import ARRAYS, BODY, attributes
from linkwright.stages.robot.dynamics.inertia import moved
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.robot.model.robot import Inertial, frozen

_FINITE_ARRAYS = (
    *("qpos0", "body_pos", "body_quat", "body_mass", "body_ipos", "body_iquat", "body_inertia"),
    *("jnt_pos", "jnt_axis", "jnt_range", "geom_pos", "geom_quat", "geom_size", "site_pos", "site_quat"),
    *("eq_data", "dof_damping", "dof_frictionloss", "dof_armature", "key_qpos", "qpos_spring"),
    *("jnt_stiffness", "actuator_gear", "actuator_gainprm", "actuator_biasprm", "actuator_dynprm"),
    "geom_friction",
)
"""Arrays that must be finite: MuJoCo compiles a NaN with only a warning."""

_ACTUATOR_RANGES = ("actuator_ctrlrange", "actuator_forcerange", "actuator_actrange")


def convert(
    model: mujoco.MjModel, spec: mujoco.MjSpec, meshes: Meshes, textures: Textures, where: str
) -> Mjcf:
    """Returns the model as a value.

    `spec`: the spec that the model was compiled from; `where`: the name of its file. Raises SourceError if a
    number is not finite.
    """
    if model.nbody < 2:
        msg = "not readable as an MJCF: it has no body"
        raise SourceError(msg, where, "a robot's links are the <body>s of its <worldbody>")
    _require_finite(model, where)
    kept = robot_bodies(model)
    numbers = {body: number for number, body in enumerate(kept)}
    extras = ExtrasReader(model, kept)
    joints = [joint for joint in range(model.njnt) if int(model.jnt_bodyid[joint]) in numbers]
    geoms = Geoms(model, meshes, textures)
    sites = {body: extras.frames(body) for body in kept}
    order = {joint: number for number, joint in enumerate(joints)}
    actuator_numbers = carried_actuators(model, numbers)
    our_numbers = _numbers(numbers, order, actuator_numbers, sites)
    sensors = {index: sensor(model, index, our_numbers) for index in range(model.nsensor)}
    kept_sensors = {index: kept_sensor for index, kept_sensor in sensors.items() if kept_sensor is not None}
    effort_limits = efforts(model)
    found_extras = extras.read(actuator_numbers, list(kept_sensors))
    return Mjcf(
        name=model.names.split(b"\0", 1)[0].decode(errors="replace"),
        bodies=tuple(
            MjcfBody(
                name=model.body(body).name,
                parent=numbers[int(model.body_parentid[body])],
                parent_from_body=pose_of(model.body_pos[body], model.body_quat[body]),
                inertial=_inertial(model, body),
                joints=joints_of(model, body, effort_limits),
                geoms=tuple(geoms.geoms_of(body)) if body else (),
                sites=tuple(_site(model, site) for site in sites[body]),
                axes=pose_of(np.zeros(3), model.body_iquat[body])[:3, :3] if body else None,
                attributes=attributes(model, BODY, body),
                mounted=extras.mounted(body, geoms.unseen(body)) if body else (),
            )
            for body in kept
        ),
        closures=tuple(closures(model, numbers)),
        relations=tuple(relations(model, numbers, order)),
        diagnostics=(
            *scene_reports(model, kept, where),
            *omission_reports(model, spec, kept, textures, where, found_extras.lost, actuator_numbers),
        ),
        actuators=tuple(actuator(model, index, order) for index in actuator_numbers),
        sensors=tuple(kept_sensors.values()),
        keyframes=keyframes(model, order),
        extras=found_extras.extras(),
    )


def _numbers(
    bodies: Mapping[int, int],
    joints: Mapping[int, int],
    actuator_numbers: Iterable[int],
    sites: Mapping[int, Iterable[int]],
) -> Numbers:
    """Returns kind of object → MuJoCo's number → number in our model."""
    frame_sites = [site for body_sites in sites.values() for site in body_sites]
    return {
        "joint": joints,
        "actuator": {index: number for number, index in enumerate(actuator_numbers)},
        "site": {site: number for number, site in enumerate(frame_sites)},
        "body": bodies,
        "xbody": bodies,
    }


def _require_finite(model: mujoco.MjModel, where: str) -> None:
    fields = [name for name in _FINITE_ARRAYS if not np.isfinite(getattr(model, name)).all()]
    attribute_arrays = sorted(name for name in ARRAYS if hasattr(model, name) and name not in fields)
    fields += [name for name in attribute_arrays if _has_bad_number(model, name)]
    if fields:
        msg = f"invalid MJCF: NaN or infinite values in {', '.join(fields)}"
        raise SourceError(msg, where, "look for nan and inf in the file")


def _has_bad_number(model: mujoco.MjModel, name: str) -> bool:
    """Tells whether an array has a NaN, or is the range of actuators and has an infinite end that counts."""
    values = getattr(model, name)
    if name not in _ACTUATOR_RANGES:
        return bool(np.isnan(values).any())
    is_limited = getattr(model, f"{name.removesuffix('range')}limited") != 0
    return bool(np.isnan(values).any() or np.isinf(values[is_limited]).any())


def _inertial(model: mujoco.MjModel, body: int) -> Inertial | None:
    mass = float(model.body_mass[body])
    if body == 0 or mass == 0.0:
        return None
    inertial_at_com = Inertial(mass, np.zeros(3), np.diag(model.body_inertia[body]))
    return moved(inertial_at_com, pose_of(model.body_ipos[body], model.body_iquat[body]))


def _site(model: mujoco.MjModel, site: int) -> MjcfSite:
    pose = frozen(pose_of(model.site_pos[site], model.site_quat[site]))
    return MjcfSite(model.site(site).name, pose, site_attributes(model, site))
