"""`conventions: onshape_to_robot`: documents made for that tool build as it builds them.

What the tool itself made of such a document lies in `peer_output`; it is read here by two engines.
"""

from pathlib import Path

import numpy as np
import pytest

from linkwright.stages.graph.onshape.definition import read_assembly
from linkwright.stages.graph.onshape.onshape_to_robot import translate_names
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Limits
from linkwright.stages.robot.motion.kinematics import link_poses
from tests.fake_onshape.document import ORIGIN
from tests.fake_onshape.frames import frame
from tests.fake_onshape.prefixed import LIKE_THEIRS, prefixed
from tests.support.building import bundle_of, plan_of, robot_of
from tests.support.kit import SIDE, TOP, Kit
from tests.support.peer_robots import differences, limits_of, of_mjcf, of_urdf, ours
from tests.support.reported import codes as all_codes

THEIRS = Path(__file__).parent / "peer_output"
HERE = np.eye(4)


def built(document):
    return robot_of(document, plan_of(conventions="onshape_to_robot"))


@pytest.fixture(scope="module")
def robot():
    return built(prefixed())


@pytest.mark.parametrize(("file", "read"), [("robot.urdf", of_urdf), ("robot.xml", of_mjcf)])
def test_masses_axes_and_frames_are_those_that_the_tool_writes(robot, file, read):
    theirs = (THEIRS / file).read_text()
    rng = np.random.default_rng(7)
    for share in (0.0, 1.0, 1.0):
        q = {dof.name: share * float(rng.uniform(-1, 1)) for dof in robot.dofs}
        seen = ours(robot, q)
        seen.links = {LIKE_THEIRS.get(name, name): link for name, link in seen.links.items()}
        off = differences(seen, read(theirs, q))
        assert len(off) > 40
        assert {quantity: number for quantity, number in off.items() if number > 1e-5} == {}


@pytest.mark.parametrize("file", ["robot.urdf", "robot.xml"])
def test_limits_are_those_that_the_tool_writes(robot, file):
    theirs = limits_of((THEIRS / file).read_text())
    if file.endswith("urdf"):  # which has to have some, and says half a turn for none
        assert theirs.pop("rod") == pytest.approx((-np.pi, np.pi))
        theirs["rod"] = None
    for dof in robot.dofs:
        own = None if dof.limits == Limits() else (dof.limits.lower, dof.limits.upper)
        assert own == (theirs.pop(dof.name) and pytest.approx(own, abs=1e-9))
    assert theirs == {}


def test_base_loops_and_gears_are_those_of_the_tool(robot):
    assert (robot.base.fixed, robot.root.name) == (True, "base")
    assert [(loop.name, loop.type) for loop in robot.loops] == [("closing_rod", "revolute")]
    (gear,) = robot.relations
    rule = (gear.follower, gear.driver, gear.multiplier, gear.offset)
    assert rule == ("continuous_right", "left_wheel", -1.5, 0.0)
    assert all(dof.saved == 0.0 for dof in robot.dofs)


def read(kit, **keys):
    """What a document is in our own terms."""
    log, bundle = Diagnostics(), bundle_of(kit.document)
    assembly = read_assembly(bundle.body(bundle.definition))
    assembly, sections = translate_names(assembly, GraphSections.model_validate(keys), log)
    return assembly, sections, log


def codes(log):
    assert "I-PEER" in all_codes(log)
    return [code for code in all_codes(log) if code != "I-PEER"]


def names(assembly):
    return sorted((mate.ref.name, mate.ref.type) for mate in assembly.mates)


def connectors(assembly):
    return {connector.name for connector in assembly.connectors}


def armed(kit, name="dof_a", kind="revolute", fixed="", **more):
    """A base, and an arm on it by a mate of this name."""
    base, arm = (kit.place(part, fixed=part == fixed) for part in ("Base", "Arm"))
    getattr(kit.root, kind)(name, (arm, HERE), (base, TOP), **more)
    return base, arm


def test_a_prefix_makes_a_joint_of_a_mate_of_any_type(kit):
    base, arm_a, arm_b, three, four = (kit.place(name) for name in ("Base", "A", "B", "C", "D"))
    kit.root.revolute("dof_hip_roll", (arm_a, HERE), (base, TOP))
    kit.root.fasten("dof_mount", (arm_b, HERE), (base, TOP))
    kit.root.planar("dof_table", (three, HERE), (base, TOP))
    kit.root.fasten("Fastened 1", (four, HERE), (base, TOP))
    assembly, _, log = read(kit)
    assert names(assembly) == [
        ("Fastened 1", "FASTENED"), ("hip_roll", "REVOLUTE"), ("mount", "FIXED"), ("table", "PLANAR"),
    ]  # fmt: skip
    assert codes(log) == []


SPREAD = {"XMin": -1, "XMax": 2, "YMax": 3, "AxialZMin": -6, "AxialZMax": 5}


@pytest.mark.parametrize(
    ("name", "kind", "more", "expected", "limits"),
    [
        ("fix_it", "slider", {"value": 0.1}, ("fix_it", "FASTENED"), {}),
        ("dof_left_wheel", "revolute", {"limits": (-1, 1)}, ("left_wheel", "REVOLUTE"), {}),
        ("dof_continuous_turn", "revolute", {"limits": (-1, 1)}, ("continuous_turn", "REVOLUTE"), {}),
        ("dof_wheel_inv", "revolute", {"limits": (-1, 1)}, ("wheel", "REVOLUTE"), {}),
        ("dof_t_inv", "planar", {"limits": ((-1, 2), (-3, None), (-5, 6))}, ("t", "PLANAR"), SPREAD),
    ],
)
def test_welds_wheels_and_inverted_limits(kit, name, kind, more, expected, limits):
    """Inverted limits change sides and sign, but those along x do not; a wheel has none."""
    armed(kit, name, kind, **more)
    (mate,) = read(kit)[0].mates
    assert (mate.ref.name, mate.ref.type) == expected
    assert (mate.limits or {}) == {f"limit{end}": value for end, value in limits.items()}


def test_a_cylindrical_joint_only_turns_which_is_reported(kit):
    armed(kit, kind="cylindrical", value=(0.2, 0.3), limits=((-1, 1), (-2, 2)))
    assembly, _, log = read(kit)
    (mate,) = assembly.mates
    first, second = (assembly.world_from(entity) for entity in mate.entities)
    assert (mate.ref.type, mate.limits) == ("REVOLUTE", {"limitAxialZMin": -2, "limitAxialZMax": 2})
    assert np.allclose(first[:3, 3], second[:3, 3])
    assert codes(log) == ["W-PEER-SLIDE"]


def test_mates_that_the_tool_passes_over_are_reported(kit):
    base, arm = armed(kit)
    kit.root.revolute("Hinge", (arm, HERE), (base, TOP), redundant=True)
    kit.root.fasten("Fastened", (base, HERE), (ORIGIN, HERE))
    assembly, _, log = read(kit)
    assert names(assembly) == [("a", "REVOLUTE")]
    assert codes(log) == ["W-PEER-MATE", "W-PEER-MATE"]


def test_a_mate_that_closes_a_loop_is_cut(kit):
    base, arm = armed(kit)
    kit.root.fasten("closing_[x]", (arm, HERE), (base, TOP), closing=True)
    assembly, keys, _ = read(kit, loops={"cut": ["mine"]})
    assert names(assembly) == [("a", "REVOLUTE"), ("closing_[x]", "FIXED")]
    assert keys.loops.cut == ("mine", "closing_[[]x]")


def test_a_marker_is_a_frame_and_no_part_whichever_side_it_is(kit):
    _, arm = armed(kit)
    pin = kit.place("Pin")
    kit.root.fasten("frame_tip", (arm, TOP), (pin, SIDE))
    assembly, _, log = read(kit)
    assert len(assembly.parts) == 2
    (marker,) = (connector for connector in assembly.connectors if connector.name == "tip")
    assert marker.entity.path == arm.path
    assert np.allclose(assembly.world_from(marker.entity), kit.document.truth.poses()[pin.path])
    assert codes(log) == ["I-PEER-MARKER"]


def test_joints_without_a_name_and_markers_in_a_link_are_refused(kit):
    base, arm = armed(kit, "dof_inv")
    assert codes(read(kit)[2]) == ["E-PEER-NAME"]
    kit.root.fasten("frame_tip", (arm, HERE), (base, TOP), closing=True)
    assert codes(read(kit)[2]) == ["E-PEER-FRAME", "E-PEER-NAME"]


def test_connectors_count_by_their_prefix(kit):
    _, arm = armed(kit)
    for name in ("frame_eye", "link_upper", "Mate connector 1"):
        kit.root.connector(name, arm, SIDE)
    assert connectors(read(kit)[0]) == {"eye", "link_upper", "link_base"}


def test_links_are_named_after_instances_along_joints(kit):
    base = kit.place("Base")
    source = kit.bar("Leg")
    first, second, three = (kit.root.add(source, name=f"Leg <{number}>") for number in (1, 2, 3))
    cap = kit.place("Cap")
    kit.root.revolute("dof_a", (second, HERE), (base, TOP))
    kit.root.revolute("dof_b", (first, HERE), (second, TOP))
    kit.root.revolute("dof_cap", (three, HERE), (base, SIDE))
    kit.root.fasten("Glue", (cap, HERE), (three, TOP))
    assembly, keys, _ = read(kit)
    called = {connector.entity.path: connector.name for connector in assembly.connectors}
    assert called == {
        base.path: "link_base", second.path: "link_leg", first.path: "link_leg_2", three.path: "link_leg_3",
    }  # fmt: skip
    assert (keys.root.select, keys.zero, keys.depth.max) == ("base", "saved", 0)


def test_a_joint_keeps_its_name_where_a_link_has_the_same(kit):
    armed(kit, "dof_arm")
    assert connectors(read(kit)[0]) == {"link_base", "link_arm_link"}


def test_the_first_instance_is_the_root(kit):
    kit.place("Ghost", suppressed=True)
    _, arm = armed(kit, fixed="Arm")
    assembly, keys, log = read(kit)
    assert keys.root.select == "base"
    assert not any(occurrence.fixed for occurrence in assembly.occurrences.values())
    assert codes(log) == ["W-PEER-FIXED"]
    assembly, keys, _ = read(kit, root={"select": "arm"}, depth={"max": 1})
    assert (keys.root.select, keys.depth.max) == ("arm", 1)
    assert assembly.occurrences[arm.path].fixed


def geared(kit, names, reverse):
    base, part_a, part_b = (kit.place(name, fixed=name == "Base") for name in ("Base", "One", "Two"))
    first = kit.root.revolute(names[0], (part_a, HERE), (base, TOP))
    second = kit.root.revolute(names[1], (base, frame((0.3, 0, 0))), (part_b, SIDE))
    kit.root.gear("Gear 1", first, second, ratio=3.0, reverse=reverse)


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize(
    "names", [("dof_a", "dof_b_inv"), ("dof_a_inverted", "dof_b"), ("dof_a_inv", "dof_b_inv")]
)
def test_a_gear_moves_inverted_joints_as_it_does_in_cad(names, reverse):
    """The tool writes them wrong, or about no joint. At zero no pose tells the sign."""
    kit, plain = Kit(), Kit()
    geared(kit, names, reverse)
    geared(plain, ("dof_a", "dof_b"), reverse)

    def displacements(robot, amount):
        (relation,) = robot.relations
        assert (relation.driver, relation.follower, relation.offset) == ("a", "b", 0.0)
        moved = link_poses(robot, {"a": amount, "b": relation.multiplier * amount})
        world, start = robot.world_from_root, link_poses(robot)
        return [world @ moved[link.name] @ np.linalg.inv(world @ start[link.name]) for link in robot.links]

    sign = -1.0 if "inv" in names[0] else 1.0
    moved, expected = (
        displacements(built(kit.document), 0.7 * sign),
        displacements(built(plain.document), 0.7),
    )
    assert np.allclose(moved, expected, atol=1e-12)


def test_a_loop_that_nobody_declared_is_a_loop(kit):
    """The tool builds its last link twice."""
    base, part_a, part_b = (kit.place(name, fixed=name == "Base") for name in ("Base", "One", "Two"))
    kit.root.revolute("dof_a", (part_a, HERE), (base, HERE), value=0.3)
    kit.root.revolute("dof_b", (part_b, HERE), (base, frame((0.2, 0, 0))), value=0.5)
    poses = kit.document.truth.poses()
    at = [np.linalg.inv(poses[path.path]) @ frame((0.1, 0.1, 0)) for path in (part_a, part_b)]
    kit.root.revolute("dof_c", (part_a, at[0]), (part_b, at[1]), closing=True)
    robot = built(kit.document)
    assert sorted(link.name for link in robot.links) == ["base", "one", "two"]
    assert len(robot.loops) == 1


def test_two_joints_between_two_links_are_one(kit):
    """The tool builds the second link twice, and its joint by the same name."""
    base, arm = armed(kit, fixed="Base", value=0.3)
    kit.root.revolute("dof_b", (arm, HERE), (base, TOP), value=0.3, redundant=True)
    robot = built(kit.document)
    assert [joint.name for joint in robot.joints] == ["a"]
    assert "I-COMPOSED" in all_codes(robot)


def test_limits_of_the_list_of_features_are_inverted_too(kit):
    armed(kit, "dof_a_inv", fixed="Base", value=0.5, limits=(-1.0, 2.0))
    (dof,) = robot_of(kit.document, plan_of(conventions="onshape_to_robot"), newest=16).dofs
    assert (dof.limits.lower, dof.limits.upper) == (pytest.approx(-1.5), pytest.approx(1.5))
