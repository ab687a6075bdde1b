"""The geometry of a robot is the same, to the byte, for any number of workers and any order of its parts."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from linkwright.stages.mesh import make_geometry
from linkwright.stages.mesh.by_contact import robot as by_contact
from linkwright.stages.robot import codec
from linkwright.stages.robot.system import process_usage
from tests.support.building import plan_of
from tests.support.physics import robot_of_meshes


def angle(*lengths):
    """Two plates at a right angle."""
    x, y, z = lengths
    plates = [trimesh.creation.box(bounds=[(0, 0, 0), corner]) for corner in ((x, y, 0.005), (0.005, y, z))]
    return trimesh.boolean.union(plates, engine="manifold")


SMALL = {
    "Wide": angle(0.1, 0.02, 0.05),
    "Tall": angle(0.04, 0.03, 0.09),
    "Block": trimesh.creation.box((0.05, 0.05, 0.05)),
}


def shuffled(robot, seed):
    """The same robot with the parts of each link in another order."""
    rng = np.random.default_rng(seed)
    links = [
        replace(link, parts=tuple(link.parts[index] for index in rng.permutation(len(link.parts))))
        for link in robot.links
    ]
    return replace(robot, links=tuple(links))


def geometry(robot, bundle, plan, workers, monkeypatch):
    monkeypatch.setattr(process_usage, "processors", lambda: workers)
    monkeypatch.setattr(by_contact, "MIN_TRIANGLES_FOR_PROCESS", 0)
    return make_geometry(robot, bundle, plan, lambda kind, key, make: make())


BY_PART = {"colliders": {"*": "ladder"}}


@pytest.mark.parametrize(
    ("mesh", "colliders"),
    [
        ({"collider": "primitives"}, len(SMALL)),
        ({"collider": "ladder", "fine": "all"}, 1),
        pytest.param({"collider": "ladder", **BY_PART}, len(SMALL), marks=pytest.mark.slow),
    ],
    ids=["primitives", "contact", "ladder"],
)
def test_workers_and_the_order_of_parts_change_no_byte(mesh, colliders, monkeypatch):
    robot, bundle = robot_of_meshes(SMALL)
    plan = plan_of(mesh=mesh, contact={"self": "auto"})
    single = geometry(robot, bundle, plan, 1, monkeypatch)
    assert len(single.colliders) == colliders
    for seed in (1, 2):
        other = geometry(shuffled(robot, seed), bundle, plan, 2, monkeypatch)
        assert (other.files, codec.plain_data(other)) == (single.files, codec.plain_data(single))
