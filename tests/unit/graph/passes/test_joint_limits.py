"""Properties of dofs by glob, and what is told of limits."""

import math
from dataclasses import replace

import pytest
import yaml

from linkwright.stages.graph.passes.added_links import with_added_links
from linkwright.stages.graph.passes.limits.joint_limits import with_properties
from linkwright.stages.graph.passes.limits.limit_checks import LOCKED_PLAY, check_limits, report_loop_limits
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.dofs import LimitOrigin
from linkwright.stages.robot.model.robot import Limits, Relation, Robot
from tests.support.robots import CARRIED, LOOPS, at, joint, loop, robot_with


def wanted(**joints):
    return GraphSections(joints=joints).joints


def given(robot: Robot, keys) -> tuple[Robot, Diagnostics]:
    log = Diagnostics()
    return with_properties(robot, keys, log), log


def checked(robot: Robot, keys=None) -> tuple[Robot, Diagnostics]:
    log = Diagnostics()
    return check_limits(robot, log, keys), log


def told(log: Diagnostics) -> list[tuple[str, str]]:
    return [(one.code, one.where) for one in (*log.problems, *log.found)]


@pytest.fixture
def arm() -> Robot:
    return robot_with(
        [
            joint("revolute", "base", "upper", [0.2], name="left_hip"),
            joint("cylindrical", "upper", "lower", [0.0, 0.1], name="lift", backwards=True),
            joint("ball", "lower", "hand", name="wrist"),
        ],
        loops=[loop("pin_slot", "hand", "base", at(0), at(0), name="slot")],
    )


def test_later_entries_win_field_by_field(arm: Robot) -> None:
    keys = wanted(**{"*": {"damping": 0.1, "effort": 5}, "*_turn": {"effort": 7, "limits": [-1, None]}})
    robot, log = given(arm, keys)
    assert not told(log)
    dofs = {dof.name: dof for dof in (*robot.dofs, *robot.loops[0].dofs)}
    assert {dof.dynamics.damping for dof in dofs.values()} == {0.1}
    turned = {name for name, dof in dofs.items() if dof.limits == Limits(-1, None)}
    assert turned == {name for name, dof in dofs.items() if dof.dynamics.effort == 7}
    assert turned == {"lift_turn", "slot_turn"}


def test_a_glob_without_a_match_lists_the_dofs(arm: Robot) -> None:
    _, log = given(arm, wanted(**{"knee*": {"damping": 1}, "*": {"damping": 2}}))
    (only,) = log.problems
    assert (only.code, only.message) == ("E-GLOB", "no joint matches 'knee*'")
    assert only.hint == "joints are: left_hip, lift_slide, lift_turn, slot_slide, slot_turn, wrist"


def test_a_joint_of_several_dofs_says_which(arm: Robot) -> None:
    _, log = given(arm, wanted(lift={"damping": 1}))
    (only,) = log.problems
    assert only.code == "E-GLOB"
    assert only.hint == "name one of its dofs: lift_turn, lift_slide"


def test_one_range_is_not_for_turns_and_slides_alike(arm: Robot) -> None:
    _, log = given(arm, wanted(**{"lift*": {"limits": [0, 1]}}))
    (only,) = log.problems
    assert only.code == "E-JOINT"
    assert "lift_turn (turn), lift_slide (slide)" in only.message


def test_a_ball_takes_a_cone_and_no_lower_limit(arm: Robot) -> None:
    robot, log = given(arm, wanted(wrist={"limits": [None, 0.5], "damping": 0.2}))
    assert not told(log)
    wrist = robot.dofs[-1]
    assert (wrist.limits, wrist.dynamics.damping) == (Limits(None, 0.5), 0.2)
    _, log = given(arm, wanted(wrist={"limits": [-0.5, 0.5]}))
    assert [one.hint for one in log.problems] == ["limits: [null, cone]"]


def test_free_motion_takes_no_limits() -> None:
    robot = robot_with([joint("free", "base", "ball", name="ball")])
    _, log = given(robot, wanted(ball={"limits": [0, 1]}))
    assert told(log) == [("E-JOINT", "joints")]


@pytest.mark.parametrize(
    ("saved", "low", "high", "want"),
    [
        (-3.0, 3.0, 4.0, -3.0 + math.tau),
        (3.0, -4.0, -3.0, 3.0 - math.tau),
        (1.0, 10 * math.tau, 11 * math.tau, 1.0 + 10 * math.tau),
        (1.0, 2.0, 3.0, 1.0),
        (1.0, -10.0, 10.0, 1.0),
        (-0.1, 0.0, None, math.tau - 0.1),
        (1.0, 1.0 - math.tau, 1.0 - math.tau, 1.0 - math.tau),
    ],
)
def test_a_saved_turn_is_taken_into_its_limits(saved, low, high, want) -> None:
    limits = {"elbow": Limits(low, high)}
    robot = robot_with([joint("revolute", "base", "arm", [saved], name="elbow", limits=limits)])
    assert given(robot, {})[0].dofs[0].saved == pytest.approx(want, abs=1e-12)


def test_dynamics_that_act_on_nothing_are_reported_unless_meant_for_all() -> None:
    robot = robot_with(
        [joint("revolute", "base", "arm", name="elbow")],
        loops=[loop("revolute", "arm", "base", at(0), at(0), name="close")],
    )
    _, log = given(robot, wanted(**{"c*": {"damping": 1}}))
    assert told(log) == [("W-LOOP-DYNAMICS", "close")]
    assert not told(given(robot, wanted(**{"*": {"damping": 1}}))[1])


def test_missing_limits_are_reported_with_one_block_that_resolves_them(arm: Robot) -> None:
    lost = Limits(origin=LimitOrigin("the list of features is not there"))
    unknown = replace(arm.joints[0].dofs[0], limits=lost)
    arm = replace(arm, joints=(replace(arm.joints[0], dofs=(unknown,)), *arm.joints[1:]))
    _, log = checked(arm)
    assert told(log) == [("W-LIMIT", "left_hip"), ("W-LIMIT", "lift_turn"), ("W-LIMIT", "lift_slide")]
    assert [one.message for one in log.found] == [
        "its limits in CAD are unknown: the list of features is not there",
        "the joint has no limits: it turns freely",
        "the joint has no limits",
    ]
    assert log.found[0].hint.endswith("joints: {left_hip: {limits: [low, high]}}  # rad")
    block = log.found[-1].hint.partition("\n")[2].partition("\n")[2]
    said = yaml.safe_load(block)
    assert list(said["joints"]) == ["left_hip", "lift_turn", "lift_slide"]
    settled = wanted(**said["joints"])
    robot, log = given(arm, settled)
    robot, more = checked(robot, settled)
    assert not told(log)
    assert not told(more)
    assert {dof.limits for dof in robot.dofs} == {Limits()}


def test_what_follows_another_is_bounded_by_its_driver(arm: Robot) -> None:
    follows = Relation("gear", follower="left_hip", driver="lift_turn", multiplier=2.0, offset=0.0)
    _, log = checked(replace(arm, relations=(follows,)))
    assert told(log) == [("W-LIMIT", "lift_turn"), ("W-LIMIT", "lift_slide")]


def test_a_joint_that_cad_does_not_have_is_not_corrected_there() -> None:
    robot = robot_with([replace(joint("revolute", "base", "arm", name="elbow"), mate=None)])
    assert checked(robot)[1].found[0].hint == "joints: {elbow: {limits: [low, high]}}  # rad"


def test_an_added_joint_that_is_to_be_open_is_not_reported() -> None:
    asked = {
        "wheel": "continuous",
        "drawer": {"type": "prismatic", "limits": [None, None]},
        "lid": "revolute",
    }
    links = GraphSections(links={name: {"parent": "base", "joint": one} for name, one in asked.items()}).links
    log = Diagnostics()
    robot = with_added_links(robot_with(), links, log)
    check_limits(robot, log, {}, links)
    assert told(log) == [("W-LIMIT", "lid_joint")]


def limited(kind, value, low, high, name="elbow") -> Robot:
    return robot_with([joint(kind, "base", "arm", [value], name=name, limits={name: Limits(low, high)})])


def test_limits_upside_down_are_refused_by_name() -> None:
    _, log = checked(limited("revolute", 0.0, 1.0, -1.0))
    assert told(log) == [("E-LIMIT", "elbow")]


@pytest.mark.parametrize(("kind", "unit"), [("revolute", "rad"), ("prismatic", "m")])
def test_equal_limits_lock_with_a_little_play(kind, unit) -> None:
    robot, log = checked(limited(kind, 0.5, 0.5, 0.5))
    assert told(log) == [("W-LIMIT-LOCKED", "elbow")]
    assert f" {unit} either way" in log.found[0].message
    assert robot.dofs[0].limits == Limits(0.5 - LOCKED_PLAY, 0.5 + LOCKED_PLAY)


def test_a_saved_pose_outside_its_limits_is_reported() -> None:
    assert told(checked(limited("prismatic", 0.5, 0.0, 0.4))[1]) == [("W-SAVED-POSE", "elbow")]
    assert not told(checked(limited("prismatic", 0.4 + 1e-7, 0.0, 0.4))[1])
    tilted = (math.cos(0.4), math.sin(0.4) * 0.6, math.sin(0.4) * 0.8, 0.0)
    assert told(checked(limited("ball", tilted, None, 0.79))[1]) == [("W-SAVED-POSE", "elbow")]
    assert not told(checked(limited("ball", tilted, None, 0.81))[1])
    twisted = (math.cos(1.4), 0.0, 0.0, math.sin(1.4))
    assert not told(checked(limited("ball", twisted, None, 0.01))[1])


@pytest.mark.parametrize("cone", [0.0, -1.0, 3.2])
def test_a_cone_that_is_none_is_refused(cone) -> None:
    _, log = checked(limited("ball", (1.0, 0.0, 0.0, 0.0), None, cone))
    assert told(log) == [("E-LIMIT", "elbow")]
    assert "{limits: [null, cone]}" in log.problems[0].hint


@pytest.mark.parametrize("kind", LOOPS)
def test_a_loops_limits_are_reported_where_no_simulation_has_them(kind) -> None:
    bare = loop(kind, "arm", "base", at(0), at(0), name="close")
    limits = {dof.name: Limits(None if dof.kind == "ball" else -1.0, 1.0) for dof in bare.dofs}
    closing = loop(kind, "arm", "base", at(0), at(0), name="close", limits=limits)
    for one, idle in ((bare, False), (closing, kind not in CARRIED)):
        robot = robot_with([joint("revolute", "base", "arm", name="elbow")], loops=[one])
        log = Diagnostics()
        report_loop_limits(robot, log)
        assert told(log) == [("W-LOOP-LIMIT", dof.name) for dof in one.dofs if idle]
    log = Diagnostics()
    stale = Limits(origin=LimitOrigin("it is stale"))
    unknown = replace(bare, dofs=tuple(replace(dof, limits=stale) for dof in bare.dofs))
    report_loop_limits(robot_with(robot.joints, loops=[unknown]), log)
    assert told(log) == [("W-LIMIT", dof.name) for dof in bare.dofs]


def test_limits_of_carried_loops_are_judged_like_a_joints() -> None:
    limits = {"close": Limits(0.2, 0.1)}
    for kind, want in (("prismatic", [("E-LIMIT", "close")]), ("revolute", [])):
        closing = loop(kind, "arm", "base", at(0), at(0), name="close", limits=limits)
        robot = robot_with([joint("ball", "base", "arm", name="elbow")], loops=[closing])
        assert told(checked(robot)[1]) == want
