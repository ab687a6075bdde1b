"""Which colliders do not collide: by the parts of links of meshes, and by shapes that touch in every pose."""

from dataclasses import replace
from hashlib import sha256

import numpy as np
import pytest
import trimesh

from linkwright.stages.mesh import make_geometry
from linkwright.stages.mesh.contacts.analysis import self_contacts
from linkwright.stages.mesh.contacts.narrow import MAX_OTHER_CONTACT_SHARE, excluded_shape_pairs
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.contact.exclude_names import excluded_colliders
from linkwright.stages.robot.model.geometry import Exclude, Shape
from linkwright.stages.robot.model.robot import Inertial, MeshRef, Part, frozen
from tests.support.building import plan_of
from tests.support.exports import compiled, exported
from tests.support.mjcfs import SOLID, body, bundle_of, model, robot_of, written
from tests.support.robots import at
from tests.support.solids import bodies_of
from tests.support.touching import Memory, ball, geoms_in_mujoco, no_memo
from tests.unit.mesh.test_contacts import base_arm_hand, gripper, with_reason
from tests.unit.pipeline.page.test_colliders import EVERY

MESHES = {
    "Rack": trimesh.creation.box((0.01, 0.01, 0.3)),
    "Pad": trimesh.creation.box((0.01, 0.01, 0.01), np.array(at(0, 0.1, 0))),
}
REPLY = bodies_of(MESHES)
DIGEST = sha256(REPLY).hexdigest()
BUNDLE = Bundle("onshape", {}, "", {}, {DIGEST: REPLY})
CLOSED = {"left_joint": -0.0551, "right_joint": -0.0551}


def meshed(names, *shapes):
    """The gripper with fingers of these parts, and primitives of the user's own."""
    here, inertial = frozen(np.eye(4)), Inertial(0.1, frozen([0.0, 0, 0]), frozen(np.eye(3) * 1e-5))
    parts = tuple(
        Part((name,), f"{name} <1>", name, MeshRef(DIGEST, name), here, here, inertial, 0.0) for name in names
    )
    palm, *fingers = gripper().links
    return replace(gripper(), links=(palm, *(replace(link, parts=parts, shapes=shapes) for link in fingers)))


def made(robot, collider, **section):
    plan = plan_of(mesh={"collider": collider, **section}, contact={"self": "auto"})
    return make_geometry(robot, BUNDLE, plan, no_memo)


@pytest.mark.parametrize("collider", ["primitives", "raw"])
def test_parts_are_kept_apart_and_named(collider):
    robot = meshed(["Pad", "Rack"], ball(0.004, at(0, 0.5, 0)))
    geometry = made(robot, collider)
    assert [shape.collider for shape in geometry.shapes_of("left", "collision")] == [0, 1, None]
    names = [figures.parts for figures in geometry.colliders if figures.link == "left"]
    rack = names.index(("Rack <1>",))
    assert with_reason(geometry, "Always").geoms == ((rack, rack),)
    (diagnostic,) = [row for row in geometry.diagnostics if row.code == "I-ALWAYS-CONTACT"]
    assert diagnostic.message.endswith(", but only Rack <1> against Rack <1>")
    closed = geoms_in_mujoco(compiled(exported(robot, geometry)), robot, CLOSED)
    assert closed == {(("left", 1 - rack), ("right", 1 - rack))}


def test_shapes_are_counted_without_meshes_that_are_not_written():
    """The parts come before the user's shapes; they are not written, and so they touch nothing."""
    robot = meshed(["Pad"], *gripper().link("left").shapes)
    geometry = made(robot, "raw", assets="none")
    assert len(geometry.shapes_of("left", "collision")) == 2
    assert with_reason(geometry, "Always").geoms == ((0, 0),)
    closed = geoms_in_mujoco(compiled(exported(robot, geometry)), robot, CLOSED)
    assert closed == {(("left", 1), ("right", 1))}
    bare = made(meshed(["Pad", "Rack"]), "raw", assets="none")
    assert not [exclude for exclude in bare.excludes if "left" in (exclude.link_a, exclude.link_b)]


def test_work_is_repeated_where_pieces_change_their_collider():
    robot, memo = gripper(), Memory()
    geometry = made(robot, "primitives")
    shapes = [shape for link in robot.links for shape in geometry.shapes_of(link.name, "collision")]

    # The racks always touch and the pads seldom, as colliders of their own or as two pieces of one.
    for numbers in ([0, 0, 1, 0, 1], [0, 0, 0, 0, 0]):
        pieces = [replace(shape, collider=number) for shape, number in zip(shapes, numbers, strict=True)]
        contacts = self_contacts(robot, pieces, {}, plan_of(contact={"self": "auto"}).contact, memo)
        assert with_reason(contacts, "Always").geoms == ((0, 0),)
    assert memo.made == 2


def test_names_count_pieces_and_list_the_shapes_of_the_user():
    def shape(link, collider, primitive=None):
        return Shape(link, "collision", None, None, 0, 0, 0.0, 0.0, primitive, collider=collider)

    shapes = [shape("base", 0), *(shape("arm", 0) for _ in range(16)), shape("arm", None, ball(1.0))]
    exclude = Exclude("base", "arm", "Always", 0.0, ((0, 3), (0, 5), (0, 16)))
    some = ("Sleeve <1> (2 of 16 pieces)", "sphere 16")
    assert excluded_colliders(exclude, shapes, EVERY) == (("Foot <1>",), some)
    whole = replace(exclude, geoms=tuple((0, piece) for piece in range(16)))
    assert excluded_colliders(whole, shapes, EVERY) == (("Foot <1>",), ("Sleeve <1>",))
    assert excluded_colliders(replace(whole, geoms=()), shapes, EVERY) is None


def test_link_with_one_collider_is_left_out_as_a_whole():
    geometry = made(base_arm_hand(hand=ball(0.06)), "primitives")
    assert [exclude.geoms for exclude in geometry.excludes] == [()] * 3


@pytest.mark.parametrize(
    ("basis", "contact", "pairs"),
    [("declared", "auto", []), ("visual", "auto", [("trunk", "head", "Adjacent")]), ("visual", "all", [])],
)
def test_visuals_of_an_mjcf_collide_by_our_rule_of_neighbours(tmp_path, basis, contact, pairs):
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
    geometry = make_geometry(robot_of(path), bundle_of(path), plan, no_memo)
    assert [(exclude.link_a, exclude.link_b, exclude.reason) for exclude in geometry.excludes] == pairs


POSES = 20
ALL = range(POSES)
OFTEN, RARE = int(MAX_OTHER_CONTACT_SHARE * POSES) + 1, int(MAX_OTHER_CONTACT_SHARE * POSES)


def pairs(mask):
    return {tuple(map(int, pair)) for pair in np.argwhere(mask)}


def every(m, n):
    return {(i, j) for i in range(m) for j in range(n)}


TEETH = {(0, 0): ALL[::3], (1, 0): ALL[1::3], (0, 2): ALL[2::3], (2, 3): [0, 1]}


@pytest.mark.parametrize(
    ("first", "second", "touching", "left_out"),
    [
        # `touching`: the poses in which a pair of shapes touches.
        ("ab", "cd", {(0, 0): ALL[1:], (1, 1): ALL[2:]}, set()),
        ("ab", "cde", {(0, 1): ALL, (1, 2): ALL[:15], (0, 0): [3]}, {(0, 1)}),
        # In each pose other teeth touch; the pads (2 and 3) touch in some.
        ("ggp", "hhhq", TEETH, {(i, j) for i in (0, 1) for j in (0, 1, 2)}),
        ("gg", "hh", {(0, 0): ALL, (1, 1): ALL[:OFTEN]}, every(2, 2)),
        ("gg", "hh", {(0, 0): ALL, (1, 1): ALL[:RARE]}, {(0, 0)}),
        ("ab", "cd", {(0, 0): ALL[:10], (1, 1): ALL[10:]}, every(2, 2)),
        ("abc", "def", {(0, 0): ALL, (1, 1): ALL[:10], (2, 2): ALL[10:]}, every(3, 3)),
    ],
    ids=["apart in one pose", "others kept", "teeth", "teeth round a hub", "tip that seldom touches",
         "no two colliders always", "rest always too"],
)  # fmt: skip
def test_shapes_that_always_touch_are_left_out(first, second, touching, left_out):
    table = np.zeros((POSES, len(first), len(second)), dtype=bool)
    for pair, poses in touching.items():
        table[(list(poses), *pair)] = True
    assert pairs(excluded_shape_pairs(table, first, second)) == left_out


def test_without_a_pose_nothing_is_left_out():
    assert not excluded_shape_pairs(np.zeros((0, 2, 2), dtype=bool), "ab", "cd").any()


@pytest.mark.parametrize("seed", range(100))
def test_no_contact_is_lost_without_need(seed):
    rng = np.random.default_rng(seed)
    m, n = rng.integers(1, 6, 2)
    first, second = rng.integers(0, 3, m), rng.integers(0, 3, n)
    touching = rng.random((POSES, m, n)) < rng.choice([0.02, 0.5, 0.97, 1.0], (m, n))
    left_out = excluded_shape_pairs(touching, first.tolist(), second.tolist())
    assert left_out.any() == touching.any(axis=(1, 2)).all()
    if left_out.all():
        return
    assert not (touching & ~left_out).any(axis=(1, 2)).all()
    for i, j in pairs(left_out):
        block = np.ix_(np.flatnonzero(first == first[i]), np.flatnonzero(second == second[j]))
        assert touching[:, *block].any(axis=(1, 2)).all()
        assert touching[:, i, j].all() or left_out[block].all()
    assert not (touching.all(axis=0) & ~left_out).any()
