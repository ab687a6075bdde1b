"""What the graph stage makes of small assemblies that a designer might draw."""

import numpy as np
import pytest

from stages.robot.errors import AssemblyError, Disconnected, NoRoot
from stages.robot.kinematics import link_poses, saved_configuration
from stages.robot.model import Limits, Robot
from tests.building import plan_of, robot_of
from tests.kit import SIDE, TOP, Kit, four_bar
from tests.onshape import solids
from tests.onshape.document import ORIGIN
from tests.onshape.frames import turn


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
    (joint,) = robot.joints
    assert (joint.parent, joint.child) == ("base", "arm")
    assert joint.saved == pytest.approx(0.4, abs=1e-12)
    assert joint.limits == Limits(-0.5, 1.5)
    assert joint.axis[2] == (1 if first_is_child else -1)
    pose = link_poses(robot, {"elbow": 1.0})["arm"] @ robot.link("arm").parts[0].link_from_part
    assert np.abs(pose - kit.document.truth.poses({"Elbow": 1.0})[arm.path]).max() < 1e-12


def test_sliders_take_their_limits_in_metres_and_may_be_open_on_one_side(kit: Kit) -> None:
    base, cart = kit.place("Base", fixed=True), kit.place("Cart")
    kit.root.slider("Rail", (cart, TOP), (base, SIDE), value=0.2, limits=(None, 0.3))
    (joint,) = robot_of(kit.document).joints
    assert joint.type == "prismatic"
    assert joint.limits == Limits(None, 0.3)
    assert joint.saved == pytest.approx(0.2, abs=1e-12)


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
    assert {joint.name: round(joint.saved, 9) for joint in robot.joints} == {
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
    assert codes(robot) == ["W-LIMIT", "W-LIMIT"]


def test_the_saved_pose_is_believed_where_it_fits_the_opposite_sign(kit: Kit) -> None:
    base, one, two = kit.place("Base", fixed=True), kit.place("One"), kit.place("Two")
    first = kit.root.revolute("First", (one, TOP), (base, SIDE), value=0.2, limits=(-1, 1))
    second = kit.root.revolute("Second", (two, TOP), (base, TOP), value=0.3, limits=(-2, 2))
    kit.root.gear("Gear", first, second, 1.5)
    robot = robot_of(kit.document)
    assert robot.relations[0].multiplier == 1.5
    assert codes(robot) == ["I-RELATION-SIGN"]


def test_an_offset_of_a_gear_is_kept_and_told(kit: Kit) -> None:
    base, one, two = kit.place("Base", fixed=True), kit.place("One"), kit.place("Two")
    first = kit.root.revolute("First", (one, TOP), (base, SIDE), value=0.2, limits=(-1, 1))
    second = kit.root.revolute("Second", (two, TOP), (base, TOP), value=0.5, limits=(-2, 2))
    kit.root.gear("Gear", first, second, 1.0)
    robot = robot_of(kit.document)
    assert robot.relations[0].offset == pytest.approx(0.7, abs=1e-12)
    assert codes(robot) == ["W-RELATION-OFFSET"]


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
    with pytest.raises(AssemblyError, match="in a circle"):
        robot_of(kit.document)


def test_a_loop_is_kept_as_a_loop_and_the_driven_mate_stays_in_the_tree(kit: Kit) -> None:
    four_bar(kit)
    robot = robot_of(kit.document)
    (loop,) = robot.loops
    assert {joint.name for joint in robot.joints} | {loop.name} == {"drive", "pin", "swing", "close"}
    assert loop.name != "drive"
    assert loop.residual < 1e-12
    assert 0.04 < loop.lever < 0.06


def test_limits_of_the_closing_mate_are_told_as_not_enforced(kit: Kit) -> None:
    four_bar(kit, limits=True)
    assert "W-LOOP-LIMIT" in codes(robot_of(kit.document))


@pytest.mark.parametrize("select", ["arm", "Arm <1>", "Arm*", "a?m"])
def test_the_root_can_be_chosen_by_name(kit: Kit, select: str) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), value=0.3, limits=(0, 1))
    robot = robot_of(kit.document, plan_of(root={"select": select, "base": "free"}))
    assert robot.root.name == "arm"
    assert not robot.base.fixed
    assert robot.joints[0].limits == Limits(0.0, 1.0)


def test_a_root_that_does_not_exist_lists_the_links(kit: Kit) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE))
    with pytest.raises(NoRoot, match="arm, base"):
        robot_of(kit.document, plan_of(root={"select": "hip*"}))


def test_floating_a_robot_that_cad_fixes_is_told(kit: Kit) -> None:
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
    left, right = robot_of(kit.document, plan).joints
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


def test_a_moving_mate_between_rigid_parts_is_told(kit: Kit) -> None:
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
    from stages.robot.codec import encode_robot

    plain = encode_robot(robot_of(kit.document))
    for seed in range(5):
        assert encode_robot(robot_of(kit.document, shuffle=seed)) == plain
