"""The SRDF beside a URDF: by the rules of MoveIt's reader, and as Pinocchio reads both."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from linkwright.stages.export.urdf.srdf import disabled
from linkwright.stages.robot.model.geometry import Exclude
from linkwright.stages.robot.model.robot import Frame, Keyframe, Limits, Relation, frozen
from linkwright.stages.robot.motion.start_pose import keyframes
from tests.support.building import NO_MESHES, plan_of, write
from tests.support.robots import EVERY, at, joint, loop, pose, robot_with
from tests.support.srdf import InPinocchio, Srdf
from tests.support.srdf_checks import srdf_checks
from tests.support.touching import ball, box, geometry_of


def hinge(parent, child, place=None, limits=(-1.5, 1.5), kind="revolute", name=None):
    name = name or f"{child}_joint"
    return joint(kind, parent, child, name=name, place=place, limits={name: Limits(*limits)})


def arm(*extra, **more):
    """Two boxes on hinges, 0.3 m apart, on a base."""
    rows = [hinge("base", "upper", at(0.15, 0, 0)), hinge("upper", "lower", at(0.3, 0, 0), (-3, 3))]
    shapes = {name: (box(0.2, 0.05, 0.05, at(0.12, 0, 0)),) for name in ("upper", "lower")}
    shapes["base"] = (box(0.2, 0.2, 0.05),)
    return robot_with([*rows, *extra], shapes=shapes | more.pop("shapes", {}), **more)


def gripper(arm_joints=(), driver="left_joint", **more):
    rows = [hinge("lower", "left", at(0.03, 0, 0.3)), hinge("lower", "right", at(-0.03, 0, 0.3))]
    relations = [Relation("gears", "right_joint", driver, -1.0, 0.0)] if driver else []
    return arm(*arm_joints, *rows, relations=relations, **more)


def frame(name, link):
    return Frame(name, link, frozen(at(0, 0, 0.2)), name)


def made(robot, geometry, folder, **keys):
    return write(robot, folder, plan_of(export={"urdf": keys.pop("urdf", {})}, **keys), geometry)


@pytest.fixture
def read(tmp_path):
    def reading(robot, geometry=NO_MESHES, **keys):
        files = made(robot, geometry, tmp_path, **keys).files
        semantics = Srdf(files["robot.srdf"], files["robot.urdf"])
        assert semantics.problems() == []
        assert [check for check in srdf_checks(tmp_path) if not check.passed] == []
        return semantics

    return reading


@pytest.mark.parametrize("merged", ["keep", "merge"])
@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("kind", EVERY)
def test_joint_types_keep_the_rules_and_their_keyframes(kind, backwards, merged, tmp_path):
    rng = np.random.default_rng(EVERY.index(kind))
    quat = rng.normal(size=4)
    saved = {"ball": [tuple(quat / np.linalg.norm(quat))]}.get(kind)
    rows = [
        joint(kind, "base", "one", saved, place=pose(rng), backwards=backwards),
        hinge("one", "two", pose(rng)),
        joint("fixed", "two", "three", place=pose(rng)),
    ]
    robot = robot_with(rows, frames=[frame("tool", "three")])
    values = tuple((dof.name, 0.3) for dof in robot.dofs if dof.kind in ("turn", "slide"))
    robot = replace(robot, keyframes=(Keyframe("bent", values),))
    files = made(robot, NO_MESHES, tmp_path, urdf={"fixed_joints": merged}).files
    semantics = Srdf(files["robot.srdf"], files["robot.urdf"])
    assert semantics.problems() == []
    by_reader = InPinocchio(tmp_path).states()
    assert set(by_reader) == {"home", "bent"}
    for name, values in keyframes(robot).items():
        if name == "cad":
            continue
        own = {
            key: value for group in semantics.groups for key, value in semantics.states(group)[name].items()
        }
        assert set(by_reader[name]) <= set(own)
        for states in (own, own | by_reader[name]):
            for dof in robot.dofs:
                value = values[dof.name]
                if dof.kind == "ball":
                    angles = [states[f"{dof.name}_{axis}"] for axis in "xyz"]
                    off = Rotation.from_euler("XYZ", angles).inv() * Rotation.from_quat(np.roll(value, -1))
                    assert off.magnitude() < 1e-9
                elif dof.kind != "free":
                    assert states[dof.name] == pytest.approx(value, abs=1e-9)


def test_a_chain_goes_to_each_frame_and_to_each_end_without_one(read):
    side = hinge("upper", "horn", at(0.1, 0, 0))
    semantics = read(
        arm(side, frames=[frame("tool", "lower"), frame("eye", "upper"), frame("plate", "base")])
    )
    chains = {
        group.get("name"): dict(group.find("chain").attrib)
        for group in semantics.root.findall("group")
        if group.find("chain") is not None
    }
    assert chains == {name: {"base_link": "base", "tip_link": name} for name in ("eye", "tool", "horn")}
    assert semantics.groups["tool"] == {"upper_joint", "lower_joint"}
    assert semantics.groups["eye"] == {"upper_joint"}
    assert semantics.groups["all"] == {"upper_joint", "lower_joint", "horn_joint"}


def test_there_is_no_group_of_all_where_one_chain_has_all(read):
    assert set(read(arm()).groups) == {"lower"}


@pytest.mark.parametrize(("robot", "tip"), [
    (gripper(), "lower"),
    (gripper(frames=[frame("tool", "lower")]), "tool"),
    (gripper(arm_joints=[joint("fixed", "lower", "cover")]), "cover"),
], ids=["link", "frame", "cover"])  # fmt: skip
def test_fingers_that_move_together_are_a_gripper(robot, tip, read):
    semantics = read(robot)
    (hand,) = semantics.root.findall("end_effector")
    assert dict(hand.attrib) == {
        "name": "gripper", "parent_link": "lower", "group": "gripper", "parent_group": tip,
    }  # fmt: skip
    assert semantics.groups["gripper"] == {"left_joint", "right_joint"}
    assert set(semantics.groups) == {tip, "gripper", "all"}


def test_what_only_looks_like_a_gripper_is_none(read):
    assert "gripper" not in read(gripper(driver=None)).groups
    # A wrist that the fingers follow is no finger.
    assert "gripper" not in read(gripper(driver="lower_joint")).groups


@pytest.mark.parametrize(
    ("name", "child", "is_one"),
    [("gripper", "part", True), ("j6", "moving_jaw", True), ("j6", "flange", False)],
)
def test_a_joint_that_is_called_so_is_a_gripper(name, child, is_one, read):
    semantics = read(arm(hinge("lower", child, at(0, 0, 0.3), name=name)))
    assert ("gripper" in semantics.groups) == is_one


def test_two_hands_have_names_of_their_own(read):
    rows = []
    for side in ("l", "r"):
        rows.append(hinge("base", f"{side}_hand"))
        rows += [hinge(f"{side}_hand", f"{side}_finger_{n}") for n in (1, 2)]
    semantics = read(robot_with(rows))
    assert {"l_hand", "r_hand", "l_hand_gripper", "r_hand_gripper", "all"} == set(semantics.groups)


def test_a_link_that_flies_is_the_base_of_its_own_groups(read):
    rows = [hinge("base", "one"), joint("free", "one", "drone"), hinge("drone", "blade")]
    semantics = read(robot_with(rows))
    assert semantics.groups == {
        "one": {"one_joint"}, "blade": {"blade_joint"}, "all": {"one_joint", "blade_joint"},
    }  # fmt: skip


def test_the_base_is_held_or_floats_or_is_the_world(read):
    for fixed, kind in ((True, "fixed"), (False, "floating")):
        (node,) = read(arm(fixed=fixed)).root.findall("virtual_joint")
        assert dict(node.attrib) == {
            "name": "world_joint", "type": kind, "parent_frame": "world", "child_link": "base",
        }  # fmt: skip
    assert read(robot_with([hinge("world", "one")], root="world")).root.find("virtual_joint") is None


def test_names_that_are_taken_give_way(read):
    rows = [hinge("base", "all", name="world_joint"), hinge("all", "gripper"), hinge("base", "other")]
    semantics = read(robot_with(rows))
    assert semantics.root.find("virtual_joint").get("name") == "world_joint_2"
    assert semantics.groups["all"] != semantics.groups["gripper"]


def test_what_nothing_drives_is_passive(read):
    robot = replace(gripper(), actuators=())
    names = [
        passive_joint.get("name")
        for passive_joint in read(robot, actuators={"upper_joint": "motor"}).root.iter("passive_joint")
    ]
    assert names == ["lower_joint", "left_joint"]
    assert not list(read(robot).root.iter("passive_joint"))
    driven = {"*": "motor"}
    assert not list(read(robot, actuators=driven).root.iter("passive_joint"))


def linkage(**more):
    """A four-bar linkage whose loop no <mimic> closes, with a tip on the far bar."""
    rows = [
        hinge("base", "crank", limits=(-0.5, 0.5)),
        hinge("base", "rocker", at(0.3, 0, 0), limits=(-3, 3)),
        hinge("crank", "rod", at(0, 0.1, 0), limits=(-3, 3)),
    ]
    closing = loop("revolute", "rod", "rocker", at(0.3, 0.05, 0), at(0, 0.15, 0))
    return robot_with(rows, loops=[closing], **more)


def test_in_an_open_loop_what_the_others_determine_is_passive(read):
    semantics = read(linkage(), actuators={"crank_joint": "motor"})
    assert {passive_joint.get("name") for passive_joint in semantics.root.iter("passive_joint")} == {
        "rocker_joint",
        "rod_joint",
    }
    semantics = read(linkage())
    assert len(list(semantics.root.iter("passive_joint"))) == 2


def test_a_bar_that_only_holds_others_in_a_loop_is_no_end(read):
    groups = read(linkage()).groups
    assert sum(name in groups for name in ("rod", "rocker")) == 1


def test_reasons_are_true_and_pinocchio_checks_the_rest(tmp_path):
    far = joint("fixed", "base", "mast", place=at(-2, 0, 0))
    # Two plates that lie in each other in every pose, next to no joint of each other.
    wheel = hinge("base", "wheel", at(0, 0.5, 0))
    block = hinge("base", "block", at(0, 0.55, 0), limits=(-0.1, 0.1))
    robot = arm(
        far, wheel, block, hinge("lower", "hand", at(0.3, 0, 0)),
        shapes={
            "mast": (ball(0.05),), "wheel": (ball(0.06),), "block": (ball(0.06),),
            "hand": (box(0.1, 0.04, 0.04, at(0.06, 0, 0)),),
        },
    )  # fmt: skip
    geometry = geometry_of(robot, exclude=[["wheel", "hand"]])
    files = made(robot, geometry, tmp_path).files
    semantics = Srdf(files["robot.srdf"], files["robot.urdf"])
    assert semantics.problems() == []
    reasons = semantics.disabled
    for pair in (("base", "upper"), ("upper", "lower"), ("lower", "hand"), ("base", "mast")):
        assert reasons[pair] == "Adjacent"
    assert (reasons["wheel", "block"], reasons["wheel", "hand"]) == ("Default", "User")
    assert reasons["upper", "mast"] == "Never"
    # It reaches the base.
    assert ("base", "hand") not in reasons
    reader = InPinocchio(tmp_path)
    solid = [link.name for link in robot.links if link.shapes]
    all_pairs = {frozenset((a, b)) for i, a in enumerate(solid) for b in solid[:i]}
    # Pinocchio leaves out by itself what is on one joint of its own.
    rigid = frozenset(("base", "mast"))
    assert reader.active() == all_pairs - {frozenset(pair) for pair in reasons} - {rigid}
    never = {pair for pair, reason in reasons.items() if reason == "Never"}
    assert reader.touching(never, 1000, 7) == set()
    assert reader.touching({("base", "hand")}, 1000, 7)


def test_links_that_only_nearly_touch_are_not_said_to_stay_apart(tmp_path):
    """A ball on an arm passes a post by a gap that few poses see."""
    rows = [
        hinge("base", "one", limits=(-math.pi, math.pi)),
        hinge("one", "two", at(0.5, 0, 0), limits=(-3, 3)),
    ]
    for gap, apart in ((0.2, True), (0.0005, False), (-0.002, False)):
        post = 0.5 + 0.4 + 0.02 + 0.02 + gap
        shapes = {
            "base": (ball(0.02, at(post, 0, 0)),),
            "one": (ball(0.01, at(0.25, 0, 0)),),
            "two": (ball(0.02, at(0.4, 0, 0)),),
        }
        robot = robot_with(rows, shapes=shapes)
        files = made(robot, geometry_of(robot), tmp_path).files
        reasons = Srdf(files["robot.srdf"], files["robot.urdf"]).disabled
        assert (reasons.get(("base", "two")) == "Never") == apart


def test_a_merged_link_brings_its_pairs_along(read):
    cover = joint("fixed", "lower", "cover", place=at(0, 0, 0.1))
    robot = arm(cover, shapes={"cover": (ball(0.03),)})
    geometry = geometry_of(robot)
    kept, merged = read(robot, geometry), read(robot, geometry, urdf={"fixed_joints": "merge"})
    assert ("lower", "cover") in kept.disabled
    assert not any("cover" in pair for pair in merged.disabled)
    assert merged.disabled["upper", "lower"] == "Adjacent"


def losses(robot, geometry, folder):
    diagnostics = made(robot, geometry, folder).diagnostics
    return {problem.code: problem.message for problem in diagnostics if problem.where == "robot.srdf"}


def test_what_an_srdf_cannot_say_is_told_by_name(tmp_path):
    assert losses(arm(), geometry_of(arm()), tmp_path) == {}
    none = geometry_of(arm())
    none = replace(none, self_contact=False, excludes=())
    assert set(losses(arm(), none, tmp_path)) == {"I-SRDF-SELF"}
    flying = arm(joint("free", "lower", "drone"))
    assert "drone_joint" in losses(flying, NO_MESHES, tmp_path)["I-SRDF-FREE"]
    assert "loop" in losses(linkage(), NO_MESHES, tmp_path)["I-SRDF-LOOP"]
    partly = replace(geometry_of(arm()), excludes=(Exclude("base", "lower", "Always", 0.001, ((0, 0),)),))
    assert "base and lower" in losses(arm(), partly, tmp_path)["I-SRDF-PARTLY"]


def test_of_a_robot_of_very_many_links_no_pair_is_worked_out(tmp_path, monkeypatch):
    """The pairs grow with the square of the links."""
    monkeypatch.setattr(disabled, "MAX_LINKS", 2)
    monkeypatch.setattr(disabled, "never_meeting", lambda *_: pytest.fail("pairs are worked out"))
    assert set(losses(arm(), geometry_of(arm()), tmp_path)) == {"I-SRDF-MANY"}


BROKEN = {
    "no such joint": ('<joint name="left_joint"/>', '<joint name="lost"/>'),
    "no chain": ('tip_link="lower"', 'tip_link="base"'),
    "a reason of nobody": ('reason="Adjacent"', 'reason="Always touching"'),
    "a pair twice": ('link2="lower" reason', 'link2="upper" reason'),
    "a value beyond its limits": (
        '<joint name="upper_joint" value="0"/>',
        '<joint name="upper_joint" value="9"/>',
    ),
    "a passive joint that is none": ("</robot>", '<passive_joint name="lost"/></robot>'),
    "a gripper that shares joints with its arm": ('parent_group="lower"', 'parent_group="all"'),
}


@pytest.mark.parametrize("name", BROKEN)
def test_the_reader_of_these_tests_finds_what_is_wrong(name, tmp_path):
    robot = gripper()
    files = made(robot, geometry_of(robot), tmp_path).files
    text = files["robot.srdf"].decode()
    old, new = BROKEN[name]
    assert old in text
    assert Srdf(text.replace(old, new).encode(), files["robot.urdf"]).problems()
