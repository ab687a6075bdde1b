"""The key `actuators`: which dofs are driven, with what, and what the compiled model does with it."""

import json
import math

import mujoco
import numpy as np
import pytest

from linkwright.stages.export.actuators.actuate import actuate
from linkwright.stages.robot.errors import ExportError
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Limits, Relation
from tests.support.building import plan_of, robot_of, sample_robot
from tests.support.exports import compiled, exported, messages_of
from tests.support.kit import four_bar
from tests.support.pendulums import (
    ACROSS,
    ARM,
    GRAVITY,
    MASS,
    actuation,
    at_home,
    both,
    driven_model,
    lump,
    pendulum,
    problem,
    targeted,
)
from tests.support.robots import at, joint, robot_with
from tests.support.states import run


def pair():
    """Two turns of which the second follows the first."""
    joints = [
        joint("revolute", "base", name, [0.0], place=at(x, 0, 0)) for name, x in (("a", 0.0), ("b", 0.2))
    ]
    return robot_with(joints, relations=[Relation("gear", "b_joint", "a_joint", -2.0, 0.0)])


def driven_dofs(robot, **actuators):
    return [actuator.dof for actuator in actuation(robot, **actuators).actuators]


def test_load_is_the_weight_over_the_range():
    (servo,) = actuation(pendulum(saved=0.8), **{"*": "position"}).actuators
    weight = MASS * GRAVITY * ARM
    assert servo.home_load == pytest.approx(weight * math.cos(0.8), rel=1e-9)
    assert servo.home_load < servo.load <= weight
    assert servo.load == pytest.approx(weight, rel=0.01)
    assert servo.kp >= 1.9 * weight / 0.01
    assert servo.sag == pytest.approx(servo.home_load / servo.kp)
    assert servo.estimated == ("kp", "kv")


def two_arms(heavier=0.0):
    """A left and a right arm of two turns each, mirror images of each other but for what the right hand has
    more; masses are at ends of links."""
    rows, masses = [], {}
    for side, y, sign, mass in (("left", 0.1, 1, 0.5), ("right", -0.1, -1, 0.5 + heavier)):
        shoulder, elbow, upper, lower = (f"{side}_{part}" for part in ("shoulder", "elbow", "upper", "lower"))
        ranges = {shoulder: (-1.2 * sign, 0.4 * sign), elbow: (0.1 * sign, 2.0 * sign)}
        limits = {name: Limits(*sorted(ends)) for name, ends in ranges.items()}
        place = {"name": shoulder, "place": at(0, y, 0) @ ACROSS, "limits": limits}
        rows.append(joint("revolute", "base", upper, [0.0], **place))
        place = {"name": elbow, "place": at(0.3, 0, 0), "limits": limits}
        rows.append(joint("revolute", upper, lower, [0.2 * sign], **place))
        masses |= {upper: lump(1.0, 0.3, 0, 0), lower: lump(mass, 0.3, 0, 0)}
    return robot_with(rows, inertials=masses)


def test_copies_of_a_joint_share_estimates_and_others_do_not():
    drive, uneven = (actuation(two_arms(heavier), **{"*": "position"}) for heavier in (0.0, 0.2))
    kp = {actuator.name: actuator.kp for actuator in drive.actuators}
    armatures = {armature.dof: armature.value for armature in drive.armatures}
    for values in (kp, armatures):
        assert values["left_shoulder"] == values["right_shoulder"] != values["left_elbow"]
        assert values["left_elbow"] == values["right_elbow"]
    kp = {actuator.name: actuator.kp for actuator in uneven.actuators}
    assert kp["left_elbow"] < kp["right_elbow"]


@pytest.mark.parametrize(("entry", "effort", "force"), [
    ("position", 2.0, 2.0),
    ("position", 40.0, 40.0),
    ({"type": "position", "gear": -5}, 40.0, 40.0),
    ({"type": "position", "gear": 5, "forcerange": [-3, 1]}, 40.0, 15.0),
    ({"type": "intvelocity", "forcerange": [-6, 6]}, None, 6.0),
])  # fmt: skip
def test_servo_reaches_its_effort_at_a_tenth_of_a_radian(entry, effort, force):
    """The force of the compiled servo, as it is limited, for errors up to 0.1 rad: never the whole before."""
    robot = pendulum() if effort is None else pendulum(effort=effort)
    (servo,) = actuation(robot, **{"*": entry}).actuators
    assert servo.kp * servo.gear**2 * 0.1 == pytest.approx(force, rel=0.005)
    (plain,) = actuation(pendulum(), **{"*": "position"}).actuators
    assert plain.kp > servo.kp * servo.gear**2
    lift, _ = actuation(both(effort=30.0), **{"*": "position"}).actuators
    assert lift.kp == pytest.approx(30.0 / 0.01)


def test_sag_in_a_simulation_is_within_its_bounds():
    robot = both()
    model = driven_model(robot, "position")
    data = targeted(model, 5.0)
    slide, turn = (data.joint(name).qpos[0] for name in ("lift", "arm_joint"))
    assert 1e-5 < 0.1 - slide < 1e-3
    assert 1e-3 < -turn < 1e-2
    sags = {actuator.name: actuator.sag for actuator in actuation(robot, **{"*": "position"}).actuators}
    assert 0.1 - slide == pytest.approx(sags["lift"], rel=1e-3)
    assert -turn == pytest.approx(sags["arm_joint"], rel=1e-2)
    lift, arm = model.actuator("lift").gainprm[0], model.actuator("arm_joint").gainprm[0]
    assert lift != arm


def test_armature_of_a_driven_dof_is_estimated_or_given():
    outcome = exported(both(), actuators={"*": "position"})
    added = {armature.dof: armature.value for armature in outcome.written.actuation.armatures}
    model = compiled(outcome)
    for name in ("lift", "arm_joint"):
        assert model.joint(name).damping[0] == 0
        assert model.dof_armature[model.joint(name).dofadr[0]] == pytest.approx(added[name])
        stiff = model.actuator(name).gainprm[0]
        assert math.sqrt(stiff / added[name]) * model.opt.timestep == pytest.approx(0.4, rel=0.05)
    (remark,) = messages_of(outcome, "I-ARMATURE")
    assert f"arm_joint ({added['arm_joint']:g}), lift" in remark
    table = json.loads(outcome.files["robot.json"])
    assert [dof["estimated"] for entry in table["joints"] for dof in entry["dofs"]] == [["armature"]] * 2
    kept = exported(both(armature=0.02), actuators={"*": "motor"})
    assert kept.written.actuation.armatures == ()
    assert not messages_of(kept, "I-ARMATURE")


def test_armature_of_a_servo_with_followers_is_larger():
    """A step of the control over the whole range: by how much the follower of a gear lags."""
    limits = {name: Limits(-0.5, 0.5) for name in ("a_joint", "b_joint")}
    joints = [
        joint("revolute", "base", name, [0.0], place=at(x, 0, 0), limits=limits)
        for name, x in (("a", 0.0), ("b", 0.2))
    ]
    inertials = dict.fromkeys(("a", "b"), lump(0.02, 0.0, 0.0, 0.0))
    relation = Relation("gear", "b_joint", "a_joint", -1.0, 0.0)
    robot = robot_with(joints, relations=[relation], inertials=inertials)
    (armature,) = actuation(robot, **{"*": "position"}).armatures

    def lag(model):
        data, worst = mujoco.MjData(model), 0.0
        data.ctrl[0] = 0.3
        for _ in range(200):
            mujoco.mj_step(model, data)
            worst = max(worst, abs(data.qpos[0] + data.qpos[1]))
        return worst

    model, light = (driven_model(robot, "position") for _ in range(2))
    assert math.sqrt(model.actuator_gainprm[0][0] / armature.value) * 0.002 == pytest.approx(0.2, rel=0.05)
    light.dof_armature[0] = armature.value / 4
    mujoco.mj_setConst(light, mujoco.MjData(light))
    assert lag(model) < 0.7 * lag(light)


def test_robot_json_has_the_load_and_estimates_of_actuators():
    table = json.loads(
        exported(pendulum(), actuators={"*": {"type": "position", "kv": 3}}).files["robot.json"]
    )
    (servo,) = table["actuators"]
    assert (servo["estimated"], servo["kv"], servo["control"]) == (["kp"], 3, [-1, 1])
    assert servo["home_load"] == pytest.approx(MASS * GRAVITY * ARM, rel=1e-5)
    assert "actuators" not in json.loads(exported(pendulum()).files["robot.json"])


@pytest.mark.parametrize(
    ("kind", "ends"), [("position", (1, 10)), ("velocity", (3, 30)), ("motor", (12, 1.2))]
)
def test_ranges_are_in_the_units_of_the_actuator(kind, ends):
    robot = pendulum(effort=12.0, velocity=3.0)
    for gear, end in zip((1, -10 if kind == "position" else 10), ends, strict=True):
        model = driven_model(robot, {"type": kind, "gear": gear})
        assert list(model.actuator("arm_joint").ctrlrange) == [-end, end]
    assert (list(model.jnt_actfrcrange[0]), model.actuator_forcelimited[0]) == ([-12, 12], 0)
    free = robot_with([joint("revolute", "base", "arm", [0.0])])
    assert not driven_model(free, kind).actuator_ctrllimited[0]


@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0])
def test_damping_ratio_is_that_of_the_dof_at_home(ratio):
    entry = {"type": "position", "kp": 500, "dampratio": ratio}
    model = driven_model(pendulum(armature=0.02), entry)
    inertia = 0.02 + MASS * ARM**2 + MASS * 1e-4
    kv = -model.actuator("arm_joint").biasprm[2]
    assert kv == pytest.approx(2 * ratio * math.sqrt(500 * inertia), rel=5e-3)


@pytest.mark.parametrize("gear", [1.0, 20.0, -3.0])
def test_gear_keeps_the_stiffness_at_the_dof(gear):
    entry = {"type": "position", "gear": gear}
    model = driven_model(pendulum(saved=0.3), entry)
    plain = driven_model(pendulum(saved=0.3), "position")
    stiff = model.actuator("arm_joint").gainprm[0] * gear**2
    assert stiff == pytest.approx(plain.actuator("arm_joint").gainprm[0], rel=5e-3)
    assert at_home(model, 3.0).qpos[0] == pytest.approx(0.3, abs=0.01)


def test_velocity_servo_drifts_slowly_and_follows_its_speed():
    model = driven_model(pendulum(), "velocity")
    assert 0.01 < -at_home(model, 1.0).qpos[0] < 0.1
    data = at_home(model, 0.1)
    data.ctrl[0] = 0.5
    assert run(model, data, 1.0).qvel[0] == pytest.approx(0.5, abs=0.1)


def test_compensated_weight_makes_no_sag():
    model = compiled(exported(both(), actuators={"arm_joint": {"type": "position", "gravcomp": 1, "kp": 50}}))
    assert [model.body_gravcomp[model.body(name).id] for name in ("arm", "column")] == [1, 0]
    assert model.jnt_actgravcomp[model.joint("arm_joint").id]
    full = driven_model(pendulum(), {"type": "position", "gravcomp": 1, "kp": 50})
    half = driven_model(pendulum(), {"type": "position", "gravcomp": 0.5, "kp": 500})
    assert abs(at_home(full, 2.0).qpos[0]) < 1e-9
    assert abs(at_home(half, 3.0).qpos[0]) < 1e-9
    sag = -targeted(half, 3.0).qpos[0]
    assert sag == pytest.approx(0.5 * MASS * GRAVITY * ARM / 500, rel=0.01)


def test_compensated_links_keep_their_inertia():
    """Without a load, the natural frequency of 10 Hz decides on the stiffness."""
    drive = actuation(pendulum(), **{"*": {"type": "position", "gravcomp": 1}})
    (servo,) = drive.actuators
    inertia = MASS * (ARM**2 + 1e-4)
    assert servo.load == pytest.approx(0.0, abs=1e-12)
    assert servo.kp == pytest.approx(inertia * (2 * math.pi * 10) ** 2, rel=0.01)
    assert servo.kv == pytest.approx(2 * math.sqrt(servo.kp * (inertia + drive.armatures[0].value)), rel=0.01)


@pytest.mark.parametrize(("actuators", "driven"), [
    ({"*": "position"}, ["a_joint"]),
    ({"*": "position", "b_joint": {"kp": 5}}, ["b_joint"]),
    ({"a_joint": "position", "b_joint": "position"}, ["a_joint", "b_joint"]),
    ({"*": "position", "a_joint": "none"}, []),
])  # fmt: skip
def test_globs_leave_followers_out_and_names_drive_them(actuators, driven):
    assert driven_dofs(pair(), **actuators) == driven


def test_loop_is_driven_at_its_free_dofs_nearest_to_the_root(kit):
    four_bar(kit)
    robot = robot_of(kit.document)
    outcome = exported(robot, actuators={"*": "position"})
    assert robot.mobility.dof == 1
    (servo,) = outcome.written.actuation.actuators
    parents = {dof.name: joint.parent for joint in robot.joints for dof in joint.dofs}
    assert parents[servo.dof] == robot.root.name
    (remark,) = messages_of(outcome, "I-ACTUATOR")
    followers = sorted(name for name in parents if name != servo.dof)
    assert remark == f"in closed loops these are driven: {servo.dof}; these follow: {', '.join(followers)}"
    (other,) = actuation(robot, **{"*": "position", servo.dof: "none"}).actuators
    assert other.dof in followers


def test_servos_of_the_sample_are_those_of_a_person():
    driven = driven_dofs(sample_robot(), **{"*": "position"})
    names = "lift shoulder_yaw shoulder elbow wrist_pitch wrist_roll left_finger"
    assert driven == names.split()
    out = driven_dofs(sample_robot(), **{"*": "position", "shoulder": "none"})
    assert [name for name in out if name not in driven] == ["rod_lower_pivot"]


def test_later_entries_win_property_by_property():
    entries = {"*": {"type": "position", "kv": 9}, "arm*": {"kp": 80}, "arm_joint": {"kp": 90}}
    (servo,) = actuation(pendulum(), **entries).actuators
    assert (servo.kp, servo.kv, servo.estimated) == (90, 9, ())
    (motor,) = actuation(pendulum(), **entries, **{"arm_join?": "motor"}).actuators
    assert (motor.type, motor.kp, motor.kv) == ("motor", None, None)
    entries = {"*": {"type": "position", "kv": 9}, "arm*": {"dampratio": 1}}
    assert actuation(pendulum(), **entries).actuators[0].kv != 9


def test_dofs_of_a_cylinder_are_driven_and_a_ball_is_not():
    robot = robot_with([joint("ball", "base", "arm"), joint("cylindrical", "arm", "rod", name="rod")])
    assert driven_dofs(robot, **{"*": "motor"}) == ["rod_slide", "rod_turn"]


def test_all_problems_are_reported_at_once():
    with pytest.raises(ExportError) as error:
        exported(both(), actuators={"elbow": "motor", "wrist": "motor", "lift": {"kp": 1}})
    assert [problem.code for problem in error.value.problems] == ["E-ACTUATOR", "E-GLOB", "E-GLOB"]


def test_robot_without_a_dof_can_be_built_with_servos():
    robot = robot_with([joint("fixed", "base", "arm")])
    assert exported(robot, actuators={"*": "position"}).written.actuation == Actuation()


@pytest.mark.parametrize("fixed", [True, False])
def test_legs_of_a_free_robot_hold_the_rest_of_it(fixed):
    """One of two feet carries all the rest: 10 kg 0.3 m away, and at worst the other leg 0.4 m."""
    legs = [
        joint("revolute", "base", name, [0.0], place=at(0.3, y, 0) @ ACROSS)
        for name, y in (("left", 0.2), ("right", -0.2))
    ]
    inertials = {"base": lump(10.0, 0, 0, 0)} | {name: lump(0.5, 0, -0.4, 0) for name in ("left", "right")}
    for servo in actuation(robot_with(legs, fixed=fixed, inertials=inertials), **{"*": "position"}).actuators:
        if fixed:
            assert servo.load <= 0.5 * 0.4 * GRAVITY * 1.0001
        else:
            assert servo.load == pytest.approx((10.0 * 0.3 + 0.5 * 0.4) * GRAVITY, rel=0.01)


def test_actuate_scales_with_the_time_step():
    plan = plan_of(actuators={"*": "position"})
    armatures = {
        h: actuate(pendulum(), plan.actuators, h, np.eye(4))[0].armatures[0].value for h in (0.001, 0.002)
    }
    assert armatures[0.002] / armatures[0.001] == pytest.approx(4, rel=0.05)


@pytest.mark.parametrize("gravity", [[0, 0, -1.62], [3.0, 0, -5.0], [0, 0, 0]])
def test_weight_is_that_of_the_gravity_of_the_scene(gravity):
    """A pendulum out along x: τ = −m g_z l at home, by which its servo sags in MuJoCo."""
    option, load = {"gravity": gravity}, MASS * ARM * -gravity[2]
    outcome = exported(pendulum(), actuators={"*": "position"}, scene__option=option)
    (servo,) = outcome.written.actuation.actuators
    assert servo.home_load == pytest.approx(load, abs=1e-9)
    model = compiled(outcome)
    model.opt.gravity[:] = gravity
    sag = math.copysign(servo.sag or 0.0, load)
    assert targeted(model, 2.0).qpos[0] == pytest.approx(-sag, rel=0.02, abs=1e-9)
    assert at_home(model, 2.0).qpos[0] == pytest.approx(0.0, abs=1e-9)
    assert bool(exported(pendulum(), scene__option=option).advice) == bool(gravity[2])
    off = exported(pendulum(), actuators={"*": "position"}, scene__option={"flag": {"gravity": "disable"}})
    assert off.written.actuation.actuators[0].load == 0.0


def test_control_of_a_position_servo_takes_units():
    typed = {"lift": {"type": "position", "ctrlrange": ["0 mm", "150 mm"]}}
    typed["arm_joint"] = {"type": "position", "ctrlrange": ["-30 deg", 0.5]}
    model = compiled(exported(both(), actuators=typed))
    assert model.actuator("lift").ctrlrange == pytest.approx([0.0, 0.15])
    assert model.actuator("arm_joint").ctrlrange == pytest.approx([-math.pi / 6, 0.5])
    wrong = {"arm_joint": {"type": "position", "ctrlrange": ["-30 mm", 0.5]}}
    text = "ctrlrange of arm_joint: '-30 mm' is no angle, and arm_joint is a turn"
    assert problem(both(), **wrong) == ("E-ACTUATOR", text, "give it in rad, or as '-90 deg'")
    wrong = {"arm_joint": {"type": "position", "ctrlrange": ["-30 deg", "30 mm"]}}
    assert problem(both(), **wrong)[1] == text.replace("-30", "30")
    wrong = {"arm_joint": {"type": "motor", "ctrlrange": ["-30 deg", 0.5]}}
    assert problem(both(), **wrong)[1] == (
        "ctrlrange of arm_joint: '-30 deg' is an angle or a length, and the control of type motor is neither"
    )
