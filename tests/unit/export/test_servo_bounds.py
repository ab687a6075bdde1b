"""Bounds of an estimated servo: singular poses of loops, the time step, inertia; remarks about actuators."""

import math
from dataclasses import replace

import numpy as np
import pytest

from linkwright.stages.export import export
from linkwright.stages.export.actuators.actuate import actuate
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Dynamics, Limits, Relation, frozen
from linkwright.stages.robot.motion.couplings import Couplings
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.loops import gap
from linkwright.stages.robot.motion.pose_batch import select
from linkwright.stages.robot.motion.pose_samples import sampled_poses
from linkwright.stages.robot.motion.start_pose import saved
from tests.support import mjcfs
from tests.support.building import NO_MESHES, plan_of
from tests.support.exports import compiled, exported, messages_of
from tests.support.pendulums import ACROSS, ARM, GRAVITY, MASS, actuation, at_home, lump, pendulum, targeted
from tests.support.reported import notes
from tests.support.robots import at, joint, loop, robot_with
from tests.unit.robot.test_home import four_bar as planar_bar

LENGTH = 0.5
"""The length of the bar [m]."""

ALONG_X = np.array([[0.0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]])
"""A frame whose z axis is the world's x."""

ABOUT_Y = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
"""A frame whose z axis is across x and z."""

LIFTED = 25.0
"""The mass of all that moves [kg]: a block, the bar, and a table."""


def lift(x, low=0.1, high=LENGTH):
    """A bar whose foot slides along the ground (`drive`), saved at `x`, and whose head pushes a table up
    (`table`): at y = √(L² − x²) the drive bears x / y times the table, without end where the bar lies
    flat."""
    y = math.sqrt(LENGTH**2 - x**2)
    tilt = math.atan2(x, -y)
    drive = {"name": "drive", "place": ALONG_X, "limits": {"drive": Limits(low, high)}}
    joints = [
        joint("prismatic", "base", "block", [x], **drive),
        joint("revolute", "block", "bar", [tilt], name="pivot", place=ABOUT_Y),
        joint("prismatic", "base", "table", [y], name="table"),
    ]
    turned = np.linalg.inv(ABOUT_Y) @ ALONG_X @ ABOUT_Y
    angle = math.atan2(turned[1, 0], turned[0, 0]) + tilt
    end = loop("revolute", "bar", "table", at(LENGTH, 0, 0), ABOUT_Y, saved=[angle])
    inertials = {name: lump(mass, 0, 0, 0) for name, mass in (("base", 90), ("block", 1), ("table", 20))}
    inertials["bar"] = lump(4, LENGTH / 2, 0, 0)
    robot = robot_with(joints, loops=[end], inertials=inertials)
    assert gap(robot.loops[0], link_poses(robot, saved(robot))) < 1e-12
    return robot


def driven(robot, timestep=0.002, **entries):
    drives, remarks = actuate(robot, plan_of(actuators=entries).actuators, timestep, np.eye(4))
    return drives, {remark.code: remark for remark in remarks}


@pytest.mark.parametrize("x", [0.3, 0.49, LENGTH - 1e-5, LENGTH - 1e-9])
def test_lift_that_may_be_flat_has_a_servo_of_its_size(x):
    """Where it lies flat, the load and the inertia on its drive have no end."""
    drives, _ = driven(lift(x), drive="position")
    (servo,) = drives.actuators
    (armature,) = drives.armatures
    assert 200 < servo.load <= 10 * LIFTED * GRAVITY
    assert armature.value <= LIFTED
    assert servo.kp * servo.gear**2 <= LIFTED * (0.2 / 0.002) ** 2
    assert abs(servo.home - x) < 0.02


def test_poses_near_the_flat_one_are_left_out_and_named():
    _, remarks = driven(lift(LENGTH - 1e-5), drive="position")
    remark = remarks["I-SINGULAR"]
    assert "drive from 0." in remark.message
    assert "joints: {drive: {limits: [..., ...]}}" in remark.hint
    _, remarks = driven(lift(0.3, high=0.45), drive="position")
    assert "I-SINGULAR" not in remarks


def test_pose_with_a_nearly_flat_bar_is_near_singular():
    robot = lift(0.4999)
    poses = sampled_poses(robot, 64, 0.5, saved(robot))
    near = Couplings(robot, poses).near_singular(["drive"])["drive"]
    rise = np.abs(poses["table"])
    assert near.any()
    assert rise[near].max() < 0.2 * rise.max()
    assert rise[~near].min() > 0.02 * rise.max()
    # What pushes the table instead has no leverage there.
    away = select(poses, rise > 0.1)
    assert not Couplings(robot, away).near_singular(["table"])["table"].any()


def test_servo_is_softer_where_the_time_step_is_too_long():
    """A pendulum so short that its weight asks for a servo that is fast for the step."""
    swing = joint("revolute", "base", "arm", [0.0], place=ACROSS, limits={"arm_joint": Limits(-1, 1)})
    small = robot_with([swing], inertials={"arm": lump(1.0, 0.005, 0, 0)})
    inertia = 0.005**2 + 1e-4
    drives, remarks = driven(small, timestep=0.01, **{"*": "position"})
    (servo,), (armature,) = drives.actuators, drives.armatures
    assert armature.value <= inertia * 1.01
    assert servo.kp == pytest.approx(inertia * (0.4 / 0.01) ** 2, rel=0.01)
    remark = remarks["W-ACTUATOR-STEP"]
    assert "arm_joint (kp " in remark.message
    step = float(remark.hint.split("timestep: ")[1].split("}")[0])
    assert step < 0.01
    drives, remarks = driven(small, timestep=step, **{"*": "position"})
    assert "W-ACTUATOR-STEP" not in remarks
    assert drives.actuators[0].kp == pytest.approx(2 * 0.005 * GRAVITY / 0.01, rel=0.01)


def test_given_stiffness_stays_with_a_bounded_armature():
    drives, remarks = driven(pendulum(), **{"*": {"type": "position", "kp": 5e5}})
    (armature,) = drives.armatures
    assert drives.actuators[0].kp == 5e5
    assert armature.value == pytest.approx(2.0 * (ARM**2 + 1e-4), rel=0.01)
    assert "arm_joint (kp 5e+05; 0.0002 s is short enough for 5e+05)" in remarks["W-ACTUATOR-STEP"].message
    _, remarks = driven(pendulum(armature=0.01), **{"*": {"type": "position", "kp": 5e5}})
    assert "W-ACTUATOR-STEP" not in remarks


def test_robot_without_gravity_does_not_stand():
    swing = joint("revolute", "base", "arm", [0.0], place=ACROSS)
    masses = {"base": lump(50.0, -1, 0, 0), "arm": lump(MASS, ARM, 0, 0)}
    robot = robot_with([swing], inertials=masses, fixed=False)
    entries = plan_of(actuators={"*": {"type": "position", "kp": 1e7}}).actuators
    (armature,) = actuate(robot, entries, 0.002, np.eye(4), gravity=(0.0, 0.0, 0.0))[0].armatures
    assert armature.value == pytest.approx(MASS * (ARM**2 + 1e-4), rel=0.01)


@pytest.mark.parametrize("kp", [8e3, 1.2e4, 3.2e4])
def test_advised_time_step_is_short_enough(kp):
    """The longest is no round number: 1.9, 1.5 and 0.95 ms."""
    entry = {"type": "position", "kp": kp}
    _, remarks = driven(pendulum(), timestep=0.002, **{"*": entry})
    step = float(remarks["W-ACTUATOR-STEP"].hint.split("timestep: ")[1].split("}")[0])
    assert step < 0.002
    _, remarks = driven(pendulum(), timestep=step, **{"*": entry})
    assert "W-ACTUATOR-STEP" not in remarks


def test_armature_above_the_inertia_at_home_is_a_warning():
    """Two turns one on the other: folded at home the first moves little, stretched four times as much."""
    limits = {"fold": Limits(-3.1, 3.1), "swing": Limits(-1.0, 1.0)}
    rows = [
        joint("revolute", "base", "upper", [0.0], name="swing", place=ACROSS, limits=limits),
        joint("revolute", "upper", "lower", [3.1], name="fold", place=at(0.1, 0, 0), limits=limits),
    ]
    robot = robot_with(rows, inertials={"upper": lump(0.1, 0, 0, 0), "lower": lump(2.0, 0.1, 0, 0)})
    _, remarks = driven(robot, timestep=0.004, **{"*": "position"})
    assert "swing (" in remarks["W-ARMATURE"].message
    assert "swing" not in remarks["I-ARMATURE"].message


def two_legs(**dynamics):
    legs = [
        joint(
            *("revolute", "base", name, [0.0]),
            place=at(0.3, y, 0) @ ACROSS,
            limits={f"{name}_joint": Limits(-1, 1)},
            dynamics=Dynamics(**dynamics),
        )
        for name, y in (("left", 0.2), ("right", -0.2))
    ]
    inertials = {"base": lump(10.0, 0, 0, 0)} | {name: lump(0.5, 0, -0.4, 0) for name in ("left", "right")}
    return robot_with(legs, fixed=False, inertials=inertials)


def test_leg_carries_the_robot_on_its_foot():
    drives, _ = driven(two_legs(), **{"*": "position"})
    for servo in drives.actuators:
        assert servo.kp == pytest.approx(2 * servo.load / 0.1, rel=0.01)
    (most, *_) = (armature.value for armature in drives.armatures)
    hanging, standing = 0.5 * 0.4**2, 10.0 * 0.3**2
    assert hanging < standing
    assert most <= standing
    strong, _ = driven(two_legs(effort=20.0), **{"*": "position"})
    assert [servo.kp for servo in strong.actuators] == [200.0, 200.0]


def test_number_for_turns_and_slides_is_an_error():
    joints = [
        joint("prismatic", "base", "column", [0.1], name="lift"),
        joint("revolute", "column", "arm", [0.0], place=ACROSS),
    ]
    robot = robot_with(joints)
    entries = {"*": {"type": "position", "kp": 100, "kv": 2}, "lift": {"kp": 4000, "kv": 90}}
    lift_servo, turn = exported(robot, actuators=entries).written.actuation.actuators  # type: ignore[union-attr]
    assert (lift_servo.kp, turn.kp) == (4000, 100)


def test_servos_that_a_plain_reset_moves_are_named():
    outcome = exported(pendulum(), actuators={"*": "position"})
    assert not messages_of(outcome, "I-RESET")
    limits = {"arm_joint": Limits(0.4, 1.0)}
    raised = robot_with([joint("revolute", "base", "arm", [0.6], place=ACROSS, limits=limits)])
    outcome = exported(raised, actuators={"*": "position"})
    (remark,) = (remark for remark in outcome.diagnostics if remark.code == "I-RESET")
    assert "arm_joint (from 0.6 to 0.4)" in remark.message
    assert "mj_resetDataKeyframe" in remark.hint
    plan = plan_of(actuators={"*": "motor"})
    assert "I-RESET" not in [remark.code for remark in export(raised, NO_MESHES, plan).diagnostics]


def test_advice_names_the_joint_that_falls_without_actuators():
    outcome = exported(pendulum())
    assert outcome.written.actuation == Actuation()
    assert b"<actuator" not in outcome.files["robot.xml"]
    assert b"ctrl=" not in outcome.files["robot.xml"]
    assert outcome.advice == "nothing holds arm_joint against its weight: try actuators=position"


def test_advice_is_empty_where_nothing_falls():
    assert exported(pendulum(friction=MASS * GRAVITY * ARM * 1.01)).advice == ""
    assert exported(pendulum(friction=MASS * GRAVITY * ARM * 0.99)).advice != ""
    assert exported(pendulum(), actuators={"*": "motor"}).advice == ""
    upright = robot_with([joint("revolute", "base", "arm", [0.0])])
    assert exported(upright).advice == ""


def test_advice_names_any_dof_of_a_joint():
    """A cylindrical joint along gravity, whose slide comes before its turn."""
    robot = robot_with([joint("cylindrical", "base", "rod", [0.0, 0.0])])
    assert exported(robot).advice.startswith("nothing holds rod_joint_slide against its weight")


def test_advice_leaves_out_robots_that_tendons_drive(tmp_path):
    hinge = '<joint name="hinge" axis="0 1 0"/><geom size="0.05" pos="0.1 0 0"/>'
    arm = mjcfs.body("base", mjcfs.body("arm", hinge))
    more = '<tendon><fixed name="cord"><joint joint="hinge" coef="2"/></fixed></tendon>'
    servo = '<actuator><position name="servo" tendon="cord" kp="100"/></actuator>'
    advice = [
        mjcfs.rebuilt(mjcfs.written(tmp_path, mjcfs.model(arm, text))).advice for text in (more, more + servo)
    ]
    assert advice == ["nothing holds hinge against its weight: try actuators=position", ""]


def test_actuator_has_another_name_than_that_of_a_tendon(tmp_path):
    arm = mjcfs.body("base", mjcfs.body("arm", '<joint name="hinge" axis="0 1 0"/>'))
    cord = '<tendon><fixed name="cord"><joint joint="hinge" coef="2"/></fixed></tendon>'
    motor = '<actuator><motor name="hinge" tendon="cord"/></actuator>'
    outcome = mjcfs.rebuilt(
        mjcfs.written(tmp_path, mjcfs.model(arm, cord + motor)), actuators={"hinge": "position"}
    )
    model = compiled(outcome)
    assert {model.actuator(index).name for index in range(model.nu)} == {"hinge", "hinge_2"}


def weighing():
    """Two turns of which the second bears the weight and follows the first."""
    swings = [
        joint("revolute", "base", "a", [0.0], place=ACROSS),
        joint("revolute", "base", "b", [0.0], place=at(0, 0.5, 0) @ ACROSS),
    ]
    inertials = {"a": lump(1.0, 0, 0, 0), "b": lump(MASS, ARM, 0, 0)}
    relation = Relation("gear", "b_joint", "a_joint", 3.0, 0.0)
    return robot_with(swings, relations=[relation], inertials=inertials)


def upright_bar(limits=None):
    """A four-bar that gravity acts on: its plane is upright, and the rocker is heavy."""
    flat, heavy = planar_bar(limits), {"rocker": lump(MASS, ARM, 0, 0)}
    joints = tuple(
        replace(hinge, parent_from_joint=frozen(ACROSS @ hinge.parent_from_joint))
        if hinge.parent == "base"
        else hinge
        for hinge in flat.joints
    )
    links = tuple(replace(link, inertial=heavy.get(link.name, link.inertial)) for link in flat.links)
    return replace(flat, joints=joints, links=links)


def test_advice_names_drivers_and_not_followers():
    assert exported(weighing()).advice == "nothing holds a_joint against its weight: try actuators=position"
    bar = upright_bar()
    (servo,) = actuation(bar, **{"*": "position"}).actuators
    assert exported(bar).advice == f"nothing holds {servo.dof} against its weight: try actuators=position"


def remarks(robot, code, **actuators):
    return [f"{note.message} -> {note.hint}" for note in notes(exported(robot, actuators=actuators), code)]


def test_dofs_that_are_driven_twice_are_reported():
    (remark,) = remarks(upright_bar(), "W-ACTUATOR-TWICE", drive="position", swing="position")
    assert remark.startswith(
        "swing is driven, although driven dofs already move it, by a loop or a relation: drive."
    )
    assert "its kp of 1 assumes no load, since drive bears the weight" in remark
    assert remark.endswith("actuators: {drive: none}")
    swing = {"type": "position", "kp": 3}
    (remark,) = remarks(upright_bar(), "W-ACTUATOR-TWICE", drive="position", swing=swing)
    assert "its kp" not in remark
    assert remarks(weighing(), "W-ACTUATOR-TWICE", a_joint="position", b_joint="motor") != []
    assert remarks(upright_bar(), "W-ACTUATOR-TWICE", **{"*": "position"}) == []


def test_target_without_a_range_is_reported_if_others_bound_it():
    limited = upright_bar({"swing": Limits(-4.0, 4.0)})
    messages = remarks(limited, "I-ACTUATOR", drive="position")
    assert messages == [
        "drive has no limits of its own, so its control has no range; other dofs that move with it have "
        "limits: swing -> joints: {drive: {limits: [..., ...]}}"
    ]
    assert remarks(upright_bar(), "I-ACTUATOR", drive="position") == []
    both_limited = upright_bar({"swing": Limits(-4.0, 4.0), "drive": Limits(-4.0, 4.0)})
    assert remarks(both_limited, "I-ACTUATOR", drive="position") == []


def test_follower_puts_its_weight_on_its_driver():
    robot = weighing()
    (servo,) = actuation(robot, **{"*": "position"}).actuators
    assert servo.home_load == pytest.approx(3.0 * MASS * GRAVITY * ARM, rel=1e-9)
    data = targeted(compiled(exported(robot, actuators={"*": "position"})), 3.0)
    assert abs(data.joint("a_joint").qpos[0]) == pytest.approx(servo.sag, rel=0.05)


def test_actuator_too_weak_for_the_weight_is_reported():
    outcome = exported(pendulum(effort=2.0), actuators={"*": "position"})
    (weak,) = messages_of(outcome, "W-ACTUATOR-EFFORT")
    assert "arm_joint (5.89 of 2)" in weak
    strong = exported(pendulum(effort=6.0), actuators={"*": "position"})
    assert not messages_of(strong, "W-ACTUATOR-EFFORT")


def test_sag_is_reported_with_load_and_limit():
    outcome = exported(pendulum(effort=12.0), actuators={"*": {"type": "position", "kp": 100}})
    (far,) = messages_of(outcome, "W-ACTUATOR-SAG")
    assert "arm_joint by 0.059 rad (load 5.89, force limit 12, kp 100)" in far
    model = compiled(outcome)
    assert -targeted(model, 5.0).qpos[0] == pytest.approx(0.0589, rel=0.01)
    assert abs(at_home(model, 5.0).qpos[0]) < 1e-9
    stiff = exported(pendulum(), actuators={"*": {"type": "position", "kp": 300}})
    assert not messages_of(stiff, "W-ACTUATOR-SAG")
