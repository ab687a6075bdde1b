"""The SRDF beside a URDF: by the rules of MoveIt's reader, and as Pinocchio reads both."""

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from linkwright.stages.export.urdf.srdf import disabled
from linkwright.stages.robot.model.geometry import Exclude
from linkwright.stages.robot.model.robot import Frame, Keyframe, Limits, Relation, frozen
from linkwright.stages.robot.motion.start_pose import keyframes
from tests.support.building import NO_MESHES, plan_of, write
from tests.support.checked import srdf_checks
from tests.support.exports import losses_of
from tests.support.robots import EVERY, at, joint, loop, pose, robot_with, some_value
from tests.support.srdf import InPinocchio, Srdf
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


def semantics_of(outcome):
    """The SRDF, in which nothing breaks a rule."""
    semantics = Srdf(outcome.files["robot.srdf"], outcome.files["robot.urdf"])
    assert semantics.problems() == []
    return semantics


def passive(semantics):
    return [node.get("name") for node in semantics.root.iter("passive_joint")]


@pytest.fixture
def read(tmp_path):
    def reading(robot, geometry=NO_MESHES, **keys):
        semantics = semantics_of(made(robot, geometry, tmp_path, **keys))
        assert [check for check in srdf_checks(tmp_path) if not check.passed] == []
        return semantics

    return reading


@pytest.mark.parametrize("merged", ["keep", "merge"])
@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("kind", EVERY)
def test_joint_types_keep_the_rules_and_their_keyframes(kind, backwards, merged, tmp_path):
    rng = np.random.default_rng(EVERY.index(kind))
    saved = [some_value("ball", rng)] if kind == "ball" else None
    rows = [
        joint(kind, "base", "one", saved, place=pose(rng), backwards=backwards),
        hinge("one", "two", pose(rng)),
        joint("fixed", "two", "three", place=pose(rng)),
    ]
    robot = robot_with(rows, frames=[frame("tool", "three")])
    values = tuple((dof.name, 0.3) for dof in robot.dofs if dof.kind in ("turn", "slide"))
    robot = replace(robot, keyframes=(Keyframe("bent", values),))
    semantics = semantics_of(made(robot, NO_MESHES, tmp_path, urdf={"fixed_joints": merged}))
    by_reader = InPinocchio(tmp_path).states()
    assert set(by_reader) == {"home", "bent"}
    for name, by_pinocchio in by_reader.items():
        own = {
            joint: value
            for group in semantics.groups
            for joint, value in semantics.states(group)[name].items()
        }
        assert set(by_pinocchio) <= set(own)
        for states, dof in product((own, own | by_pinocchio), robot.dofs):
            value = keyframes(robot)[name][dof.name]
            if dof.kind == "ball":
                angles = [states[f"{dof.name}_{axis}"] for axis in "xyz"]
                off = Rotation.from_euler("XYZ", angles).inv() * Rotation.from_quat(np.roll(value, -1))
                assert off.magnitude() < 1e-9
            elif dof.kind != "free":
                assert states[dof.name] == pytest.approx(value, abs=1e-9)


def test_chain_goes_to_each_frame_and_to_each_end_without_one(read):
    frames = [frame("tool", "lower"), frame("eye", "upper"), frame("plate", "base")]
    semantics = read(arm(hinge("upper", "horn", at(0.1, 0, 0)), frames=frames))
    chains = {chain.getparent().get("name"): dict(chain.attrib) for chain in semantics.root.iter("chain")}
    assert chains == {name: {"base_link": "base", "tip_link": name} for name in ("eye", "tool", "horn")}
    assert semantics.groups["tool"] == {"upper_joint", "lower_joint"}
    assert semantics.groups["eye"] == {"upper_joint"}
    assert semantics.groups["all"] == {"upper_joint", "lower_joint", "horn_joint"}


def hands():
    rows = [hinge("base", f"{side}_hand") for side in "lr"]
    return robot_with(rows + [hinge(f"{s}_hand", f"{s}_finger_{n}") for s in "lr" for n in (1, 2)])


def flying():
    return robot_with([hinge("base", "one"), joint("free", "one", "drone"), hinge("drone", "blade")])


@pytest.mark.parametrize(("robot", "groups"), [
    (arm(), {"lower": "upper lower"}),
    (flying(), {"one": "one", "blade": "blade", "all": "one blade"}),
    (hands(), {
        "l_hand": "l_hand", "r_hand": "r_hand", "l_hand_gripper": "l_finger_1 l_finger_2",
        "r_hand_gripper": "r_finger_1 r_finger_2",
        "all": "l_hand r_hand l_finger_1 l_finger_2 r_finger_1 r_finger_2"}),
], ids=["one chain has all", "a link that flies", "two hands"])  # fmt: skip
def test_groups_are_chains_grippers_and_all(robot, groups, read):
    expected = {name: {f"{link}_joint" for link in links.split()} for name, links in groups.items()}
    assert read(robot).groups == expected


@pytest.mark.parametrize(("robot", "tip"), [
    (gripper(), "lower"),
    (gripper(frames=[frame("tool", "lower")]), "tool"),
    (gripper(arm_joints=[joint("fixed", "lower", "cover")]), "cover"),
], ids=["link", "frame", "cover"])  # fmt: skip
def test_fingers_that_move_together_are_a_gripper(robot, tip, read):
    semantics = read(robot)
    (hand,) = semantics.root.findall("end_effector")
    expected = {"name": "gripper", "parent_link": "lower", "group": "gripper", "parent_group": tip}
    assert dict(hand.attrib) == expected
    assert semantics.groups["gripper"] == {"left_joint", "right_joint"}
    assert set(semantics.groups) == {tip, "gripper", "all"}


@pytest.mark.parametrize(("robot", "is_gripper"), [
    (gripper(driver=None), False),
    (gripper(driver="lower_joint"), False),
    (arm(hinge("lower", "part", at(0, 0, 0.3), name="gripper")), True),
    (arm(hinge("lower", "moving_jaw", at(0, 0, 0.3), name="j6")), True),
    (arm(hinge("lower", "flange", at(0, 0, 0.3), name="j6")), False),
], ids=["two drivers", "a wrist drives", "called gripper", "a jaw", "a flange"])  # fmt: skip
def test_gripper_is_known_by_its_drive_or_its_name(robot, is_gripper, read):
    assert ("gripper" in read(robot).groups) == is_gripper


@pytest.mark.parametrize(("fixed", "kind"), [(True, "fixed"), (False, "floating")])
def test_base_is_held_or_floats_or_is_the_world(fixed, kind, read):
    (node,) = read(arm(fixed=fixed)).root.findall("virtual_joint")
    expected = {"name": "world_joint", "type": kind, "parent_frame": "world", "child_link": "base"}
    assert dict(node.attrib) == expected
    assert read(robot_with([hinge("world", "one")], root="world")).root.find("virtual_joint") is None


def test_names_that_are_taken_give_way(read):
    rows = [hinge("base", "all", name="world_joint"), hinge("all", "gripper"), hinge("base", "other")]
    semantics = read(robot_with(rows))
    assert semantics.root.find("virtual_joint").get("name") == "world_joint_2"
    assert semantics.groups["all"] != semantics.groups["gripper"]


def test_joints_that_nothing_drives_are_passive(read):
    robot = gripper()
    assert passive(read(robot, actuators={"upper_joint": "motor"})) == ["lower_joint", "left_joint"]
    assert passive(read(robot)) == passive(read(robot, actuators={"*": "motor"})) == []


def linkage(**more):
    """A four-bar linkage whose loop no <mimic> closes, with a tip on the far bar."""
    rows = [
        hinge("base", "crank", limits=(-0.5, 0.5)),
        hinge("base", "rocker", at(0.3, 0, 0), limits=(-3, 3)),
        hinge("crank", "rod", at(0, 0.1, 0), limits=(-3, 3)),
    ]
    closing = loop("revolute", "rod", "rocker", at(0.3, 0.05, 0), at(0, 0.15, 0))
    return robot_with(rows, loops=[closing], **more)


def test_joints_that_an_open_loop_determines_are_passive(read):
    driven, undriven = read(linkage(), actuators={"crank_joint": "motor"}), read(linkage())
    assert set(passive(driven)) == {"rocker_joint", "rod_joint"}
    assert len(passive(undriven)) == 2
    # A bar that only holds others in a loop is no end.
    assert sum(name in undriven.groups for name in ("rod", "rocker")) == 1


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
    reasons = semantics_of(made(robot, geometry, tmp_path)).disabled
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


@pytest.mark.parametrize(("gap", "apart"), [(0.2, True), (0.0005, False), (-0.002, False)])
def test_links_that_only_nearly_touch_are_not_said_to_stay_apart(gap, apart, tmp_path):
    """A ball on an arm passes a post by a gap that few poses see."""
    rows = [
        hinge("base", "one", limits=(-math.pi, math.pi)),
        hinge("one", "two", at(0.5, 0, 0), limits=(-3, 3)),
    ]
    post = ball(0.02, at(0.5 + 0.4 + 0.02 + 0.02 + gap, 0, 0))
    shapes = {"base": (post,), "one": (ball(0.01, at(0.25, 0, 0)),), "two": (ball(0.02, at(0.4, 0, 0)),)}
    robot = robot_with(rows, shapes=shapes)
    reasons = semantics_of(made(robot, geometry_of(robot), tmp_path)).disabled
    assert (reasons.get(("base", "two")) == "Never") == apart


def test_merged_link_brings_its_pairs_along(read):
    cover = joint("fixed", "lower", "cover", place=at(0, 0, 0.1))
    robot = arm(cover, shapes={"cover": (ball(0.03),)})
    geometry = geometry_of(robot)
    kept, merged = read(robot, geometry), read(robot, geometry, urdf={"fixed_joints": "merge"})
    assert ("lower", "cover") in kept.disabled
    assert not any("cover" in pair for pair in merged.disabled)
    assert merged.disabled["upper", "lower"] == "Adjacent"


def losses(robot, geometry, folder):
    return losses_of(made(robot, geometry, folder), "robot.srdf")


@pytest.mark.parametrize(("robot", "changes", "code", "words"), [
    (arm(), {}, None, ""),
    (arm(), {"self_contact": False, "excludes": ()}, "I-SRDF-SELF", ""),
    (arm(joint("free", "lower", "drone")), None, "I-SRDF-FREE", "drone_joint"),
    (linkage(), None, "I-SRDF-LOOP", "loop"),
    (arm(), {"excludes": (Exclude("base", "lower", "Always", 0.001, ((0, 0),)),)}, "I-SRDF-PARTLY",
     "base and lower"),
    (arm(), {"excludes": (Exclude("base", "lower", "Source", 0.0, ((0, 0),)),)}, "I-SRDF-PARTLY",
     "base and lower"),
])  # fmt: skip
def test_losses_of_an_srdf_are_told_by_name(robot, changes, code, words, tmp_path):
    geometry = NO_MESHES if changes is None else replace(geometry_of(robot), **changes)
    lost = losses(robot, geometry, tmp_path)
    assert words in lost[code] if code else lost == {}
    if code == "I-SRDF-SELF":
        assert set(lost) == {code}


def test_robot_of_very_many_links_has_no_pairs_worked_out(tmp_path, monkeypatch):
    """The pairs grow with the square of the links."""
    monkeypatch.setattr(disabled, "MAX_LINKS", 2)
    monkeypatch.setattr(disabled, "never_meeting", lambda *_: pytest.fail("pairs are worked out"))
    assert set(losses(arm(), geometry_of(arm()), tmp_path)) == {"I-SRDF-MANY"}


BROKEN = {
    "no such joint": ('<joint name="left_joint"/>', '<joint name="lost"/>'),
    "no chain": ('tip_link="lower"', 'tip_link="base"'),
    "a reason of nobody": ('reason="Adjacent"', 'reason="Always touching"'),
    "a pair twice": ('link2="lower" reason', 'link2="upper" reason'),
    "a value beyond its limits": ('name="upper_joint" value="0"', 'name="upper_joint" value="9"'),
    "a passive joint that is none": ("</robot>", '<passive_joint name="lost"/></robot>'),
    "a gripper that shares joints with its arm": ('parent_group="lower"', 'parent_group="all"'),
}


@pytest.mark.parametrize(("old", "new"), BROKEN.values(), ids=BROKEN)
def test_reader_of_these_tests_finds_faults(old, new, tmp_path):
    robot = gripper()
    files = made(robot, geometry_of(robot), tmp_path).files
    text = files["robot.srdf"].decode()
    assert old in text
    assert Srdf(text.replace(old, new).encode(), files["robot.urdf"]).problems()
