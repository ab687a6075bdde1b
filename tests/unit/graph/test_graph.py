"""What the graph stage makes of small assemblies that a designer might draw."""

import math

import numpy as np
import pytest
import yaml

from linkwright.stages.robot.codec import encode_robot
from linkwright.stages.robot.errors import AssemblyError, Disconnected, NoRoot
from linkwright.stages.robot.model.robot import Limits
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration
from tests.fake_onshape import solids
from tests.fake_onshape.document import ORIGIN
from tests.fake_onshape.frames import turn
from tests.support.building import plan_of, robot_of
from tests.support.checked import failures
from tests.support.kit import SIDE, TOP, four_bar
from tests.support.reported import codes, only


def links_of(kit, **keys):
    return [link.name for link in robot_of(kit.document, plan_of(**keys)).links]


@pytest.mark.parametrize("first_is_child", [True, False])
def test_q_is_the_first_entity_relative_to_the_second(kit, first_is_child):
    base, arm = kit.based("Arm")
    sides = [(arm, TOP), (base, SIDE)]
    kit.root.revolute("Elbow", *(sides if first_is_child else sides[::-1]), value=0.4, limits=(-0.5, 1.5))
    robot = robot_of(kit.document)
    (joint,), (dof,) = robot.joints, robot.dofs
    assert (joint.parent, joint.child, joint.backwards) == ("base", "arm", not first_is_child)
    assert dof.saved == pytest.approx(0.4, abs=1e-12)
    assert dof.limits == Limits(-0.5, 1.5)
    assert dof.axis[2] == (1 if first_is_child else -1)
    pose = link_poses(robot, {"elbow": 1.0})["arm"] @ robot.link("arm").parts[0].link_from_part
    assert np.abs(pose - kit.document.truth.poses({"Elbow": 1.0})[arm.path]).max() < 1e-12


def test_fastened_parts_and_groups_are_one_link(kit):
    base, plate, screw, arm = kit.based("Plate", "Screw", "Arm")
    kit.root.fasten("Bolt", (plate, TOP), (base, SIDE))
    kit.root.group("Glue", [(plate, np.eye(4)), (screw, TOP)])
    kit.root.revolute("Elbow", (arm, TOP), (screw, SIDE))
    robot = robot_of(kit.document)
    assert [(link.name, len(link.parts)) for link in robot.links] == [("screw", 3), ("arm", 1)]
    assert robot.root.inertial.mass == pytest.approx(3 * 0.06, rel=1e-12)


def test_joints_inside_a_sub_assembly_used_twice_are_two_joints(kit):
    finger = kit.document.assembly("Finger")
    palm, tip = kit.place("Palm", finger), kit.place("Tip", finger)
    bend = finger.revolute("Bend", (tip, TOP), (palm, SIDE), value=0.1, limits=(0, 1))
    hand = kit.place("Hand", fixed=True)
    left, right = kit.root.add(finger), kit.root.add(finger)
    kit.root.fasten("Left", (left / palm, TOP), (hand, SIDE))
    kit.root.fasten("Right", (right / palm, TOP), (hand, TOP))
    kit.document.set_value(right, bend, 0.7)
    robot = robot_of(kit.document)
    assert {dof.name: round(dof.saved, 9) for dof in robot.dofs} == {"finger_bend": 0.1, "finger_2_bend": 0.7}
    assert sorted(link.name for link in robot.links) == ["finger_2_tip", "finger_tip", "palm"]


def upper_arm(kit):
    """A sub-assembly of two parts that is a link, on a hinge."""
    upper = kit.document.assembly("Upper arm")
    shell, rib = kit.place("Shell", upper), kit.place("Rib", upper)
    upper.fasten("Weld", (rib, TOP), (shell, SIDE))
    base, arm = kit.place("Base", fixed=True), kit.root.add(upper)
    kit.root.revolute("Shoulder", (arm / shell, TOP), (base, SIDE), limits=(0, 1))
    return arm, rib


def test_a_sub_assembly_names_its_link_even_with_a_screw_added(kit):
    arm, rib = upper_arm(kit)
    assert links_of(kit) == ["base", "upper_arm"]
    screw = kit.root.add(kit.studio.part("Screw", solids.box(0.004, 0.004, 0.01), density=7800))
    kit.root.fasten("Screwed", (screw, TOP), (arm / rib, SIDE))
    assert links_of(kit) == ["base", "upper_arm"]


def test_connectors_become_frames_and_link_connectors_names(kit):
    _, arm = kit.elbow()
    kit.root.connector("Tool point", arm, SIDE)
    kit.root.connector("link_forearm", arm, TOP)
    robot = robot_of(kit.document)
    assert [link.name for link in robot.links] == ["base", "forearm"]
    (tool,) = robot.frames
    assert (tool.name, tool.link) == ("tool_point", "forearm")
    world = link_poses(robot, saved_configuration(robot))["forearm"] @ tool.link_from_frame
    assert np.abs(world - kit.document.truth.poses()[arm.path] @ SIDE).max() < 1e-12


def test_connectors_on_a_rigid_sub_assembly_are_kept(kit):
    arm, _ = upper_arm(kit)
    kit.root.connector("link_boom", arm, TOP)
    kit.root.connector("Tool", arm, SIDE)
    robot = robot_of(kit.document)
    assert [link.name for link in robot.links] == ["base", "boom"]
    assert [(frame.name, frame.link) for frame in robot.frames] == [("tool", "boom")]
    assert not codes(robot)


def geared(kit, values, limits, ratio, **more):
    """Two hinges of these values and limits, which a gear relates."""
    base, *parts = kit.based("One", "Two")
    sides = zip(("First", "Second"), parts, (SIDE, TOP), values, limits, strict=True)
    mates = [
        kit.root.revolute(name, (part, TOP), (base, side), q, ends) for name, part, side, q, ends in sides
    ]
    kit.root.gear("Gear", *mates, ratio, **more)
    return robot_of(kit.document)


@pytest.mark.parametrize("degrees", [0, 90, 180])
def test_two_gears_drawn_opposite_turn_against_each_other(kit, degrees, tmp_path):
    at = math.radians(degrees)
    robot = geared(kit, (at, at), ((-7, 7), (-7, 7)), 1.0, offset=2 * at)
    (relation,) = robot.relations
    assert relation.multiplier == -1.0
    assert abs(relation.offset) == pytest.approx(math.remainder(2 * at, math.tau) % math.tau)
    assert failures(tmp_path, robot) == []
    assert b'multiplier="-1"' in (tmp_path / "robot.urdf").read_bytes()
    assert b"-1 0 0 0" in (tmp_path / "robot.xml").read_bytes()


@pytest.mark.parametrize("kind", ["GEAR", "LINEAR", "RACK_AND_PINION", "SCREW"])
@pytest.mark.parametrize("reverse", [False, True])
def test_the_sign_of_all_four_relations_is_as_drawn(kit, kind, reverse, tmp_path):
    """Saved where the opposite direction fits exactly."""
    base, part = kit.based("One")
    k = {"GEAR": 1.5, "LINEAR": 1.5}.get(kind, 0.05 / math.tau)
    at = 0.02 if kind == "LINEAR" else 0.4
    saved, root = (-k if reverse else k) * at, kit.root
    if kind == "SCREW":
        ends = (root.cylindrical("C", (part, TOP), (base, SIDE), (saved, at), ((-1, 1), (-9, 9))),)
    else:
        begin = root.slider if kind == "LINEAR" else root.revolute
        end = root.slider if kind != "GEAR" else root.revolute
        ends = (
            begin("First", (part, TOP), (base, SIDE), value=at, limits=(-9, 9)),
            end("Second", (kit.place("Two"), TOP), (base, TOP), value=saved, limits=(-9, 9)),
        )
    make = {"GEAR": root.gear, "LINEAR": root.linear, "RACK_AND_PINION": root.rack, "SCREW": root.screw}
    amount = 1.5 if kind in ("GEAR", "LINEAR") else 0.05
    make[kind]("Tie", *ends, amount, reverse=reverse, offset=2 * saved)
    robot = robot_of(kit.document)
    (relation,) = robot.relations
    assert (relation.multiplier, relation.offset) == pytest.approx((k if reverse else -k, 2 * saved))
    assert failures(tmp_path, robot) == []
    hint = only(robot, "W-RELATION-SIGN").hint
    line = next(word for word in hint.split(", ") if "invert" in word)
    hinted = yaml.safe_load(line.split("; ")[0].removeprefix("if it moves in the opposite direction, "))
    settled = robot_of(kit.document, plan_of(**hinted))
    assert settled.relations[0].multiplier == pytest.approx(-k if reverse else k)
    assert (settled.relations[0].offset, codes(robot), codes(settled)) == (0.0, ["W-RELATION-SIGN"], [])


def test_a_follower_is_saved_at_the_turn_that_its_driver_gives(kit, tmp_path):
    """−2 · 2.5 rad is more than half a turn: the pose alone would say 1.28."""
    robot = geared(kit, (2.5, -5.0), ((-3, 3), (-7, 7)), 2.0)
    assert {dof.name: round(dof.saved, 9) for dof in robot.dofs} == {"first": 2.5, "second": -5.0}
    assert not codes(robot)
    assert failures(tmp_path, robot) == []


def test_a_loop_is_kept_and_the_driven_mate_stays_in_the_tree(kit):
    four_bar(kit, limits=True)
    robot = robot_of(kit.document)
    (loop,) = robot.loops
    assert {joint.name for joint in robot.joints} | {loop.name} == {"drive", "pin", "swing", "close"}
    assert loop.name != "drive"
    assert loop.residual < 1e-12
    assert 0.04 < loop.lever < 0.06
    assert "W-LOOP-LIMIT" in codes(robot)
    for seed in range(5):
        assert encode_robot(robot_of(kit.document, shuffle=seed)) == encode_robot(robot)


@pytest.mark.parametrize("select", ["arm", "Arm <1>", "Arm*", "a?m"])
def test_the_root_can_be_chosen_by_name(kit, select):
    kit.elbow(value=0.3, limits=(0, 1))
    robot = robot_of(kit.document, plan_of(root={"select": select, "base": "free"}))
    assert (robot.root.name, robot.base.fixed) == ("arm", False)
    assert robot.dofs[0].limits == Limits(0.0, 1.0)
    assert codes(robot_of(kit.document, plan_of(root={"select": select}))) == ["W-BASE"]


def test_fastening_to_the_origin_fixes_the_base(kit):
    base, arm = kit.place("Base"), kit.root.add(kit.bar("Arm", density=9000))
    kit.root.fasten("Anchor", (base, TOP), (ORIGIN, np.eye(4)))
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE))
    robot = robot_of(kit.document)
    assert (robot.root.name, robot.base.fixed) == ("base", True)
    assert "Anchor" in robot.base.reason


def test_a_single_part_is_a_robot_but_two_without_mates_are_not(kit):
    kit.place("Brick")
    robot = robot_of(kit.document)
    assert ([link.name for link in robot.links], robot.base.fixed) == (["brick"], False)
    kit.place("Two")
    with pytest.raises(AssemblyError, match="no mates"):
        robot_of(kit.document)


def test_limits_that_are_equal_lock_the_joint_with_a_little_play(kit, tmp_path):
    kit.elbow(value=0.5, limits=(0.5, 0.5))
    robot = robot_of(kit.document)
    assert codes(robot) == ["W-LIMIT-LOCKED"]
    assert failures(tmp_path, robot) == []


def test_adding_an_instance_renames_no_link(kit):
    finger = kit.document.assembly("Finger")
    tip = kit.place("Tip", finger)
    finger.connector("link_fingertip", tip, TOP)
    base, names = kit.place("Base", fixed=True), {}
    for count in range(1, 12):
        finger_path = kit.root.add(finger)
        kit.root.revolute(f"Bend {count}", (finger_path / tip, TOP), (base, turn((1, 0, 0), count)))
        links = robot_of(kit.document).links
        by_name = {link.parts[0].path: link.name for link in links if link.name != "base"}
        if count > 2:
            assert {path: by_name[path] for path in names} == names
        names = by_name
    assert names[finger_path.path + tip.path] == "finger_11_fingertip"


def test_names_without_a_legal_letter_are_reported(kit):
    base, arm = kit.based("机械臂")
    kit.root.revolute("关节", (arm, TOP), (base, SIDE), limits=(0, 1))
    robot = robot_of(kit.document)
    assert [link.name for link in robot.links] == ["base", "unnamed"]
    assert codes(robot) == ["W-NAME", "W-NAME"]


def refused(kit, error=AssemblyError, **keys):
    """The code and place of each problem, and the whole text."""
    with pytest.raises(error) as caught:
        robot_of(kit.document, plan_of(**keys))
    return [(problem.code, problem.where) for problem in caught.value.problems], str(caught.value)


def test_problems_of_parts_and_joints_are_reported_together(kit):
    base, arm = kit.place("Base", fixed=True), kit.root.add(kit.bar("Arm", density=None))
    kit.root.revolute("Hinge", (arm, TOP), (base, SIDE), limits=(1.0, -1.0))
    problems, text = refused(
        kit,
        joints={"knee": {"damping": 1}},
        names={"links": {"Leg": "leg"}},
        loops={"cut": ["Knee"]},
        frames={"include": ["tip*"]},
    )
    globs = [("E-GLOB", key) for key in ("frames.include", "joints", "loops.cut")]
    assert problems == [*globs, ("E-LIMIT", "hinge"), ("E-MASS", "Arm <1>"), ("E-RENAME", "names.links")]
    assert "joints are: hinge" in text


def test_loose_parts_are_reported_with_earlier_problems(kit):
    kit.place("Base", fixed=True)
    crate, lid = kit.root.add(kit.bar("Crate", density=None)), kit.place("Lid")
    kit.root.fasten("Shut", (lid, TOP), (crate, TOP))
    kit.place("Lost")
    problems, _ = refused(kit, Disconnected, names={"links": {"Leg": "leg"}})
    assert [code for code, _ in problems] == ["E-MASS", "E-RENAME", "E-LOOSE", "E-LOOSE"]
    assert [where for _, where in problems[2:]] == ["Crate <1>", "Lost <1>"]
    problems, text = refused(kit, NoRoot, root={"select": "leg"})
    assert [code for code, _ in problems] == ["E-MASS"]
    assert "name one of: base, " in text
