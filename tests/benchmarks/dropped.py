"""A robot on the ground with its own colliders, with what is seen of it in their place, and with one hull a
link: how long MuJoCo takes for each, on the same states and dropped."""

import time
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from scipy.spatial import ConvexHull

from linkwright.stages.robot.model.robot import Array
from linkwright.stages.validate.model.seen_surfaces import surface
from linkwright.stages.validate.model.shapes import seen_and_solid

VARIANTS = ("made", "raw", "hulls")
"""The colliders of the build; every mesh and primitive that is seen; one hull a link."""

DROPS, SETTLED, STEPS, TURN = 5, 1000, 1500, 150
"""Poses, the first of them `home`; of each the steps before and in the measurement, and those of one turn."""

RECORDED, EVERY, ROUNDS = 50, 60, 25
"""States of the drops of one variant, a state every so many steps, and how often all are computed."""

CONTACT = ("friction", "solref", "solimp", "condim", "margin", "gap", "solmix", "priority")


def models(folder):
    """The scene of a build with each kind of colliders, without the pairs that the build leaves out."""
    made = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    models = {"made": made}
    shapes = {made.body(body).name: pair for body, pair in seen_and_solid(made).items() if all(pair)}
    for variant in VARIANTS[1:]:
        spec = mujoco.MjSpec.from_file(str(folder / "scene.xml"))
        for pair in list(spec.pairs):
            spec.delete(pair)
        for body in list(spec.bodies):
            if body.name in shapes:
                _replace(spec, body, made, shapes[body.name][0], variant)
        models[variant] = spec.compile()
    return models


def _replace(spec, body, made, seen, variant):
    """Gives a body other colliders, with the properties of contact of its own."""
    own = [geom for geom in body.geoms if geom.type != mujoco.mjtGeom.mjGEOM_PLANE]
    solid = [geom for geom in own if geom.contype or geom.conaffinity]
    drawn = [geom for geom in own if not (geom.contype or geom.conaffinity)]
    bits = {"contype": solid[0].contype, "conaffinity": solid[0].conaffinity}
    kept = {key: np.copy(getattr(solid[0], key)) for key in CONTACT} | bits
    if variant == "hulls":
        points = np.concatenate([surface(made, geom)[0] for geom in seen])
        corners = points[ConvexHull(points).vertices]
        name = f"hull of {body.name}"
        convex = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        spec.add_mesh(name=name, uservert=corners.ravel(), maxhullvert=64, inertia=convex)
        drawn = [body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, mass=0.0)]
    for geom in solid:
        spec.delete(geom)
    for geom in drawn:
        for key, value in kept.items():
            setattr(geom, key, value)


@dataclass
class Dropped:
    """A robot that falls from a pose, the processor time [s] that its steps took, and its contacts."""

    model: Any
    data: Any
    seconds: float = 0.0
    contacts: tuple[int, ...] = ()

    def drop(self, number):
        """Starts anew in a pose of its joints."""
        model, data = self.model, self.data
        mujoco.mj_resetData(model, data)
        if model.nkey:
            mujoco.mj_resetDataKeyframe(model, data, 0)
        random = np.random.default_rng(number)
        for joint in np.flatnonzero(model.jnt_limited):
            low, high = model.jnt_range[joint]
            at = model.jnt_qposadr[joint]
            data.qpos[at] += (random.uniform(low, high) - data.qpos[at]) * (0.3 if number else 0.0)

    def step(self, count):
        start = time.process_time()
        mujoco.mj_step(self.model, self.data, count)
        self.seconds += time.process_time() - start
        self.contacts += (self.data.ncon,)


def stepped(every):
    """Models after all their steps on the ground, taken in turns, so that a machine that slows down meanwhile
    slows all."""
    stepped_models = {name: Dropped(model, mujoco.MjData(model)) for name, model in every.items()}
    for number in range(DROPS):
        for dropped in stepped_models.values():
            dropped.drop(number)
            mujoco.mj_step(dropped.model, dropped.data, SETTLED)
        for _ in range(STEPS // TURN):
            for dropped in stepped_models.values():
                dropped.step(TURN)
    return stepped_models


State = tuple[Array, Array, Array]
"""Positions, speeds and controls."""


def recorded(model):
    """States of a model's own drops, on the way down and at rest."""
    dropped, states = Dropped(model, mujoco.MjData(model)), []
    for number in range(DROPS):
        dropped.drop(number)
        for _ in range(RECORDED // DROPS):
            mujoco.mj_step(model, dropped.data, EVERY)
            states.append((dropped.data.qpos.copy(), dropped.data.qvel.copy(), dropped.data.ctrl.copy()))
    return states


def forward(every):
    """Processor time [s] of `mj_forward` on the states that all the models recorded, of each its quickest
    round. No model has its own states alone, which would favour it."""
    states = [state for model in every.values() for state in recorded(model)]
    data = {name: mujoco.MjData(model) for name, model in every.items()}
    best = dict.fromkeys(every, np.inf)
    for _ in range(ROUNDS):
        for name, model in every.items():
            start = time.process_time()
            for qpos, qvel, ctrl in states:
                _forward(model, data[name], qpos, qvel, ctrl)
            best[name] = min(best[name], time.process_time() - start)
    return {name: seconds / len(states) for name, seconds in best.items()}


def _forward(model, data, qpos, qvel, ctrl):
    data.qpos[:], data.qvel[:], data.ctrl[:] = qpos, qvel, ctrl
    data.qacc_warmstart[:] = 0.0
    mujoco.mj_forward(model, data)
