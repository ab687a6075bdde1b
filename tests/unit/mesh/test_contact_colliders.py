"""Which colliders do not collide, by their parts: of links of meshes, and of meshes that are not written."""

from dataclasses import replace
from hashlib import sha256

import numpy as np
import pytest
import trimesh

from linkwright.stages.mesh import make_geometry
from linkwright.stages.mesh.contacts.analysis import self_contacts
from linkwright.stages.robot import codec
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.contact.exclude_names import excluded_colliders
from linkwright.stages.robot.model.geometry import Exclude, Shape
from linkwright.stages.robot.model.robot import Inertial, MeshRef, Part, frozen
from tests.support.building import plan_of
from tests.support.mjcfs import SOLID, body, bundle_of, model, robot_of, written
from tests.support.robots import at
from tests.support.solids import bodies_of
from tests.support.touching import ball, exported, geoms_in_mujoco, model_of
from tests.unit.mesh.test_contacts import base_arm_hand, gripper
from tests.unit.pipeline.page.test_colliders import EVERY

MESHES = {
    "Rack": trimesh.creation.box((0.01, 0.01, 0.3)),
    "Pad": trimesh.creation.box((0.01, 0.01, 0.01), np.array(at(0, 0.1, 0))),
}
REPLY = bodies_of(MESHES)
DIGEST = sha256(REPLY).hexdigest()
BUNDLE = Bundle("onshape", {}, "", {}, {DIGEST: REPLY})


def parts(*names):
    here = frozen(np.eye(4))
    body = Inertial(0.1, frozen([0.0, 0, 0]), frozen(np.eye(3) * 1e-5))
    return tuple(
        Part((name,), f"{name} <1>", name, MeshRef(DIGEST, name), here, here, body, 0.0) for name in names
    )


def meshed(names, *shapes):
    """The gripper with fingers of these parts, and primitives of the user's own."""
    robot = gripper()
    fingers = [
        replace(link, parts=parts(*names), shapes=shapes) if link.name != "palm" else link
        for link in robot.links
    ]
    return replace(robot, links=tuple(fingers))


def made(robot, collider, **section):
    plan = plan_of(mesh={"collider": collider, **section}, contact={"self": "auto"})
    return make_geometry(robot, BUNDLE, plan, lambda kind, key, make: make())


def only(geometry):
    (found,) = [one for one in geometry.excludes if one.reason == "Always"]
    return found


@pytest.mark.parametrize("collider", ["primitives", "raw"])
def test_parts_are_told_apart_and_named(collider, tmp_path):
    robot = meshed(["Pad", "Rack"], ball(0.004, at(0, 0.5, 0)))
    geometry = made(robot, collider)
    assert [shape.collider for shape in geometry.of("left", "collision")] == [0, 1, None]
    names = [figures.parts for figures in geometry.colliders if figures.link == "left"]
    rack = names.index(("Rack <1>",))
    assert only(geometry).geoms == ((rack, rack),)
    (found,) = [one for one in geometry.diagnostics if one.code == "I-ALWAYS-CONTACT"]
    assert found.message.endswith(", of which only Rack <1> against Rack <1>")
    model = model_of(robot, geometry, tmp_path)
    closed = geoms_in_mujoco(model, robot, {"left_joint": -0.0551, "right_joint": -0.0551})
    assert closed == {(("left", 1 - rack), ("right", 1 - rack))}


def test_shapes_are_counted_without_meshes_that_are_not_written(tmp_path):
    """The parts come before what the user gave; they are not written, and so they touch nothing."""
    shapes = gripper().link("left").shapes
    robot = meshed(["Pad"], *shapes)
    geometry = made(robot, "raw", assets="none")
    assert len(geometry.of("left", "collision")) == 2
    assert only(geometry).geoms == ((0, 0),)
    exported(robot, geometry)
    closed = geoms_in_mujoco(
        model_of(robot, geometry, tmp_path), robot, {"left_joint": -0.0551, "right_joint": -0.0551}
    )
    assert closed == {(("left", 1), ("right", 1))}
    none = made(meshed(["Pad", "Rack"]), "raw", assets="none")
    assert [one for one in none.excludes if "left" in (one.link_a, one.link_b)] == []


def test_the_work_is_done_again_where_the_shapes_are_pieces_of_other_colliders():
    robot, keys = gripper(), []
    shapes = made(robot, "primitives").of

    def key_of(numbers):
        def memo(kind, key, make):
            keys.append(codec.dump(key))
            return make()

        every = [shape for link in robot.links for shape in shapes(link.name, "collision")]
        every = [replace(shape, collider=number) for shape, number in zip(every, numbers, strict=True)]
        contacts = self_contacts(robot, every, {}, plan_of(contact={"self": "auto"}).contact, memo)
        return [one.geoms for one in contacts.excludes if one.reason == "Always"]

    # The racks always touch and the pads seldom, as colliders of their own or as two pieces of one.
    assert key_of([0, 0, 1, 0, 1]) == [((0, 0),)]
    assert key_of([0, 0, 0, 0, 0]) == [((0, 0),)]
    assert keys[0] != keys[1]


def shape(link, collider, primitive=None):
    return Shape(link, "collision", None, None, 0, 0, 0.0, 0.0, primitive, collider=collider)


def test_names_count_pieces_and_tell_what_the_user_gave():
    shapes = [shape("base", 0), *(shape("arm", 0) for _ in range(16)), shape("arm", None, ball(1.0))]
    some = Exclude("base", "arm", "Always", 0.0, ((0, 3), (0, 5), (0, 16)))
    assert excluded_colliders(some, shapes, EVERY) == (
        ("Foot <1>",),
        ("Sleeve <1> (2 of 16 pieces)", "sphere 16"),
    )
    every = Exclude("base", "arm", "Always", 0.0, tuple((0, piece) for piece in range(16)))
    assert excluded_colliders(every, shapes, EVERY) == (("Foot <1>",), ("Sleeve <1>",))
    assert excluded_colliders(replace(every, geoms=()), shapes, EVERY) is None


def test_a_link_with_one_collider_is_left_out_as_a_whole():
    assert [one.geoms for one in made(base_arm_hand(hand=ball(0.06)), "primitives").excludes] == [(), (), ()]


@pytest.mark.parametrize(
    ("basis", "contact", "pairs"),
    [("declared", "auto", []), ("visual", "auto", [("trunk", "head", "Adjacent")]), ("visual", "all", [])],
)
def test_what_an_mjcf_shows_collides_by_our_rule_of_neighbours(tmp_path, basis, contact, pairs):
    """The file says what its colliders do; a body without geoms is between the trunk and the head."""
    head = body("head", '<joint axis="1 0 0"/><geom type="box" size=".04 .04 .1" pos="0 0 .1"/>')
    pan = f'<body name="pan" pos="0 0 .2"><joint axis="0 0 1"/>{SOLID.format(mass=0.1)}{head}</body>'
    path = written(tmp_path, model(body("trunk", f'<geom type="box" size=".1 .1 .2"/>{pan}')))
    plan = plan_of(
        source={"kind": "mjcf", "path": str(path)},
        mesh={"collider": "ladder", "basis": basis},
        contact={"self": contact},
        ground={"kind": "none"},
    )
    geometry = make_geometry(robot_of(path), bundle_of(path), plan, lambda kind, key, make: make())
    assert [(one.link_a, one.link_b, one.reason) for one in geometry.excludes] == pairs
