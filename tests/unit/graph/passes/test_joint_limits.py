"""Properties of dofs by glob, what is told of limits, and a URDF's numbers that are no limits."""

import math
from dataclasses import replace

import mujoco
import pytest
import yaml
from lxml import etree

from linkwright.stages.graph.passes.added_links import with_added_links
from linkwright.stages.graph.passes.limits.joint_limits import with_limits_and_dynamics
from linkwright.stages.graph.passes.limits.limit_checks import LOCKED_PLAY, check_limits, report_loop_limits
from linkwright.stages.graph.passes.limits.placeholders import without_placeholders
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.dofs import LimitOrigin
from linkwright.stages.robot.model.robot import Dynamics, Limits, Relation
from linkwright.stages.validate.simulate.noise import run_with_noise
from tests.support.building import plan_of, write
from tests.support.reported import codes, only, reports
from tests.support.robots import CARRIED, LOOPS, at, joint, loop, robot_with
from tests.support.urdfs import urdf_robot
from tests.unit.graph.urdf.test_reader import joint as urdf_joint
from tests.unit.graph.urdf.test_reader import link, robot_text


def keyed(robot, **joints):
    """The robot with these keys of `joints`."""
    log = Diagnostics()
    return with_limits_and_dynamics(robot, GraphSections(joints=joints).joints, log), log


def checked(robot, keys=None):
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


def test_large_limits_with_a_unit_are_taken(arm):
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
    assert [(note.code, note.where, note.message) for note in log.notes] == [
        ("W-LIMIT", "left_hip", "its limits in CAD are unknown: the list of features is not there"),
        ("W-LIMIT", "lift_turn", "the joint has no limits: it turns freely"),
        ("W-LIMIT", "lift_slide", "the joint has no limits"),
    ]
    assert log.notes[0].hint.endswith("joints: {left_hip: {limits: [low, high]}}  # rad")
    advice = yaml.safe_load(log.notes[-1].hint.split("\n", 2)[2])["joints"]
    assert list(advice) == ["left_hip", "lift_turn", "lift_slide"]
    robot, log = keyed(arm, **advice)
    robot, more = checked(robot, GraphSections(joints=advice).joints)
    assert reports(log) == reports(more) == []
    assert {dof.limits for dof in robot.dofs} == {Limits()}


def test_a_follower_is_bounded_by_its_driver(arm):
    follows = Relation("gear", follower="left_hip", driver="lift_turn", multiplier=2.0, offset=0.0)
    _, log = checked(replace(arm, relations=(follows,)))
    assert reports(log) == [("W-LIMIT", "lift_turn"), ("W-LIMIT", "lift_slide")]


def test_a_joint_that_cad_does_not_have_is_not_corrected_there():
    robot = robot_with([replace(joint("revolute", "base", "arm", name="elbow"), mate=None)])
    assert checked(robot)[1].notes[0].hint == "joints: {elbow: {limits: [low, high]}}  # rad"


def test_an_added_joint_that_is_to_be_open_is_not_reported():
    drawer = {"type": "prismatic", "limits": [None, None]}
    joints = {"wheel": "continuous", "drawer": drawer, "lid": "revolute"}
    added = {name: {"parent": "base", "joint": value} for name, value in joints.items()}
    links, log = GraphSections(links=added).links, Diagnostics()
    check_limits(with_added_links(robot_with(), links, log), log, {}, links)
    assert reports(log) == [("W-LIMIT", "lid_joint")]


def limited(kind, value, low, high, name="elbow"):
    return robot_with([joint(kind, "base", "arm", [value], name=name, limits={name: Limits(low, high)})])


@pytest.mark.parametrize(("kind", "unit"), [("revolute", "rad"), ("prismatic", "m")])
def test_equal_limits_lock_with_a_little_play(kind, unit):
    robot, log = checked(limited(kind, 0.5, 0.5, 0.5))
    assert reports(log) == [("W-LIMIT-LOCKED", "elbow")]
    assert f" {unit} either way" in log.notes[0].message
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
def test_saved_poses_outside_limits_are_reported(kind, value, low, high, code):
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


def dof_of(kind, limits, dynamics):
    """The dof of a joint with these properties after the pass, and what that reports."""
    row = joint(kind, "base", "arm", name="j", limits={"j": limits}, dynamics=dynamics)
    log = Diagnostics()
    (dof,) = without_placeholders(robot_with([row]), log).dofs
    return dof, log


OPEN = Limits()
RANGES = [
    ("revolute", Limits(-10, 10), OPEN), ("revolute", Limits(-100, 100), OPEN),
    ("revolute", Limits(-1e16, 1e16), OPEN), ("revolute", Limits(0, 1e16), Limits(0, None)),
    ("revolute", Limits(-1e16, 0.5), Limits(None, 0.5)), ("prismatic", Limits(-1e16, 1e16), OPEN),
    ("revolute", Limits(-6.28318530718, 6.28318530718), None), ("revolute", Limits(-9.42, 9.42), None),
    ("revolute", Limits(-9, 9), None), ("revolute", Limits(-10, 11), None),
    ("revolute", Limits(-10.5, 10.5), None), ("revolute", Limits(0, 10), None),
    ("prismatic", Limits(-10, 10), None), ("prismatic", Limits(-15, 15), None),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "limits", "expected"), RANGES)
def test_a_range_that_no_joint_has_is_open(kind, limits, expected):
    dof, log = dof_of(kind, limits, Dynamics())
    assert dof.limits == (limits if expected is None else expected)
    assert [problem.code for problem in log.notes] == ([] if expected is None else ["W-URDF-PLACEHOLDER"])


BOUNDS = [
    ("revolute", Dynamics(effort=1000.0, velocity=1000.0), (None, None)),
    ("revolute", Dynamics(effort=1e6, velocity=1e4), (None, None)),
    ("revolute", Dynamics(effort=1200.0, velocity=1500.0), (1200.0, 1500.0)),
    ("revolute", Dynamics(effort=100.0, velocity=100.0), (100.0, 100.0)),
    ("prismatic", Dynamics(effort=1000.0, velocity=1.0), (1000.0, 1.0)),
    ("prismatic", Dynamics(effort=1e6, velocity=1.0), (None, 1.0)),
]


@pytest.mark.parametrize(("kind", "dynamics", "expected"), BOUNDS)
def test_powers_of_ten_are_no_effort_and_no_velocity(kind, dynamics, expected):
    dof, _ = dof_of(kind, Limits(-1, 1), dynamics)
    assert (dof.dynamics.effort, dof.dynamics.velocity) == expected


PLACEHOLDER = '<limit lower="-10" upper="10" effort="1000" velocity="1000"/>'
TEXT = robot_text(
    *(link(name) for name in ("base", "upper", "lower")),
    urdf_joint("hip", "base", "upper", inside=PLACEHOLDER),
    urdf_joint("knee", "upper", "lower", inside=PLACEHOLDER),
)


def test_placeholders_are_named_together_with_their_joints():
    warning = only(urdf_robot(TEXT), "W-URDF-PLACEHOLDER")
    assert warning.where == "robot.urdf"
    for words in ("range -10 to 10 rad", "effort 1000 N m", "velocity 1000 rad/s"):
        assert f"{words} (hip, knee)" in warning.message
    assert "joints: {hip: {limits: [low, high], effort: N, velocity: N}}" in warning.hint


def test_the_same_numbers_count_where_the_user_gives_them(tmp_path):
    numbers = {"limits": [-10, 10], "effort": 1000, "velocity": 1000}
    robot = urdf_robot(TEXT, plan_of(joints={"*": numbers}))
    assert not {"W-URDF-PLACEHOLDER", "W-LIMIT"} & set(codes(robot))
    write(robot, tmp_path)
    limits = etree.parse(tmp_path / "robot.urdf").getroot().findall("joint/limit")
    written = {"lower": "-10", "upper": "10", "effort": "1000", "velocity": "1000"}
    assert [dict(limit.attrib) for limit in limits] == 2 * [written]


def legged():
    """A light body on four legs of three links, whose limits are those of no joint."""
    inertial = '<inertial><origin xyz="0 0 {z}"/><mass value="{m}"/>'
    inertial += '<inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/></inertial>'
    pieces = [link("base", inertial.format(z=0, m=1.2, i=0.01))]
    for leg, place in enumerate((".2 .1 0", ".2 -.1 0", "-.2 .1 0", "-.2 -.1 0")):
        parent = "base"
        for name, axis, origin, mass, moment in (
            ("turn", "1 0 0", place, 0.15, 4e-5),
            ("hip", "0 1 0", "0 .014 0", 0.15, 4e-4),
            ("knee", "0 1 0", "0 .03 -.16", 0.03, 1e-4),
        ):
            child = f"{name}_{leg}"
            pieces.append(link(child, inertial.format(z=-0.08, m=mass, i=moment)))
            ends = f'<parent link="{parent}"/><child link="{child}"/><origin xyz="{origin}"/>'
            pieces.append(
                f'<joint name="{child}" type="revolute">{ends}<axis xyz="{axis}"/>{PLACEHOLDER}</joint>'
            )
            parent = child
    return urdf_robot(robot_text(*pieces), plan_of(root={"base": "free"}))


def test_a_robot_with_placeholders_bears_noise_of_its_controls(tmp_path):
    write(legged(), tmp_path, plan_of(actuators={"*": {"type": "position"}}))
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    assert model.nu == 12
    assert run_with_noise(model, 1.0).failure == ""
