"""`conventions: onshape_to_robot`: documents made for that tool build as it builds them.

What the tool itself made of such a document lies in `peer_output`; it is read here by two engines.
"""

from pathlib import Path

import numpy as np
import pytest

from linkwright.stages.graph import build_robot
from linkwright.stages.graph.onshape.assembly import Assembly
from linkwright.stages.graph.onshape.definition import read_assembly
from linkwright.stages.graph.onshape.onshape_to_robot import translated
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Limits, Robot
from linkwright.stages.robot.motion.kinematics import link_poses
from tests.fake_onshape.document import ORIGIN, Document
from tests.fake_onshape.frames import frame
from tests.fake_onshape.prefixed import LIKE_THEIRS, prefixed
from tests.fake_onshape.server import OnshapeServer
from tests.support.building import bundle_of, plan_of, robot_of
from tests.support.kept import fetched, onshape
from tests.support.kit import SIDE, TOP, Kit
from tests.support.peer_robots import differences, limits_of, of_mjcf, of_urdf, ours

THEIRS = Path(__file__).parent / "peer_output"
HERE = np.eye(4)


def built(document: Document) -> Robot:
    return robot_of(document, plan_of(conventions="onshape_to_robot"))


@pytest.fixture(scope="module")
def robot() -> Robot:
    return built(prefixed())


@pytest.mark.parametrize(("file", "read"), [("robot.urdf", of_urdf), ("robot.xml", of_mjcf)])
def test_masses_axes_and_frames_are_those_that_the_tool_writes(robot: Robot, file: str, read) -> None:
    theirs = (THEIRS / file).read_text()
    rng = np.random.default_rng(7)
    for share in (0.0, 1.0, 1.0):
        q = {dof.name: share * float(rng.uniform(-1, 1)) for dof in robot.dofs}
        seen = ours(robot, q)
        seen.links = {LIKE_THEIRS.get(name, name): link for name, link in seen.links.items()}
        off = differences(seen, read(theirs, q))
        assert len(off) > 40
        assert {what: number for what, number in off.items() if number > 1e-5} == {}


@pytest.mark.parametrize("file", ["robot.urdf", "robot.xml"])
def test_limits_are_those_that_the_tool_writes(robot: Robot, file: str) -> None:
    theirs = limits_of((THEIRS / file).read_text())
    if file.endswith("urdf"):  # which has to have some, and says half a turn for none
        assert theirs.pop("rod") == pytest.approx((-np.pi, np.pi))
        theirs["rod"] = None
    for dof in robot.dofs:
        own = None if dof.limits == Limits() else (dof.limits.lower, dof.limits.upper)
        assert own == (theirs.pop(dof.name) and pytest.approx(own, abs=1e-9))
    assert theirs == {}


def test_a_base_is_fixed_where_the_tool_fixes_it_and_loops_and_gears_are_kept(robot: Robot) -> None:
    assert robot.base.fixed
    assert robot.root.name == "base"
    assert [(loop.name, loop.type) for loop in robot.loops] == [("closing_rod", "revolute")]
    assert [(one.follower, one.driver, one.multiplier, one.offset) for one in robot.relations] == [
        ("continuous_right", "left_wheel", -1.5, 0.0)
    ]
    assert all(dof.saved == 0.0 for dof in robot.dofs)


@pytest.fixture
def kit() -> Kit:
    return Kit()


def read(kit: Kit, **keys: object) -> tuple[Assembly, GraphSections, Diagnostics]:
    """What a document is in our own terms."""
    log = Diagnostics()
    assembly = read_assembly(bundle_of(kit.document).body(bundle_of(kit.document).definition))
    assembly, made = translated(assembly, GraphSections.model_validate(keys), log)
    return assembly, made, log


def codes(log: Diagnostics) -> list[str]:
    found = [note.code for note in (*log.problems, *log.found)]
    found.remove("I-PEER")
    return found


def names(assembly: Assembly) -> list[tuple[str, str]]:
    return sorted((mate.ref.name, mate.ref.type) for mate in assembly.mates)


def connectors(assembly: Assembly) -> set[str]:
    return {connector.name for connector in assembly.connectors}


def test_a_prefix_makes_a_joint_of_any_type_and_fastened_parts_stay_apart(kit: Kit) -> None:
    base, one, two, three, four = (kit.place(name) for name in ("Base", "A", "B", "C", "D"))
    kit.root.revolute("dof_hip_roll", (one, HERE), (base, TOP))
    kit.root.fasten("dof_mount", (two, HERE), (base, TOP))
    kit.root.planar("dof_table", (three, HERE), (base, TOP))
    kit.root.fasten("Fastened 1", (four, HERE), (base, TOP))
    assembly, _, log = read(kit)
    assert names(assembly) == [
        ("Fastened 1", "FASTENED"), ("hip_roll", "REVOLUTE"), ("mount", "FIXED"), ("table", "PLANAR"),
    ]  # fmt: skip
    assert codes(log) == []


def test_a_weld_may_be_of_any_type(kit: Kit) -> None:
    base, one = (kit.place(name) for name in ("Base", "A"))
    kit.root.slider("fix_it", (one, HERE), (base, TOP), value=0.1)
    assert names(read(kit)[0]) == [("fix_it", "FASTENED")]


@pytest.mark.parametrize("name", ["dof_left_wheel", "dof_continuous_turn", "dof_wheel_inv"])
def test_a_wheel_has_no_limits(kit: Kit, name: str) -> None:
    base, wheel = (kit.place(name) for name in ("Base", "Wheel"))
    kit.root.revolute(name, (wheel, HERE), (base, TOP), limits=(-1, 1))
    assert read(kit)[0].mates[0].limits == {}


def test_inverted_limits_change_sides_and_sign_but_those_along_x_do_not(kit: Kit) -> None:
    base, table = (kit.place(name) for name in ("Base", "Table"))
    kit.root.planar("dof_t_inv", (table, HERE), (base, TOP), limits=((-1, 2), (-3, None), (-5, 6)))
    (mate,) = read(kit)[0].mates
    assert mate.ref.name == "t"
    assert mate.limits == {
        "limitXMin": -1, "limitXMax": 2, "limitYMax": 3, "limitAxialZMin": -6, "limitAxialZMax": 5,
    }  # fmt: skip


def test_a_cylindrical_joint_only_turns_about_where_its_first_side_is_and_that_is_reported(kit: Kit) -> None:
    base, arm = (kit.place(name) for name in ("Base", "Arm"))
    limits = ((-1, 1), (-2, 2))
    kit.root.cylindrical("dof_a", (arm, SIDE), (base, TOP), value=(0.2, 0.3), limits=limits)
    assembly, _, log = read(kit)
    (mate,) = assembly.mates
    first, second = (assembly.world_from(entity) for entity in mate.entities)
    assert (mate.ref.type, mate.limits) == ("REVOLUTE", {"limitAxialZMin": -2, "limitAxialZMax": 2})
    assert np.allclose(first[:3, 3], second[:3, 3])
    assert codes(log) == ["W-PEER-SLIDE"]


def test_a_joint_without_a_name_is_refused(kit: Kit) -> None:
    base, arm = (kit.place(name) for name in ("Base", "Arm"))
    kit.root.revolute("dof_inv", (arm, HERE), (base, TOP))
    assert codes(read(kit)[2]) == ["E-PEER-NAME"]


def test_mates_that_the_tool_passes_over_are_passed_over_and_reported(kit: Kit) -> None:
    base, arm = (kit.place(name) for name in ("Base", "Arm"))
    kit.root.revolute("dof_a", (arm, HERE), (base, TOP))
    kit.root.revolute("Hinge", (arm, HERE), (base, TOP), redundant=True)
    kit.root.fasten("Fastened", (base, HERE), (ORIGIN, HERE))
    assembly, _, log = read(kit)
    assert names(assembly) == [("a", "REVOLUTE")]
    assert codes(log) == ["W-PEER-MATE", "W-PEER-MATE"]


def test_what_closes_a_loop_is_cut_and_keeps_its_links_apart(kit: Kit) -> None:
    base, arm = (kit.place(name) for name in ("Base", "Arm"))
    kit.root.revolute("dof_a", (arm, HERE), (base, TOP))
    kit.root.fasten("closing_[x]", (arm, HERE), (base, TOP), closing=True)
    assembly, keys, _ = read(kit, loops={"cut": ["mine"]})
    assert names(assembly) == [("a", "REVOLUTE"), ("closing_[x]", "FIXED")]
    assert keys.loops.cut == ("mine", "closing_[[]x]")


def test_a_marker_is_a_frame_and_no_part_whichever_side_it_is(kit: Kit) -> None:
    base, arm, pin = (kit.place(name) for name in ("Base", "Arm", "Pin"))
    kit.root.revolute("dof_a", (arm, HERE), (base, TOP))
    kit.root.fasten("frame_tip", (arm, TOP), (pin, SIDE))
    assembly, _, log = read(kit)
    assert len(assembly.parts) == 2
    (marker,) = (one for one in assembly.connectors if one.name == "tip")
    assert marker.entity.path == arm.path
    assert np.allclose(assembly.world_from(marker.entity), kit.document.truth.poses()[pin.path])
    assert codes(log) == ["I-PEER-MARKER"]


def test_a_marker_that_is_part_of_a_link_is_refused(kit: Kit) -> None:
    base, arm = (kit.place(name) for name in ("Base", "Arm"))
    kit.root.revolute("dof_a", (arm, HERE), (base, TOP))
    kit.root.fasten("frame_tip", (arm, HERE), (base, TOP), closing=True)
    assert codes(read(kit)[2]) == ["E-PEER-FRAME"]


def test_connectors_count_by_their_prefix(kit: Kit) -> None:
    base, arm = (kit.place(name) for name in ("Base", "Arm"))
    kit.root.revolute("dof_a", (arm, HERE), (base, TOP))
    for name in ("frame_eye", "link_upper", "Mate connector 1"):
        kit.root.connector(name, arm, SIDE)
    assert connectors(read(kit)[0]) == {"eye", "link_upper", "link_base"}


def test_links_are_called_after_their_first_instance_and_counted_along_the_joints(kit: Kit) -> None:
    base = kit.place("Base")
    source = kit.bar("Leg")
    one, two, three = (kit.root.add(source, name=f"Leg <{number}>") for number in (1, 2, 3))
    cap = kit.place("Cap")
    kit.root.revolute("dof_a", (two, HERE), (base, TOP))
    kit.root.revolute("dof_b", (one, HERE), (two, TOP))
    kit.root.revolute("dof_cap", (three, HERE), (base, SIDE))
    kit.root.fasten("Glue", (cap, HERE), (three, TOP))
    assembly, keys, _ = read(kit)
    called = {one.entity.path: one.name for one in assembly.connectors}
    assert called == {
        base.path: "link_base", two.path: "link_leg", one.path: "link_leg_2", three.path: "link_leg_3",
    }  # fmt: skip
    assert (keys.root.select, keys.zero, keys.depth.max) == ("base", "saved", 0)


def test_a_joint_keeps_its_name_where_a_link_has_the_same(kit: Kit) -> None:
    base, arm = (kit.place(name) for name in ("Base", "Arm"))
    kit.root.revolute("dof_arm", (arm, HERE), (base, TOP))
    assert connectors(read(kit)[0]) == {"link_base", "link_arm_link"}


def test_the_first_instance_that_is_there_is_the_root_and_only_what_is_fixed_in_it_counts(kit: Kit) -> None:
    kit.place("Ghost", suppressed=True)
    base, arm = (kit.place(name, fixed=name == "Arm") for name in ("Base", "Arm"))
    kit.root.revolute("dof_a", (arm, HERE), (base, TOP))
    assembly, keys, log = read(kit)
    assert keys.root.select == "base"
    assert not any(occurrence.fixed for occurrence in assembly.occurrences.values())
    assert codes(log) == ["W-PEER-FIXED"]


def test_keys_that_the_user_set_stay(kit: Kit) -> None:
    base, arm = (kit.place(name, fixed=name == "Arm") for name in ("Base", "Arm"))
    kit.root.revolute("dof_a", (arm, HERE), (base, TOP))
    assembly, keys, _ = read(kit, root={"select": "arm"}, depth={"max": 1})
    assert (keys.root.select, keys.depth.max) == ("arm", 1)
    assert assembly.occurrences[arm.path].fixed


def geared(kit: Kit, names: tuple[str, str], reverse: bool) -> None:
    base, one, two = (kit.place(name, fixed=name == "Base") for name in ("Base", "One", "Two"))
    first = kit.root.revolute(names[0], (one, HERE), (base, TOP))
    second = kit.root.revolute(names[1], (base, frame((0.3, 0, 0))), (two, SIDE))
    kit.root.gear("Gear 1", first, second, ratio=3.0, reverse=reverse)


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize(
    "names", [("dof_a", "dof_b_inv"), ("dof_a_inverted", "dof_b"), ("dof_a_inv", "dof_b_inv")]
)
def test_a_gear_moves_inverted_joints_as_it_does_in_cad(names: tuple[str, str], reverse: bool) -> None:
    """The tool writes them wrong, or about no joint. At zero no pose tells the sign."""
    kit, plain = Kit(), Kit()
    geared(kit, names, reverse)
    geared(plain, ("dof_a", "dof_b"), reverse)
    robot, expected = built(kit.document), built(plain.document)

    def poses(robot: Robot, amount: float):
        (relation,) = robot.relations
        assert (relation.driver, relation.follower, relation.offset) == ("a", "b", 0.0)
        found = link_poses(robot, {"a": amount, "b": relation.multiplier * amount})
        return [
            robot.world_from_root @ found[link.name] @ inverse_of(robot, link.name) for link in robot.links
        ]

    def inverse_of(robot: Robot, name: str):
        return np.linalg.inv(robot.world_from_root @ link_poses(robot)[name])

    sign = -1.0 if "inv" in names[0] else 1.0
    for one, other in zip(poses(robot, 0.7 * sign), poses(expected, 0.7), strict=True):
        assert np.allclose(one, other, atol=1e-12)


def test_a_loop_that_nobody_declared_is_a_loop(kit: Kit) -> None:
    """The tool builds its last link twice."""
    base, one, two = (kit.place(name, fixed=name == "Base") for name in ("Base", "One", "Two"))
    kit.root.revolute("dof_a", (one, HERE), (base, HERE), value=0.3)
    kit.root.revolute("dof_b", (two, HERE), (base, frame((0.2, 0, 0))), value=0.5)
    poses = kit.document.truth.poses()
    at = [np.linalg.inv(poses[path.path]) @ frame((0.1, 0.1, 0)) for path in (one, two)]
    kit.root.revolute("dof_c", (one, at[0]), (two, at[1]), closing=True)
    robot = built(kit.document)
    assert sorted(link.name for link in robot.links) == ["base", "one", "two"]
    assert len(robot.loops) == 1


def test_two_joints_between_two_links_are_one(kit: Kit) -> None:
    """The tool builds the second link twice, and its joint by the same name."""
    base, arm = (kit.place(name, fixed=name == "Base") for name in ("Base", "Arm"))
    kit.root.revolute("dof_a", (arm, HERE), (base, TOP), value=0.3)
    kit.root.revolute("dof_b", (arm, HERE), (base, TOP), value=0.3, redundant=True)
    robot = built(kit.document)
    assert [joint.name for joint in robot.joints] == ["a"]
    assert "I-COMPOSED" in [note.code for note in robot.diagnostics]


def test_limits_that_only_the_list_of_features_has_are_inverted_too(kit: Kit) -> None:
    base, arm = (kit.place(name, fixed=name == "Base") for name in ("Base", "Arm"))
    kit.root.revolute("dof_a_inv", (arm, HERE), (base, TOP), value=0.5, limits=(-1.0, 2.0))
    with OnshapeServer(kit.document, newest=16) as server:
        bundle = fetched(onshape(server.document_url()), environ=server.environ).bundle
    (dof,) = build_robot(bundle, plan_of(conventions="onshape_to_robot")).dofs
    assert (dof.limits.lower, dof.limits.upper) == (pytest.approx(-1.5), pytest.approx(1.5))
