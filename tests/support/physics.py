"""Parts whose colliders the product makes, in MuJoCo."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from hashlib import sha256

import mujoco
import numpy as np

from linkwright.stages.export import export
from linkwright.stages.mesh import make_geometry
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Inertial, Link, MeshRef, Part, frozen
from tests.support.building import plan_of
from tests.support.robots import robot_with
from tests.support.solids import bodies_of

VISUAL, COLLISION = 2, 3
"""The groups of geoms in an exported MJCF."""


def robot_of_meshes(meshes):
    """A robot of one fixed link, `base`, whose parts are these meshes where they are, and its files."""
    reply = bodies_of(meshes)
    digest = sha256(reply).hexdigest()
    here = frozen(np.eye(4))
    body = Inertial(0.1, frozen([0.0, 0, 0]), frozen(np.eye(3) * 1e-5))
    parts = tuple(Part((name,), name, name, MeshRef(digest, name), here, here, body, 0.0) for name in meshes)
    links = (Link("base", body, parts, ("base",), None, ()),)
    return replace(robot_with([], root="base"), links=links), Bundle("onshape", {}, "", {}, {digest: reply})


@dataclass(frozen=True)
class Fixture:
    """A fixed part as its MJCF has it, with its geometry."""

    geometry: Geometry
    files: Mapping[str, bytes]

    def spec(self):
        """The MJCF, to add things to; steps of 1 ms."""
        assets = {name: data for name, data in self.files.items() if not name.endswith(".xml")}
        spec = mujoco.MjSpec.from_string(self.files["robot.xml"].decode(), assets=assets)
        spec.option.timestep = 0.001
        return spec


def fixture(mesh, **section):
    """The part with the colliders that `mesh.collider=ladder` and these keys of `mesh` make."""
    robot, bundle = robot_of_meshes({"Part": mesh})
    plan = plan_of(mesh={"collider": "ladder", **section}, contact={"self": "none"}, ground={"kind": "none"})
    geometry = make_geometry(robot, bundle, plan, lambda kind, key, make: make())
    return Fixture(geometry, export(robot, geometry, plan).files)


def with_dropped(spec, kind, size, pos):
    """The same with a free body, `dropped`, of 10 g."""
    body = spec.worldbody.add_body(name="dropped", pos=pos)
    body.add_freejoint()
    body.add_geom(type=kind, size=size, mass=0.01)
    return spec


def settled(spec, seconds):
    """The model and its state after so long."""
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, round(seconds / model.opt.timestep))
    return model, data
