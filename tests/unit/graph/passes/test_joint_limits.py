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
from tests.support.reported import only, reports
from tests.support.robots import CARRIED, LOOPS, at, joint, loop, robot_with


def keyed(robot: Robot, **joints) -> tuple[Robot, Diagnostics]:
    """The robot with these keys of `joints`."""
    log = Diagnostics()
    return with_properties(robot, GraphSections(joints=joints).joints, log), log


def checked(robot: Robot, keys=None) -> tuple[Robot, Diagnostics]:
    log = Diagnostics()
    return check_limits(robot, log, keys), log


@pytest.fixture
def arm():
    return robot_with(
        [
            joint("revolute", "base", "upper", [0.2], name="left_hip"),
            joint("cylindrical", "upper", "lower", [0.0, 0.1], name="lift", backwards=True),
            joint("ball", "lower", "hand", name="wrist"),
        ],
        loops=[loop("pin_slot", "hand", "base", at(0), at(0), name="slot")],
    )


def test_later_entries_win_field_by_field(arm):
    keys = {"*": {"damping": 0.1, "effort": 5}, "*_turn": {"effort": 7, "limits": [-1, None]}}
    robot, log = keyed(arm, **keys)
    assert not reports(log)
    dofs = {dof.name: dof for dof in (*robot.dofs, *robot.loops[0].dofs)}
    assert {dof.dynamics.damping for dof in dofs.values()} == {0.1}
    turned = {name for name, dof in dofs.items() if dof.limits == Limits(-1, None)}
    assert turned == {name for name, dof in dofs.items() if dof.dynamics.effort == 7}
    assert turned == {"lift_turn", "slot_turn"}


@pytest.mark.parametrize(
    ("keys", "code", "words"),
    [
        ({"knee*": {"damping": 1}, "*": {"damping": 2}}, "E-GLOB", ["no joint matches 'knee*'", "joints are: "
         "left_hip, lift_slide, lift_turn, slot_slide, slot_turn, wrist"]),
        ({"left_hip": {"limits": [-90, 90]}}, "W-UNIT", ["-90 is taken as rad", "'-90 deg', or '-90 rad'"]),
        ({"lift_slide": {"limits": [0, 50]}}, "W-UNIT", ["50 is taken as m", "'50 mm', or '50 m'"]),
        ({"lift_turn": {"zero": 90}}, "W-UNIT", ["zero of 'lift_turn': 90 is taken as rad"]),
        ({"lift": {"damping": 1}}, "E-GLOB", ["name one of its dofs: lift_turn, lift_slide"]),
        ({"lift*": {"limits": [0, 1]}}, "E-JOINT", ["lift_turn (turn), lift_slide (slide)"]),
        ({"wrist": {"limits": [-0.5, 0.5]}}, "E-JOINT", ["limits: [null, cone]"]),
    ],
    ids=["no match", "degrees", "millimetres", "a zero in degrees", "several dofs", "turns and slides",
         "a ball's lower limit"],
)  # fmt: skip
def test_keys_that_no_joint_can_have_are_refused(arm, keys, code, words):
    problem = only(keyed(arm, **keys)[1])
    assert problem.code == code
    assert [word for word in words if word not in f"{problem.message}\n{problem.hint}"] == []


def test_large_limits_with_a_unit_and_small_ones_without_are_taken(arm):
    for limits in (["-90 rad", "90 rad"], ["-900 deg", "9 rev"], [-12.5, 12.5]):
        assert not reports(keyed(arm, left_hip={"limits": limits})[1])
    assert not reports(keyed(arm, lift_slide={"limits": ["0 m", "50 m"]})[1])


def test_a_ball_takes_a_cone_and_free_motion_takes_no_limits(arm):
    robot, log = keyed(arm, wrist={"limits": [None, 0.5], "damping": 0.2})
    assert not reports(log)
    assert (robot.dofs[-1].limits, robot.dofs[-1].dynamics.damping) == (Limits(None, 0.5), 0.2)
    _, log = keyed(robot_with([joint("free", "base", "ball", name="ball")]), ball={"limits": [0, 1]})
    assert reports(log) == [("E-JOINT", "joints")]


@pytest.mark.parametrize(
    ("saved", "low", "high", "want"),
    [
        (-3.0, 3.0, 4.0, -3.0 + math.tau), (3.0, -4.0, -3.0, 3.0 - math.tau),
        (1.0, 10 * math.tau, 11 * math.tau, 1.0 + 10 * math.tau), (1.0, 2.0, 3.0, 1.0),
        (1.0, -10.0, 10.0, 1.0), (-0.1, 0.0, None, math.tau - 0.1),
        (1.0, 1.0 - math.tau, 1.0 - math.tau, 1.0 - math.tau),
    ],
)  # fmt: skip
def test_a_saved_turn_is_taken_into_its_limits(saved, low, high, want):
    limits = {"elbow": Limits(low, high)}
    robot = robot_with([joint("revolute", "base", "arm", [saved], name="elbow", limits=limits)])
    assert keyed(robot)[0].dofs[0].saved == pytest.approx(want, abs=1e-12)


def test_dynamics_that_act_on_nothing_are_reported():
    closing = loop("revolute", "arm", "base", at(0), at(0), name="close")
    robot = robot_with([joint("revolute", "base", "arm", name="elbow")], loops=[closing])
    assert reports(keyed(robot, **{"c*": {"damping": 1}})[1]) == [("W-LOOP-DYNAMICS", "close")]
    assert not reports(keyed(robot, **{"*": {"damping": 1}})[1])


def test_missing_limits_are_reported_with_a_block_that_sets_them(arm):
    lost = Limits(origin=LimitOrigin("the list of features is not there"))
    unknown = replace(arm.joints[0].dofs[0], limits=lost)
    arm = replace(arm, joints=(replace(arm.joints[0], dofs=(unknown,)), *arm.joints[1:]))
    _, log = checked(arm)
    assert [(note.code, note.where, note.message) for note in log.found] == [
        ("W-LIMIT", "left_hip", "its limits in CAD are unknown: the list of features is not there"),
        ("W-LIMIT", "lift_turn", "the joint has no limits: it turns freely"),
        ("W-LIMIT", "lift_slide", "the joint has no limits"),
    ]
    assert log.found[0].hint.endswith("joints: {left_hip: {limits: [low, high]}}  # rad")
    said = yaml.safe_load(log.found[-1].hint.split("\n", 2)[2])["joints"]
    assert list(said) == ["left_hip", "lift_turn", "lift_slide"]
    robot, log = keyed(arm, **said)
    robot, more = checked(robot, GraphSections(joints=said).joints)
    assert reports(log) == reports(more) == []
    assert {dof.limits for dof in robot.dofs} == {Limits()}


def test_what_follows_another_is_bounded_by_its_driver(arm):
    follows = Relation("gear", follower="left_hip", driver="lift_turn", multiplier=2.0, offset=0.0)
    _, log = checked(replace(arm, relations=(follows,)))
    assert reports(log) == [("W-LIMIT", "lift_turn"), ("W-LIMIT", "lift_slide")]


def test_a_joint_that_cad_does_not_have_is_not_corrected_there():
    robot = robot_with([replace(joint("revolute", "base", "arm", name="elbow"), mate=None)])
    assert checked(robot)[1].found[0].hint == "joints: {elbow: {limits: [low, high]}}  # rad"


def test_an_added_joint_that_is_to_be_open_is_not_reported():
    drawer = {"type": "prismatic", "limits": [None, None]}
    joints = {"wheel": "continuous", "drawer": drawer, "lid": "revolute"}
    added = {name: {"parent": "base", "joint": value} for name, value in joints.items()}
    links, log = GraphSections(links=added).links, Diagnostics()
    check_limits(with_added_links(robot_with(), links, log), log, {}, links)
    assert reports(log) == [("W-LIMIT", "lid_joint")]


def limited(kind, value, low, high, name="elbow") -> Robot:
    return robot_with([joint(kind, "base", "arm", [value], name=name, limits={name: Limits(low, high)})])


@pytest.mark.parametrize(("kind", "unit"), [("revolute", "rad"), ("prismatic", "m")])
def test_equal_limits_lock_with_a_little_play(kind, unit):
    robot, log = checked(limited(kind, 0.5, 0.5, 0.5))
    assert reports(log) == [("W-LIMIT-LOCKED", "elbow")]
    assert f" {unit} either way" in log.found[0].message
    assert robot.dofs[0].limits == Limits(0.5 - LOCKED_PLAY, 0.5 + LOCKED_PLAY)


TILTED = (math.cos(0.4), math.sin(0.4) * 0.6, math.sin(0.4) * 0.8, 0.0)
TWISTED, IDENTITY = (math.cos(1.4), 0.0, 0.0, math.sin(1.4)), (1.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("kind", "value", "low", "high", "code"),
    [
        ("revolute", 0.0, 1.0, -1.0, "E-LIMIT"), ("prismatic", 0.5, 0.0, 0.4, "W-SAVED-POSE"),
        ("prismatic", 0.4 + 1e-7, 0.0, 0.4, None), ("ball", TILTED, None, 0.79, "W-SAVED-POSE"),
        ("ball", TILTED, None, 0.81, None), ("ball", TWISTED, None, 0.01, None),
        *(("ball", IDENTITY, None, cone, "E-LIMIT") for cone in (0.0, -1.0, 3.2)),
    ],
)  # fmt: skip
def test_saved_poses_outside_limits_and_empty_limits_are_reported(kind, value, low, high, code):
    _, log = checked(limited(kind, value, low, high))
    assert reports(log) == ([(code, "elbow")] if code else [])
    assert value != IDENTITY or "{limits: [null, cone]}" in log.problems[0].hint


@pytest.mark.parametrize("kind", LOOPS)
def test_limits_of_a_loop_that_no_simulation_has_are_reported(kind):
    bare = loop(kind, "arm", "base", at(0), at(0), name="close")
    limits = {dof.name: Limits(None if dof.kind == "ball" else -1.0, 1.0) for dof in bare.dofs}
    closing = loop(kind, "arm", "base", at(0), at(0), name="close", limits=limits)
    for closed, idle in ((bare, False), (closing, kind not in CARRIED)):
        robot = robot_with([joint("revolute", "base", "arm", name="elbow")], loops=[closed])
        log = Diagnostics()
        report_loop_limits(robot, log)
        assert reports(log) == [("W-LOOP-LIMIT", dof.name) for dof in closed.dofs if idle]
    log = Diagnostics()
    stale = Limits(origin=LimitOrigin("it is stale"))
    unknown = replace(bare, dofs=tuple(replace(dof, limits=stale) for dof in bare.dofs))
    report_loop_limits(robot_with(robot.joints, loops=[unknown]), log)
    assert reports(log) == [("W-LIMIT", dof.name) for dof in bare.dofs]


def test_limits_of_carried_loops_are_judged_like_a_joints():
    limits = {"close": Limits(0.2, 0.1)}
    for kind, want in (("prismatic", [("E-LIMIT", "close")]), ("revolute", [])):
        closing = loop(kind, "arm", "base", at(0), at(0), name="close", limits=limits)
        robot = robot_with([joint("ball", "base", "arm", name="elbow")], loops=[closing])
        assert reports(checked(robot)[1]) == want
