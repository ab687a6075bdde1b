"""Contact of a robot with itself: which pairs of links do not collide, and what is reported."""

import math
import re
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from linkwright.pipeline.errors import ConfigError
from linkwright.stages.mesh.contacts import analysis
from linkwright.stages.mesh.contacts.colliders import Colliders, measures_overlaps
from linkwright.stages.robot import codec
from linkwright.stages.robot.errors import MeshError
from linkwright.stages.robot.model.geometry import Exclude, Shape
from linkwright.stages.robot.model.poses import turn
from linkwright.stages.robot.model.robot import Limits, Relation
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.start_pose import home, saved
from tests.support.building import plan_of
from tests.support.robots import EVERY, at, joint, loop, robot_with
from tests.support.touching import apart, ball, box, geometry_of, geoms_in_mujoco, in_mujoco, model_of
from tests.unit.robot.test_home import four_bar

X = np.array([1.0, 0.0, 0.0])

OFF = at(0.007, 0.004, 0.07)
"""Old versions of MuJoCo see no contact of boxes with one middle, or where one pierces the other."""


def reasons(geometry):
    return {(one.link_a, one.link_b): one.reason for one in geometry.excludes}


def close(depth, tolerance=1e-6):
    """The depth, as far as this MuJoCo measures it."""
    return pytest.approx(depth, abs=tolerance if measures_overlaps() else 0.6 * depth)


def said(geometry, code):
    return [found for found in geometry.diagnostics if found.code == code]


def base_arm_hand(**shapes):
    """A fixed base, an arm that turns on it about z, and a hand that turns about the arm's axis too."""
    joints = [joint("revolute", "base", "arm", limits={"arm_joint": Limits(-3.0, 3.0)})]
    joints += [
        joint("revolute", "arm", "hand", place=at(0, 0, 0.1), limits={"hand_joint": Limits(-3.0, 3.0)})
    ]
    every = {"base": box(0.2, 0.2, 0.1), "arm": box(0.05, 0.05, 0.2, OFF), "hand": ball(0.05), **shapes}
    return robot_with(joints, shapes={name: (shape,) for name, shape in every.items() if shape})


def test_a_fixed_base_that_overlaps_its_child_is_excluded_as_adjacent(tmp_path):
    """By 93 mm in the sample, by 80 mm here."""
    robot = base_arm_hand(hand=None)
    geometry = geometry_of(robot)
    assert geometry.self_contact
    (exclude,) = geometry.excludes
    assert (exclude.link_a, exclude.link_b, exclude.reason) == ("base", "arm", "Adjacent")
    assert exclude.depth == close(-apart(robot, home(robot))["base", "arm"])
    model = model_of(robot, geometry, tmp_path)
    assert in_mujoco(model, robot, home(robot)) == set()
    assert in_mujoco(model_of(robot, replace(geometry, excludes=()), tmp_path), robot, home(robot)) == {
        ("base", "arm")
    }


def test_a_root_called_world_is_the_world_and_its_child_is_excluded_too(tmp_path):
    bare = robot_with([joint("revolute", "world", "arm", place=OFF)], root="world")
    robot = replace(bare, links=tuple(replace(link, shapes=(ball(0.1),)) for link in bare.links))
    geometry = geometry_of(robot)
    assert reasons(geometry) == {("world", "arm"): "Adjacent"}
    assert in_mujoco(model_of(robot, geometry, tmp_path), robot, home(robot)) == set()
    free = model_of(robot, replace(geometry, excludes=()), tmp_path)
    assert in_mujoco(free, robot, home(robot)) == {("world", "arm")}


def test_the_depth_of_shapes_with_the_same_middle_is_known():
    shapes = {"base": (box(0.2, 0.2, 0.1),), "arm": (box(0.05, 0.05, 0.2),)}
    (exclude,) = geometry_of(robot_with([joint("revolute", "base", "arm")], shapes=shapes)).excludes
    assert exclude.depth == close(0.125, 1e-4)


def test_a_pair_that_touches_in_every_pose_is_excluded_and_reported_with_its_depth():
    robot = base_arm_hand(hand=ball(0.06))
    geometry = geometry_of(robot)
    assert reasons(geometry)["base", "hand"] == "Always"
    (always,) = [one for one in geometry.excludes if one.reason == "Always"]
    assert always.depth == pytest.approx(0.01, abs=1e-6)
    (found,) = said(geometry, "I-ALWAYS-CONTACT")
    assert "base and hand (10.00 mm deep)" in found.message
    assert not said(geometry, "W-SELF-CONTACT")


def test_a_pair_that_does_not_touch_has_no_exclude():
    geometry = geometry_of(base_arm_hand(hand=ball(0.049)))
    assert set(reasons(geometry)) == {("base", "arm"), ("arm", "hand")}
    assert not [found for found in geometry.diagnostics if "CONTACT" in found.code]


def test_faces_that_lie_on_each_other_touch():
    geometry = geometry_of(base_arm_hand(hand=ball(0.05)))
    (always,) = [one for one in geometry.excludes if one.reason == "Always"]
    assert always.depth == pytest.approx(0.0, abs=1e-6)


def slide(direction):
    """A frame whose z axis, along which it slides, is `direction`."""
    pose = at(*(0.06 * direction))
    pose[:3, :3] = turn(np.array([0.0, 1.0, 0.0]), math.copysign(math.pi / 2, direction[0]))
    return pose


def fingers(saved):
    """Two that slide towards each other on a palm, saved there."""
    return [
        joint(
            "prismatic",
            "palm",
            name,
            place=slide(sign * X),
            limits={f"{name}_joint": Limits(-0.06, 0.0)},
            saved=[saved],
        )
        for name, sign in (("left", 1), ("right", -1))
    ]


def test_fingers_that_touch_at_home_keep_touching_and_the_yaml_that_settles_it_is_shown(tmp_path):
    joints = fingers(-0.058)
    finger = box(0.01, 0.01, 0.01)
    shapes = {"palm": (box(0.01, 0.2, 0.01, at(0, 0.2, 0)),), "left": (finger,), "right": (finger,)}
    robot = robot_with(
        joints,
        shapes=shapes,
        root="palm",
        relations=[Relation("gear", "right_joint", "left_joint", 1.0, 0.0)],
    )
    geometry = geometry_of(robot)
    assert ("left", "right") not in reasons(geometry)
    (found,) = said(geometry, "W-SELF-CONTACT")
    assert "left and right (6.00 mm deep)" in found.message or not measures_overlaps()
    assert "`contact: {exclude: [[left, right]]}`" in found.hint
    model = model_of(robot, geometry, tmp_path)
    assert in_mujoco(model, robot, home(robot)) == {("left", "right")}
    settled = geometry_of(robot, exclude=[["left", "right"]])
    assert reasons(settled)["left", "right"] == "User"
    assert not said(settled, "W-SELF-CONTACT")
    assert in_mujoco(model_of(robot, settled, tmp_path), robot, home(robot)) == set()


def gripper(at_home=0.0):
    """Two fingers that slide towards each other, with racks that always overlap, and pads that meet."""
    joints = fingers(at_home)
    rack, pad = box(0.01, 0.01, 0.3), box(0.01, 0.01, 0.01, at(0, 0.1, 0))
    shapes = {"palm": (box(0.01, 0.2, 0.01, at(0, 0.5, 0)),), "left": (rack, pad), "right": (rack, pad)}
    gears = [Relation("gear", "right_joint", "left_joint", 1.0, 0.0)]
    return robot_with(joints, shapes=shapes, root="palm", relations=gears)


def test_of_fingers_whose_racks_always_overlap_the_pads_still_meet(tmp_path):
    robot = gripper()
    geometry = geometry_of(robot)
    (always,) = [one for one in geometry.excludes if one.reason == "Always"]
    assert (always.link_a, always.link_b, always.geoms) == ("left", "right", ((0, 0),))
    (found,) = said(geometry, "I-ALWAYS-CONTACT")
    assert found.message.endswith("mm deep), of which only box 0 against box 0")
    assert geometry.touching == ()
    model = model_of(robot, geometry, tmp_path)
    for q, met in ((-0.03, set()), (-0.0549, set()), (-0.0551, {(("left", 1), ("right", 1))})):
        values = {"left_joint": q, "right_joint": q}
        assert geoms_in_mujoco(model, robot, values) == met


def test_what_else_of_such_fingers_touches_at_home_is_reported_and_a_user_excludes_them_whole(tmp_path):
    robot = gripper(-0.058)
    geometry = geometry_of(robot)
    assert reasons(geometry)["left", "right"] == "Always"
    (touching,) = geometry.touching
    assert (touching.link_a, touching.link_b) == ("left", "right")
    assert touching.depth == close(0.006)
    assert "left and right (6.00 mm deep)" in said(geometry, "W-SELF-CONTACT")[0].message
    settled = geometry_of(robot, exclude=[["left", "right"]])
    (chosen,) = [one for one in settled.excludes if one.reason == "User"]
    assert (chosen.geoms, settled.touching) == ((), ())
    assert in_mujoco(model_of(robot, settled, tmp_path), robot, home(robot)) == set()


def test_poses_satisfy_relations():
    """Fingers that would part if each moved alone, but follow each other."""
    joints = [
        joint("prismatic", "palm", name, limits={f"{name}_joint": Limits(-0.1, 0.1)})
        for name in ("left", "right")
    ]
    shapes = {"left": (ball(0.01),), "right": (ball(0.01, at(0.015, 0, 0)),)}
    shapes["palm"] = (ball(0.01, at(0, 1, 0)),)
    bare = robot_with(joints, shapes=shapes, root="palm")
    assert not [one for one in geometry_of(bare).excludes if one.reason == "Always"]
    tied = replace(bare, relations=(Relation("gear", "right_joint", "left_joint", 1.0, 0.0),))
    assert reasons(geometry_of(tied))["left", "right"] == "Always"


def test_poses_close_loops():
    """The end of the coupler stays near its place as long as the rocker holds it."""
    four = four_bar({"drive": Limits(1.0, 1.2)})
    end = (link_poses(four, home(four))["coupler"] @ at(0.13, 0, 0))[:3, 3]
    shapes = {
        "base": (box(0.06, 0.06, 0.06, at(*end)),),
        "coupler": (ball(0.01, at(0.13, 0, 0)),),
        "crank": (ball(0.01, at(0, 0, 1)),),
        "rocker": (ball(0.01, at(0, 0, 2)),),
    }
    robot = replace(four, links=tuple(replace(link, shapes=shapes[link.name]) for link in four.links))
    assert reasons(geometry_of(robot))["base", "coupler"] == "Always"
    assert ("base", "coupler") not in reasons(geometry_of(replace(robot, loops=())))


def test_poses_stay_within_limits():
    shapes = {
        "base": (box(0.1, 0.1, 0.1),),
        "one": (box(0.01, 0.01, 0.01),),
        "two": (ball(0.02, at(0, 0, 0.06)),),
    }

    def robot(upper):
        joints = [joint("revolute", "base", "one")]
        joints += [joint("prismatic", "one", "two", limits={"two_joint": Limits(-0.005, upper)})]
        return robot_with(joints, shapes=shapes)

    assert reasons(geometry_of(robot(0.009)))["base", "two"] == "Always"
    assert ("base", "two") not in reasons(geometry_of(robot(0.05)))


def test_all_lets_everything_collide_but_what_the_user_names(tmp_path):
    robot = base_arm_hand(hand=ball(0.06))
    geometry = geometry_of(robot, self="all", exclude=[["ha*", "base"]])
    assert [(one.link_a, one.link_b, one.reason) for one in geometry.excludes] == [("base", "hand", "User")]
    assert not said(geometry, "W-SELF-CONTACT")
    assert ("base", "arm") in {(one.link_a, one.link_b) for one in geometry.touching}
    assert in_mujoco(model_of(robot, geometry, tmp_path), robot, home(robot)) == {("base", "arm")}


def test_none_writes_what_was_written_before(tmp_path):
    robot = base_arm_hand(hand=ball(0.06))
    geometry = geometry_of(robot, self="none")
    assert (geometry.self_contact, geometry.excludes) == (False, ())
    assert not [one for one in geometry.diagnostics if "CONTACT" in one.code]
    model = model_of(robot, geometry, tmp_path)
    text = (tmp_path / "robot.xml").read_text()
    assert 'contype="1" conaffinity="2"' in text
    assert "<contact" not in text
    assert in_mujoco(model, robot, home(robot)) == set()


def test_the_ground_and_other_objects_collide_whether_the_robot_meets_itself_or_not(tmp_path):
    import mujoco

    robot = base_arm_hand(hand=ball(0.3))
    for on in ("auto", "none", "all"):
        geometry = geometry_of(robot, self=on)
        model_of(robot, geometry, tmp_path)
        file = tmp_path / "robot.xml"
        file.write_text(re.sub(r"<keyframe>.*</keyframe>", "", file.read_text(), flags=re.DOTALL))
        spec = mujoco.MjSpec.from_file(str(tmp_path / "scene.xml"))
        thing = spec.worldbody.add_body(name="thing", pos=[0, 0, 0.4])
        thing.add_freejoint()
        thing.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.05, 0, 0])
        model = spec.compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        bodies = {
            frozenset(model.body(model.geom_bodyid[geom]).name for geom in one.geom)
            for one in data.contact[: data.ncon]
        }
        assert {frozenset({"world", "hand"}), frozenset({"thing", "hand"})} <= bodies, on


@pytest.mark.parametrize("self", ["auto", "all", "none"])
def test_globs_that_match_nothing_are_errors_that_list_the_links(self):
    with pytest.raises(MeshError) as caught:
        geometry_of(base_arm_hand(), self=self, exclude=[["arm", "leg*"], ["fo?t", "ar*"], ["hand", "h*"]])
    texts = [problem.message for problem in caught.value.problems]
    assert texts == [
        "no link matches 'leg*'",
        "no link matches 'fo?t'",
        "'hand' and 'h*' match the same link, which cannot touch itself",
    ]
    assert {problem.hint for problem in caught.value.problems} == {"links are: arm, base, hand"}


@pytest.mark.parametrize("wrong", [[["a"]], [["a", "b", "c"]], ["ab"], [["a", 1]], [["", "b"]]])
def test_what_is_no_pair_of_globs_is_refused(wrong):
    with pytest.raises(ConfigError, match=r"contact\.exclude"):
        plan_of(contact={"exclude": wrong})


def test_the_reason_is_that_of_the_joint_where_the_user_names_the_pair_too():
    geometry = geometry_of(base_arm_hand(hand=ball(0.049)), exclude=[["arm", "*"]])
    assert set(reasons(geometry).values()) == {"Adjacent"}


@pytest.mark.parametrize("kind", EVERY)
def test_no_type_of_joint_lets_its_links_collide(kind, tmp_path):
    """Nor the links that a format puts between them."""
    for fixed in (True, False):
        root = "world" if kind == "free" else "base"
        joints = [joint(kind, root, "one"), joint("revolute", "one", "two")]
        shapes = {name: (ball(0.05),) for name in ("base", "one", "two") if name != root or kind != "free"}
        robot = robot_with(joints, shapes=shapes, fixed=fixed or kind == "free", root=root)
        geometry = geometry_of(robot)
        touching = in_mujoco(model_of(robot, geometry, tmp_path), robot, home(robot))
        rigid_or_held = set(reasons(geometry))
        assert (
            touching == {pair for pair, off in apart(robot, home(robot)).items() if off < 0} - rigid_or_held
        )
        joined = [(one.parent, one.child) for one in joints if one.type != "free"]
        assert set(joined) <= rigid_or_held


@pytest.mark.parametrize("kind", [kind for kind in EVERY if kind != "free"])
def test_no_type_of_loop_lets_its_links_collide(kind, tmp_path):
    joints = [joint("revolute", "base", "one"), joint("revolute", "base", "two")]
    shapes = {name: (ball(0.05, at(0.2, 0, 0)),) for name in ("one", "two")}
    robot = robot_with(joints, loops=[loop(kind, "one", "two", np.eye(4), np.eye(4))], shapes=shapes)
    geometry = geometry_of(robot)
    assert reasons(geometry) == {("one", "two"): "Adjacent"}
    q = saved(robot)
    assert in_mujoco(model_of(robot, geometry, tmp_path), robot, q) == set()
    assert in_mujoco(model_of(robot, replace(geometry, excludes=()), tmp_path), robot, q) == {("one", "two")}


def test_the_same_excludes_whatever_the_order_of_links():
    def made(names):
        joints = [joint("revolute", "base", name, place=at(0, 0, 0.1)) for name in names]
        shapes = {"base": (ball(0.02),), **{name: (ball(0.03, at(0, 0.0, 0)),) for name in names}}
        return geometry_of(robot_with(joints, shapes=shapes))

    first, second = made(["a", "b", "c"]), made(["c", "a", "b"])
    assert {(frozenset((e.link_a, e.link_b)), e.reason, e.depth) for e in first.excludes} == {
        (frozenset((e.link_a, e.link_b)), e.reason, e.depth) for e in second.excludes
    }
    assert [e.reason for e in first.excludes].count("Always") == 3


def test_the_work_is_done_again_only_where_the_motion_or_a_collider_changes():
    keys = []

    def memo(kind, key, make):
        if kind == "mesh.contacts":
            keys.append(codec.dump(key))
        return make()

    robot = base_arm_hand()
    geometry_of(robot, memo)
    heavier = tuple(replace(link, inertial=replace(link.inertial, mass=5.0)) for link in robot.links)
    geometry_of(replace(robot, links=heavier), memo)
    geometry_of(base_arm_hand(hand=ball(0.06)), memo)
    geometry_of(robot, memo, self="all")
    geometry_of(robot, memo, exclude=[["base", "hand"]])
    arm, hand = robot.joints
    moved = replace(
        robot, joints=(arm, replace(hand, dofs=(replace(hand.dofs[0], limits=Limits(0.0, 1.0)),)))
    )
    geometry_of(moved, memo)
    assert keys[0] == keys[1]
    assert len(set(keys)) == 5


def test_the_geometry_travels_with_its_excludes():
    geometry = geometry_of(base_arm_hand(hand=ball(0.06)))
    again = codec.decode_geometry(codec.encode_geometry(geometry))
    assert again.excludes == geometry.excludes
    assert again.self_contact
    assert Exclude("base", "hand", "Always", 0.01) in again.excludes
    geometry = geometry_of(gripper())
    assert codec.decode_geometry(codec.encode_geometry(geometry)).excludes == geometry.excludes


def test_a_robot_without_colliders_has_no_excludes():
    robot = robot_with([joint("revolute", "base", "one")])
    assert geometry_of(robot).excludes == ()


def test_pairs_that_touch_are_found_however_few_poses_part_them(monkeypatch):
    """One of `POSES` poses suffices."""
    touched = []

    def touch(self, pair):
        touched.append(pair)
        return np.array([[len(touched) != analysis.POSES]])

    monkeypatch.setattr("linkwright.stages.mesh.contacts.colliders.Colliders.touching", touch)
    geometry = geometry_of(base_arm_hand(hand=ball(0.06)))
    assert len(touched) == analysis.POSES
    assert ("base", "hand") not in reasons(geometry)


def scattered(count, spread):
    """The colliders of so many links, a box and a ball each, at seeded places; and where the links are."""
    rng = np.random.default_rng(5)
    names = [f"link_{number}" for number in range(count)]
    pairs = [(box(*size), ball(size[0], at(*size))) for size in rng.uniform(0.02, 0.2, (count, 3))]
    shapes = [
        Shape(name, "collision", None, None, 0, 0, 0.0, 0.0, one)
        for name, own in zip(names, pairs, strict=True)
        for one in own
    ]
    return Colliders(shapes, {}), dict(zip(names, rng.uniform(0, spread, (count, 3)), strict=True))


def test_links_whose_boxes_meet_are_found_as_by_looking_at_all_pairs():
    colliders, places = scattered(40, 0.8)
    for link, place in places.items():
        colliders.place(link, at(*place))
    every = [*combinations(places, 2)]
    met = colliders.meeting([*places])
    assert met == sorted(met, key=every.index)
    assert 0 < len(met) < len(every)
    assert colliders.depths(met).keys() == colliders.depths(every).keys()
    assert colliders.meeting([]) == []


def test_the_pairs_that_are_looked_at_grow_with_the_links_and_not_with_their_square(monkeypatch):
    looked = set()
    monkeypatch.setattr(Colliders, "_depths", lambda self, pair, *_: looked.add(pair) or np.zeros((1, 1)))
    counted = []
    for count in (50, 400):
        looked.clear()
        names = [f"link_{number}" for number in range(count)]
        joints = [joint("revolute", "base", name, place=at(at_, 0, 0)) for at_, name in enumerate(names)]
        shapes = {name: (box(1.2, 0.6, 0.6),) for name in names}
        geometry_of(robot_with(joints, shapes=shapes))
        counted.append(len(looked))
    assert counted == [49, 399]
