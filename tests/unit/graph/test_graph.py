"""What the graph stage makes of small assemblies that a designer might draw."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from linkwright.stages.graph import build_robot
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.errors import AssemblyError, Disconnected, NoRoot, ProtocolError
from linkwright.stages.robot.model.robot import Limits, Robot
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration
from tests.fake_onshape import solids
from tests.fake_onshape.document import ORIGIN
from tests.fake_onshape.frames import turn
from tests.support.building import bundle_of, plan_of, robot_of, write
from tests.support.checked import checked
from tests.support.kit import SIDE, TOP, Kit, four_bar


def codes(robot: Robot) -> list[str]:
    return sorted(diagnostic.code for diagnostic in robot.diagnostics)


@pytest.mark.parametrize("first_is_child", [True, False])
def test_q_is_the_first_entity_relative_to_the_second_whichever_is_the_child(
    kit: Kit, first_is_child: bool
) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    sides = [(arm, TOP), (base, SIDE)]
    kit.root.revolute("Elbow", *(sides if first_is_child else sides[::-1]), value=0.4, limits=(-0.5, 1.5))
    robot = robot_of(kit.document)
    (joint,), (dof,) = robot.joints, robot.dofs
    assert (joint.parent, joint.child) == ("base", "arm")
    assert joint.backwards == (not first_is_child)
    assert dof.saved == pytest.approx(0.4, abs=1e-12)
    assert dof.limits == Limits(-0.5, 1.5)
    assert dof.axis[2] == (1 if first_is_child else -1)
    pose = link_poses(robot, {"elbow": 1.0})["arm"] @ robot.link("arm").parts[0].link_from_part
    assert np.abs(pose - kit.document.truth.poses({"Elbow": 1.0})[arm.path]).max() < 1e-12


def test_sliders_take_their_limits_in_metres_and_may_be_open_on_one_side(kit: Kit) -> None:
    base, cart = kit.place("Base", fixed=True), kit.place("Cart")
    kit.root.slider("Rail", (cart, TOP), (base, SIDE), value=0.2, limits=(None, 0.3))
    (joint,) = robot_of(kit.document).joints
    (dof,) = joint.dofs
    assert joint.type == "prismatic"
    assert dof.limits == Limits(None, 0.3)
    assert dof.saved == pytest.approx(0.2, abs=1e-12)


def test_fastened_parts_and_groups_are_one_link(kit: Kit) -> None:
    base, plate, screw = kit.place("Base", fixed=True), kit.place("Plate"), kit.place("Screw")
    arm = kit.place("Arm")
    kit.root.fasten("Bolt", (plate, TOP), (base, SIDE))
    kit.root.group("Glue", [(plate, np.eye(4)), (screw, TOP)])
    kit.root.revolute("Elbow", (arm, TOP), (screw, SIDE))
    robot = robot_of(kit.document)
    assert [link.name for link in robot.links] == ["screw", "arm"]
    assert len(robot.root.parts) == 3
    assert robot.root.inertial.mass == pytest.approx(3 * 0.06, rel=1e-12)


def test_joints_inside_a_sub_assembly_used_twice_are_two_joints(kit: Kit) -> None:
    finger = kit.document.assembly("Finger")
    palm, tip = kit.place("Palm", finger), kit.place("Tip", finger)
    bend = finger.revolute("Bend", (tip, TOP), (palm, SIDE), value=0.1, limits=(0, 1))
    hand = kit.place("Hand", fixed=True)
    left, right = kit.root.add(finger), kit.root.add(finger)
    kit.root.fasten("Left", (left / palm, TOP), (hand, SIDE))
    kit.root.fasten("Right", (right / palm, TOP), (hand, TOP))
    kit.document.set_value(right, bend, 0.7)
    robot = robot_of(kit.document)
    assert {dof.name: round(dof.saved, 9) for dof in robot.dofs} == {
        "finger_bend": 0.1,
        "finger_2_bend": 0.7,
    }
    assert sorted(link.name for link in robot.links) == ["finger_2_tip", "finger_tip", "palm"]


def test_a_sub_assembly_that_is_a_link_names_it_even_with_a_screw_added(kit: Kit) -> None:
    upper = kit.document.assembly("Upper arm")
    shell, rib = kit.place("Shell", upper), kit.place("Rib", upper)
    upper.fasten("Weld", (rib, TOP), (shell, SIDE))
    base, arm = kit.place("Base", fixed=True), kit.root.add(upper)
    kit.root.revolute("Shoulder", (arm / shell, TOP), (base, SIDE))
    assert [link.name for link in robot_of(kit.document).links] == ["base", "upper_arm"]
    screw = kit.root.add(kit.studio.part("Screw", solids.box(0.004, 0.004, 0.01), density=7800))
    kit.root.fasten("Screwed", (screw, TOP), (arm / rib, SIDE))
    assert [link.name for link in robot_of(kit.document).links] == ["base", "upper_arm"]


def test_connectors_become_frames_and_link_connectors_names(kit: Kit) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE))
    kit.root.connector("Tool point", arm, SIDE)
    kit.root.connector("link_forearm", arm, TOP)
    robot = robot_of(kit.document)
    assert [link.name for link in robot.links] == ["base", "forearm"]
    (tool,) = robot.frames
    assert (tool.name, tool.link) == ("tool_point", "forearm")
    world = link_poses(robot, saved_configuration(robot))["forearm"] @ tool.link_from_frame
    assert np.abs(world - kit.document.truth.poses()[arm.path] @ SIDE).max() < 1e-12


@pytest.mark.parametrize(("reverse", "multiplier"), [(False, -1.5), (True, 1.5)])
def test_a_gear_turns_its_second_mate_against_its_first_unless_reversed(
    kit: Kit, reverse: bool, multiplier: float
) -> None:
    base, one, two = kit.place("Base", fixed=True), kit.place("One"), kit.place("Two")
    first = kit.root.revolute("First", (one, TOP), (base, SIDE), value=0.2)
    second = kit.root.revolute("Second", (base, TOP), (two, SIDE), value=0.2 * multiplier)
    kit.root.gear("Gear", first, second, 1.5, reverse=reverse)
    robot = robot_of(kit.document)
    (relation,) = robot.relations
    assert (relation.driver, relation.follower) == ("first", "second")
    assert (relation.multiplier, relation.offset) == (multiplier, 0.0)
    assert codes(robot) == ["W-LIMIT"]


def test_a_sign_is_as_drawn_where_the_saved_pose_fits_the_opposite_one(kit: Kit) -> None:
    base, one, two = kit.place("Base", fixed=True), kit.place("One"), kit.place("Two")
    first = kit.root.revolute("First", (one, TOP), (base, SIDE), value=0.2, limits=(-1, 1))
    second = kit.root.revolute("Second", (two, TOP), (base, TOP), value=0.3, limits=(-2, 2))
    kit.root.gear("Gear", first, second, 1.5)
    robot = robot_of(kit.document)
    assert robot.relations[0].multiplier == -1.5
    assert robot.relations[0].offset == pytest.approx(0.6)
    assert codes(robot) == ["W-RELATION-SIGN"]
    (told,) = robot.diagnostics
    assert "relations: {gear: {invert: true}}" in told.hint
    inverted = robot_of(kit.document, plan_of(relations={"gear": {"invert": True}}))
    assert (inverted.relations[0].multiplier, inverted.relations[0].offset) == (1.5, 0.0)
    assert codes(inverted) == []


@pytest.mark.parametrize("degrees", [0, 90, 180])
def test_two_gears_drawn_opposite_turn_against_each_other_wherever_they_are_saved(
    kit: Kit, degrees: float, tmp_path: Path
) -> None:
    base, one, two = kit.place("Base", fixed=True), kit.place("One"), kit.place("Two")
    at = math.radians(degrees)
    first = kit.root.revolute("First", (one, TOP), (base, SIDE), value=at, limits=(-7, 7))
    second = kit.root.revolute("Second", (two, TOP), (base, TOP), value=at, limits=(-7, 7))
    kit.root.gear("Gear", first, second, 1.0, offset=2 * at)
    robot = robot_of(kit.document)
    (relation,) = robot.relations
    assert relation.multiplier == -1.0
    assert abs(relation.offset) == pytest.approx(math.remainder(2 * at, math.tau) % math.tau)
    files = write(robot, tmp_path).files
    assert b'multiplier="-1"' in files["robot.urdf"]
    assert b"-1 0 0 0" in files["robot.xml"]
    assert not any(check.fails for check in checked(tmp_path, robot, plan_of()))


@pytest.mark.parametrize("kind", ["GEAR", "LINEAR", "RACK_AND_PINION", "SCREW"])
@pytest.mark.parametrize("reverse", [False, True])
def test_the_sign_of_all_four_is_as_drawn_and_a_pose_off_it_is_an_offset(
    kit: Kit, kind: str, reverse: bool, tmp_path: Path
) -> None:
    """Saved where the opposite direction fits exactly."""
    base, one = kit.place("Base", fixed=True), kit.place("One")
    k = {"GEAR": 1.5, "LINEAR": 1.5}.get(kind, 0.05 / math.tau)
    at = 0.02 if kind == "LINEAR" else 0.4
    saved = (-k if reverse else k) * at
    slides, root = kind != "GEAR", kit.root
    if kind == "SCREW":
        ends = (root.cylindrical("C", (one, TOP), (base, SIDE), (saved, at), ((-1, 1), (-9, 9))),)
    else:
        begin = root.slider if kind == "LINEAR" else root.revolute
        end = root.slider if slides else root.revolute
        ends = (
            begin("First", (one, TOP), (base, SIDE), value=at, limits=(-9, 9)),
            end("Second", (kit.place("Two"), TOP), (base, TOP), value=saved, limits=(-9, 9)),
        )
    make = {"GEAR": root.gear, "LINEAR": root.linear, "RACK_AND_PINION": root.rack, "SCREW": root.screw}
    amount = 1.5 if kind in ("GEAR", "LINEAR") else 0.05
    make[kind]("Tie", *ends, amount, reverse=reverse, offset=2 * saved)
    robot = robot_of(kit.document)
    (relation,) = robot.relations
    assert relation.multiplier == pytest.approx(k if reverse else -k)
    assert relation.offset == pytest.approx(2 * saved)
    assert codes(robot) == ["W-RELATION-SIGN"]
    write(robot, tmp_path)
    assert not any(check.fails for check in checked(tmp_path, robot, plan_of()))
    line = next(one for one in robot.diagnostics[0].hint.split(", ") if "invert" in one)
    told = yaml.safe_load(line.split("; ")[0].removeprefix("if it moves in the opposite direction, "))
    settled = robot_of(kit.document, plan_of(**told))
    assert settled.relations[0].multiplier == pytest.approx(-k if reverse else k)
    assert settled.relations[0].offset == 0.0
    assert codes(settled) == []


def test_an_offset_of_a_gear_is_kept_and_reported(kit: Kit) -> None:
    base, one, two = kit.place("Base", fixed=True), kit.place("One"), kit.place("Two")
    first = kit.root.revolute("First", (one, TOP), (base, SIDE), value=0.2, limits=(-1, 1))
    second = kit.root.revolute("Second", (two, TOP), (base, TOP), value=0.5, limits=(-2, 2))
    kit.root.gear("Gear", first, second, 1.0)
    robot = robot_of(kit.document)
    assert robot.relations[0].offset == pytest.approx(0.7, abs=1e-12)
    assert codes(robot) == ["W-RELATION-OFFSET"]


def test_a_follower_is_saved_at_the_turn_that_its_driver_gives(kit: Kit, tmp_path: Path) -> None:
    """−2 · 2.5 rad is more than half a turn: the pose alone would say 1.28."""
    base, one, two = kit.place("Base", fixed=True), kit.place("One"), kit.place("Two")
    first = kit.root.revolute("First", (one, TOP), (base, SIDE), value=2.5, limits=(-3, 3))
    second = kit.root.revolute("Second", (two, TOP), (base, TOP), value=-5.0, limits=(-7, 7))
    kit.root.gear("Gear", first, second, 2.0)
    robot = robot_of(kit.document)
    assert {dof.name: round(dof.saved, 9) for dof in robot.dofs} == {"first": 2.5, "second": -5.0}
    assert not codes(robot)
    write(robot, tmp_path)
    assert not any(check.fails for check in checked(tmp_path, robot, plan_of()))


def test_a_joint_that_two_gears_would_drive_drives_the_second(kit: Kit) -> None:
    base = kit.place("Base", fixed=True)
    wheels = [kit.place(name) for name in ("One", "Two", "Three")]
    values = (0.4, -0.2, 0.1)
    mates = [
        kit.root.revolute(f"Turn {n}", (wheel, TOP), (base, turn((1, 0, 0), n)), value=value)
        for n, (wheel, value) in enumerate(zip(wheels, values, strict=True))
    ]
    kit.root.gear("A", mates[0], mates[1], 0.5)
    kit.root.gear("B", mates[2], mates[1], 2)
    found = {r.follower: (r.driver, r.multiplier) for r in robot_of(kit.document).relations}
    assert found == {"turn_1": ("turn_0", -0.5), "turn_2": ("turn_0", 0.25)}


def test_a_chain_of_gears_is_flattened_to_its_driver(kit: Kit) -> None:
    base = kit.place("Base", fixed=True)
    wheels = [kit.place(name) for name in ("One", "Two", "Three")]
    mates = [
        kit.root.revolute(f"Turn {n}", (wheel, TOP), (base, turn((1, 0, 0), n)), value=0.1 * (-2) ** n)
        for n, wheel in enumerate(wheels)
    ]
    kit.root.gear("A", mates[0], mates[1], 2)
    kit.root.gear("B", mates[1], mates[2], 2)
    found = {r.follower: (r.driver, r.multiplier) for r in robot_of(kit.document).relations}
    assert found == {"turn_1": ("turn_0", -2.0), "turn_2": ("turn_0", 4.0)}


def test_gears_in_a_circle_are_refused_by_name(kit: Kit) -> None:
    base, one, two = kit.place("Base", fixed=True), kit.place("One"), kit.place("Two")
    first = kit.root.revolute("First", (one, TOP), (base, SIDE))
    second = kit.root.revolute("Second", (two, TOP), (base, TOP))
    kit.root.gear("There", first, second)
    kit.root.gear("Back", second, first)
    with pytest.raises(AssemblyError, match=r"related already|in a circle"):
        robot_of(kit.document)


def test_a_loop_is_kept_as_a_loop_and_the_driven_mate_stays_in_the_tree(kit: Kit) -> None:
    four_bar(kit)
    robot = robot_of(kit.document)
    (loop,) = robot.loops
    assert {joint.name for joint in robot.joints} | {loop.name} == {"drive", "pin", "swing", "close"}
    assert loop.name != "drive"
    assert loop.residual < 1e-12
    assert 0.04 < loop.lever < 0.06


def test_limits_of_the_closing_mate_are_reported_as_not_enforced(kit: Kit) -> None:
    four_bar(kit, limits=True)
    assert "W-LOOP-LIMIT" in codes(robot_of(kit.document))


@pytest.mark.parametrize("select", ["arm", "Arm <1>", "Arm*", "a?m"])
def test_the_root_can_be_chosen_by_name(kit: Kit, select: str) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), value=0.3, limits=(0, 1))
    robot = robot_of(kit.document, plan_of(root={"select": select, "base": "free"}))
    assert robot.root.name == "arm"
    assert not robot.base.fixed
    assert robot.dofs[0].limits == Limits(0.0, 1.0)


def test_a_root_that_does_not_exist_lists_the_links(kit: Kit) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE))
    with pytest.raises(NoRoot, match="arm, base"):
        robot_of(kit.document, plan_of(root={"select": "hip*"}))


def test_floating_a_robot_that_cad_fixes_is_reported(kit: Kit) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), limits=(0, 1))
    assert codes(robot_of(kit.document, plan_of(root={"select": "arm"}))) == ["W-BASE"]


def test_fastening_to_the_origin_fixes_the_base(kit: Kit) -> None:
    base, arm = kit.place("Base"), kit.root.add(kit.bar("Arm", density=9000))
    kit.root.fasten("Anchor", (base, TOP), (ORIGIN, np.eye(4)))
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE))
    robot = robot_of(kit.document)
    assert robot.root.name == "base"
    assert robot.base.fixed
    assert "Anchor" in robot.base.reason


def test_joint_properties_by_glob_later_entries_win_field_by_field(kit: Kit) -> None:
    base, one, two = kit.place("Base", fixed=True), kit.place("One"), kit.place("Two")
    kit.root.revolute("Left hip", (one, TOP), (base, SIDE))
    kit.root.revolute("Right hip", (two, TOP), (base, TOP))
    plan = plan_of(
        joints={
            "*": {"damping": 0.1, "effort": 5},
            "left*": {"effort": 7, "limits": [-1, None]},
        }
    )
    left, right = robot_of(kit.document, plan).dofs
    assert (left.dynamics.damping, left.dynamics.effort, left.limits) == (0.1, 7, Limits(-1, None))
    assert (right.dynamics.damping, right.dynamics.effort, right.limits) == (0.1, 5, Limits())


def test_a_joint_glob_without_a_match_lists_the_joints(kit: Kit) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE))
    with pytest.raises(AssemblyError, match="elbow"):
        robot_of(kit.document, plan_of(joints={"knee*": {"damping": 1}}))


def test_loose_parts_are_listed_together(kit: Kit) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE))
    kit.place("Lost")
    kit.place("Also lost")
    with pytest.raises(Disconnected) as caught:
        robot_of(kit.document)
    assert [problem.where for problem in caught.value.problems] == ["Also lost <1>", "Lost <1>"]


def test_parts_without_material_are_all_named_at_once(kit: Kit) -> None:
    base = kit.place("Base", fixed=True)
    for name in ("Foam", "Sticker"):
        part = kit.root.add(kit.studio.part(name, solids.box(0.01, 0.01, 0.01)))
        kit.root.fasten(f"Stick {name}", (part, TOP), (base, SIDE))
    with pytest.raises(AssemblyError) as caught:
        robot_of(kit.document)
    assert [(p.code, p.where) for p in caught.value.problems] == [
        ("E-MASS", "Foam <1>"),
        ("E-MASS", "Sticker <1>"),
    ]


def test_suppressed_things_are_as_absent(kit: Kit) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), limits=(0, 1))
    kit.place("Ghost", suppressed=True)
    kit.root.fasten("Off", (arm, TOP), (base, TOP), suppressed=True)
    robot = robot_of(kit.document)
    assert [link.name for link in robot.links] == ["base", "arm"]
    assert not codes(robot)


def test_a_moving_mate_between_rigid_parts_is_reported(kit: Kit) -> None:
    base, plate = kit.place("Base", fixed=True), kit.place("Plate")
    kit.root.fasten("Bolt", (plate, TOP), (base, TOP))
    kit.root.revolute("Stuck", (plate, SIDE), (base, SIDE), closing=True)
    robot = robot_of(kit.document)
    assert codes(robot) == ["W-MATE-RIGID"]
    assert not robot.joints


def test_an_assembly_without_mates_is_refused(kit: Kit) -> None:
    kit.place("One")
    kit.place("Two")
    with pytest.raises(AssemblyError, match="no mates"):
        robot_of(kit.document)


def test_a_single_part_is_a_robot_of_one_link(kit: Kit) -> None:
    kit.place("Brick")
    robot = robot_of(kit.document)
    assert [link.name for link in robot.links] == ["brick"]
    assert not robot.base.fixed


def test_order_of_instances_and_features_changes_nothing(kit: Kit) -> None:
    four_bar(kit)
    from linkwright.stages.robot.codec import encode_robot

    plain = encode_robot(robot_of(kit.document))
    for seed in range(5):
        assert encode_robot(robot_of(kit.document, shuffle=seed)) == plain


def test_limits_that_are_equal_lock_the_joint_with_a_little_play(kit: Kit, tmp_path: Path) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), value=0.5, limits=(0.5, 0.5))
    robot = robot_of(kit.document)
    assert codes(robot) == ["W-LIMIT-LOCKED"]
    write(robot, tmp_path)
    assert not any(check.fails for check in checked(tmp_path, robot, plan_of()))


def test_limits_upside_down_are_refused_by_name(kit: Kit) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), limits=(1, -1))
    with pytest.raises(AssemblyError, match="E-LIMIT elbow"):
        robot_of(kit.document)


def test_a_part_may_be_fastened_to_its_own_sub_assemblys_origin(kit: Kit) -> None:
    """So the sub-assembly's frame is that part's, though its parts move against each other."""
    motor = kit.document.assembly("Motor")
    case, horn = kit.place("Case", motor), kit.place("Horn", motor)
    motor.ground(case)
    motor.fasten("Ground", (case, np.eye(4)), (ORIGIN, np.eye(4)), closing=True)
    motor.revolute("Spin", (horn, TOP), (case, SIDE), value=0.3, limits=(-1, 1))
    base, servo = kit.place("Base", fixed=True), kit.root.add(motor)
    kit.root.revolute("Joint", (servo, TOP), (base, SIDE), value=0.4, limits=(-1, 1))
    robot = robot_of(kit.document)
    assert [(joint.name, joint.parent, joint.child) for joint in robot.joints] == [
        ("joint", "base", "case"),
        ("spin", "case", "horn"),
    ]
    assert not codes(robot)


def test_a_mate_to_a_sub_assembly_that_moves_inside_is_refused_by_name(kit: Kit) -> None:
    motor = kit.document.assembly("Motor")
    case, horn = kit.place("Case", motor), kit.place("Horn", motor)
    motor.revolute("Spin", (horn, TOP), (case, SIDE))
    base, servo = kit.place("Base", fixed=True), kit.root.add(motor)
    kit.root.revolute("Joint", (servo, TOP), (base, SIDE))
    with pytest.raises(AssemblyError, match="E-MATE-SUBASSEMBLY Joint"):
        robot_of(kit.document)


def test_connectors_on_a_rigid_sub_assembly_are_kept(kit: Kit) -> None:
    upper = kit.document.assembly("Upper arm")
    shell, rib = kit.place("Shell", upper), kit.place("Rib", upper)
    upper.fasten("Weld", (rib, TOP), (shell, SIDE))
    base, arm = kit.place("Base", fixed=True), kit.root.add(upper)
    kit.root.revolute("Shoulder", (arm / shell, TOP), (base, SIDE), limits=(0, 1))
    kit.root.connector("link_boom", arm, TOP)
    kit.root.connector("Tool", arm, SIDE)
    robot = robot_of(kit.document)
    assert [link.name for link in robot.links] == ["base", "boom"]
    assert [(frame.name, frame.link) for frame in robot.frames] == [("tool", "boom")]
    assert not codes(robot)


def test_adding_an_instance_renames_none_of_those_that_were_there(kit: Kit) -> None:
    finger = kit.document.assembly("Finger")
    tip = kit.place("Tip", finger)
    finger.connector("link_fingertip", tip, TOP)
    base = kit.place("Base", fixed=True)
    names: dict[tuple[str, ...], str] = {}
    for count in range(1, 12):
        one = kit.root.add(finger)
        kit.root.revolute(f"Bend {count}", (one / tip, TOP), (base, turn((1, 0, 0), count)))
        links = robot_of(kit.document).links
        found = {link.parts[0].path: link.name for link in links if link.name != "base"}
        if count > 2:
            assert {path: found[path] for path in names} == names
        names = found
    assert names[one.path + tip.path] == "finger_11_fingertip"


def test_names_without_a_legal_letter_are_reported(kit: Kit) -> None:
    base = kit.place("Base", fixed=True)
    arm = kit.root.add(kit.bar("机械臂"))
    kit.root.revolute("关节", (arm, TOP), (base, SIDE), limits=(0, 1))
    robot = robot_of(kit.document)
    assert [link.name for link in robot.links] == ["base", "unnamed"]
    assert codes(robot) == ["W-NAME", "W-NAME"]


def test_an_inertia_that_no_solid_can_have_names_the_part(kit: Kit) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE))
    bundle = edited(bundle_of(kit.document), {"inertia": [1e-3, 0, 0, 0, 1e-6, 0, 0, 0, 1e-6]})
    with pytest.raises(AssemblyError, match="E-INERTIA Arm <1>"):
        build_robot(bundle, plan_of())


@pytest.mark.parametrize("change", [{"inertia": [1, 2]}, {"mass": {"a": 1}}, {"centroid": "far"}])
def test_a_mass_reply_in_another_shape_is_one_error(kit: Kit, change: dict) -> None:
    kit.place("Brick")
    with pytest.raises(ProtocolError, match="unknown format"):
        build_robot(edited(bundle_of(kit.document), change), plan_of())


@pytest.mark.parametrize(
    ("at", "value"),
    [
        (("rootAssembly", "features", 0, "featureData"), None),
        (("rootAssembly", "features", 0, "featureData", "matedEntities", 0), {}),
        (("rootAssembly", "features", 0, "featureData", "mateLimits"), "none"),
        (("rootAssembly", "occurrences", 0, "transform"), [1.0] * 12),
        (("rootAssembly", "instances"), 7),
    ],
)
def test_a_definition_in_another_shape_is_one_error(kit: Kit, at: tuple, value: object) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE))
    bundle = bundle_of(kit.document)
    definition = json.loads(bundle.body(bundle.definition))
    branch = definition
    for step in at[:-1]:
        branch = branch[step]
    branch[at[-1]] = value
    broken = replace(bundle, blobs={**bundle.blobs, bundle.definition: json.dumps(definition).encode()})
    with pytest.raises(ProtocolError, match="unknown format"):
        build_robot(broken, plan_of())


def edited(bundle: Bundle, change: dict) -> Bundle:
    """The bundle with every part's mass properties changed."""
    blobs = dict(bundle.blobs)
    for studio in bundle.studios:
        for digest in studio.mass:
            reply = json.loads(blobs[digest])
            for body in reply["bodies"].values():
                body.update(change)
            blobs[digest] = json.dumps(reply).encode()
    return replace(bundle, blobs=blobs)


def test_problems_of_parts_joints_and_names_are_reported_together(kit: Kit) -> None:
    base, arm = kit.place("Base", fixed=True), kit.root.add(kit.bar("Arm", density=None))
    kit.root.revolute("Hinge", (arm, TOP), (base, SIDE), limits=(1.0, -1.0))
    plan = plan_of(
        joints={"knee": {"damping": 1}},
        names={"links": {"Leg": "leg"}},
        loops={"cut": ["Knee"]},
        frames={"include": ["tip*"]},
    )
    with pytest.raises(AssemblyError) as caught:
        robot_of(kit.document, plan)
    told = [(one.code, one.where) for one in caught.value.problems]
    assert told == [
        ("E-GLOB", "frames.include"),
        ("E-GLOB", "joints"),
        ("E-GLOB", "loops.cut"),
        ("E-LIMIT", "hinge"),
        ("E-MASS", "Arm <1>"),
        ("E-RENAME", "names.links"),
    ]


def test_what_leaves_no_tree_is_reported_with_all_that_is_known_by_then(kit: Kit) -> None:
    kit.place("Base", fixed=True)
    crate, lid = kit.root.add(kit.bar("Crate", density=None)), kit.place("Lid")
    kit.root.fasten("Shut", (lid, TOP), (crate, TOP))
    with pytest.raises(Disconnected) as caught:
        robot_of(kit.document, plan_of(names={"links": {"Leg": "leg"}}))
    assert [one.code for one in caught.value.problems] == ["E-MASS", "E-RENAME", "E-LOOSE"]
    with pytest.raises(NoRoot) as none:
        robot_of(kit.document, plan_of(root={"select": "leg"}))
    assert [one.code for one in none.value.problems] == ["E-MASS"]
    assert "name one of: base, " in none.value.message
