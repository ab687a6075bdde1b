"""Motors of the library: what they give dofs and actuators, in every format, and where it comes from."""

import json
import math
import xml.etree.ElementTree as ET
from dataclasses import replace

import mujoco
import pytest
import yaml

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.motor_files import OURS
from linkwright.stages.export import export
from linkwright.stages.graph.passes.limits.joint_limits import with_limits_and_dynamics
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import ExportError
from linkwright.stages.robot.model.robot import Limits
from tests.support.building import NO_MESHES, plan_of, write
from tests.support.exports import compiled, exported, failing, messages_of
from tests.support.pendulums import ACROSS, at_home, both, lump, pendulum, problem
from tests.support.reported import only
from tests.support.robots import joint, robot_with
from tests.support.states import run
from tests.unit.export.test_actuator_types import since

BENCH = "a bench, on paper"


def motor(**values):
    table = {
        key: {"value": value, "source": f"{BENCH}: {key}", "kind": "measured"}
        for key, value in values.items()
    }
    return {"title": "A motor", "values": table}


FULL = motor(
    armature=0.03, damping=0.2, back_emf=0.4, friction=0.05, effort=8, velocity=6, kp=40, kv=0.5,
    torque_constant=1.5, resistance=3, voltage=12,
)  # fmt: skip


def driven_by(content, robot=None, **entry):
    return exported(robot or pendulum(), motors={"own": content}, actuators={"*": {"motor": "own", **entry}})


def dof_of(outcome):
    return json.loads(outcome.files["robot.json"])["joints"][0]["dofs"][0]


def servo_of(outcome):
    (servo,) = json.loads(outcome.files["robot.json"])["actuators"]
    return servo


def test_values_of_a_motor_are_in_all_formats_with_sources():
    outcome = driven_by(FULL)
    model, record = compiled(outcome), dof_of(outcome)
    assert (model.dof_armature[0], model.dof_damping[0]) == (0.03, pytest.approx(0.6, rel=1e-12))
    assert (model.dof_frictionloss[0], list(model.jnt_actfrcrange[0])) == (0.05, [-8, 8])
    turn = ET.fromstring(outcome.files["robot.urdf"]).find("joint[@name='arm_joint']")
    limit, dynamics = turn.find("limit"), turn.find("dynamics")
    assert (limit.get("effort"), limit.get("velocity")) == ("8", "6")
    assert (dynamics.get("damping"), dynamics.get("friction")) == ("0.6", "0.05")
    source = f"motor own: {BENCH}: "
    named = ("armature", "friction", "effort", "velocity")
    assert record["provenance"] == {
        "lower": "source", "upper": "source",
        "damping": f"{source}damping (measured); {BENCH}: back_emf (measured)",
        **{name: f"{source}{name} (measured)" for name in named},
    }  # fmt: skip
    assert "estimated" not in record
    assert record["unset"] == []
    assert not {"I-ARMATURE", "I-MOTOR"} & {diagnostic.code for diagnostic in outcome.diagnostics}


def test_motor_is_a_servo_with_its_own_gains():
    outcome = driven_by(FULL)
    servo = servo_of(outcome)
    assert (servo["type"], servo["motor"], servo["kp"], servo["kv"]) == ("position", "own", 40, 0.5)
    assert servo["estimated"] == []
    assert servo["provenance"] == {key: f"motor own: {BENCH}: {key} (measured)" for key in ("kp", "kv")}
    assert list(compiled(outcome).actuator_biasprm[0][:3]) == [0, -40, -0.5]


def test_ranges_of_the_control_follow_from_what_the_motor_can():
    for kind, most in (("motor", 8), ("velocity", 6), ("intvelocity", 6)):
        assert list(compiled(driven_by(FULL, type=kind)).actuator_ctrlrange[0]) == [-most, most]


@since(3, 7)
def test_back_emf_of_a_dc_motor_counts_once():
    """The torque at a speed is the same, whether the joint's damping or the actuator resists it."""
    outcome = driven_by(FULL, type="dcmotor")
    model = compiled(outcome)
    assert list(model.actuator_gainprm[0][:2]) == [3, 1.5]
    assert (list(model.actuator_ctrlrange[0]), model.dof_damping[0]) == ([-12, 12], 0.2)
    data = mujoco.MjData(model)
    data.ctrl[0], data.qvel[0] = 12, 2.0
    mujoco.mj_forward(model, data)
    assert data.qfrc_actuator[0] == pytest.approx(1.5 * (12 - 1.5 * 2) / 3, rel=1e-12)


def test_configuration_wins_over_motor_over_source():
    robot = pendulum(damping=0.9, effort=100.0, armature=0.03)
    outcome = driven_by(FULL, robot)
    assert dof_of(outcome)["effort"] == 8
    (motor_info,) = messages_of(outcome, "I-MOTOR")
    assert "damping of arm_joint (0.9 → 0.6), effort of arm_joint (100 → 8)" in motor_info
    (swing,) = robot.joints
    (dof,) = swing.dofs
    weighted = replace(dof, given=("effort", "damping"))
    swung = replace(robot, joints=(replace(swing, dofs=(weighted,)),))
    outcome = driven_by(FULL, swung, kp=70)
    record = dof_of(outcome)
    assert (record["effort"], record["damping"], record["friction"]) == (100, 0.9, 0.05)
    assert (record["provenance"]["effort"], record["provenance"]["damping"]) == ("given", "given")
    servo = servo_of(outcome)
    assert servo["kp"] == 70
    # The motor's kv belongs to its kp.
    assert servo["estimated"] == ["kv"]


OF_THE_JOINT = {"armature": 0.03, "damping": 0.6, "friction": 0.05, "effort": 8.0, "velocity": 6.0}
"""Quantity of the joint → what the motor `FULL` makes it."""

PRECEDENCE = [
    # (joints, the motor's entry, whether the motor wins)
    ("arm_joint", "arm_joint", False),
    ("arm_joint", "*", False),
    ("arm*", "arm_joint", True),
    ("arm*", "*", False),
    ("*", "arm_join?", False),
]


@pytest.mark.parametrize("quantity", OF_THE_JOINT)
@pytest.mark.parametrize(("joints", "entry", "wins"), PRECEDENCE)
def test_more_specific_value_wins_and_losers_are_reported(joints, entry, wins, quantity):
    plan = plan_of(
        joints={joints: {quantity: 3.25}}, motors={"own": FULL}, actuators={entry: {"motor": "own"}}
    )
    robot = with_limits_and_dynamics(pendulum(), plan.joints, Diagnostics())
    outcome = export(robot, NO_MESHES, plan)
    record = dof_of(outcome)
    motors = OF_THE_JOINT | ({} if wins else {quantity: 3.25})
    assert {name: record[name] for name in OF_THE_JOINT} == pytest.approx(motors, rel=1e-12)
    assert (record["provenance"][quantity] == "given") == (not wins)
    (motor_info,) = (diagnostic for diagnostic in outcome.diagnostics if diagnostic.code == "I-MOTOR")
    value = f"{OF_THE_JOINT[quantity]:g}"
    if wins:
        assert f"`joints`: {quantity} of arm_joint (3.25 → {value})" in motor_info.message
        return
    assert motor_info.message == (
        f"the configuration overrides values of motors: {quantity} of arm_joint "
        f"({value}; `joints` gives 3.25)"
    )
    named = "or name the motor for the joint: actuators: {arm_joint: {motor: own}}"
    assert (named in motor_info.hint) == (entry != "arm_joint")


@pytest.mark.parametrize(("entries", "gains", "lost"), [
    ({"*": {"type": "position", "kp": 70, "kv": 3}, "arm_joint": {"motor": "own"}}, (40, 0.5), []),
    ({"arm_joint": {"motor": "own"}, "*": {"kp": 70, "dampratio": 2}}, (40, 0.5), []),
    ({"*": {"type": "position", "kv": 3}, "arm_join?": {"motor": "own"}}, (40, 3),
     ["kv of arm_joint (0.5; `actuators` gives kv)"]),
    ({"*": {"motor": "own"}, "arm_joint": {"kp": 70, "kv": 2}}, (70, 2),
     ["kp of arm_joint (40; `actuators` gives kp)", "kv of arm_joint (0.5; `actuators` gives kv)"]),
    ({"arm_joint": {"motor": "own", "kp": 70, "kv": 0.5}}, (70, 0.5),
     ["kp of arm_joint (40; `actuators` gives kp)"]),
    ({"arm_joint": {"motor": "own", "kp": 40, "kv": 0.5}}, (40, 0.5), []),
], ids=["glob before", "glob after", "both globs", "own entry", "with the motor", "the same"])  # fmt: skip
def test_gains_of_a_motor_win_over_globs_only(entries, gains, lost):
    outcome = exported(pendulum(), motors={"own": FULL}, actuators=entries)
    servo = servo_of(outcome)
    assert (servo["kp"], servo["kv"]) == gains
    messages = messages_of(outcome, "I-MOTOR")
    losing = "the configuration overrides values of motors: "
    assert messages == ([losing + ", ".join(lost)] if lost else [])


def test_motor_named_for_the_joint_drives_it():
    entries = {"arm_joint": {"motor": "own"}, "*": {"motor": "other"}}
    outcome = exported(pendulum(), motors={"own": FULL, "other": motor(kp=1, effort=1)}, actuators=entries)
    servo = servo_of(outcome)
    assert (servo["motor"], servo["kp"], dof_of(outcome)["effort"]) == ("own", 40, 8)


@since(3, 7)
def test_constants_of_a_named_motor_win_over_a_globs_nominal():
    entries = {"*": {"type": "dcmotor", "nominal": [24, 3, 9]}, "arm_joint": {"motor": "own"}}
    model = compiled(exported(pendulum(), motors={"own": FULL}, actuators=entries))
    assert list(model.actuator_gainprm[0][:2]) == [3, 1.5]
    assert list(model.actuator_ctrlrange[0]) == [-12, 12]
    outcome = exported(pendulum(), motors={"own": FULL}, actuators={"*": entries["*"] | {"motor": "own"}})
    (message,) = messages_of(outcome, "I-MOTOR")
    assert "resistance of arm_joint (3; `actuators` gives nominal)" in message
    assert "torque_constant of arm_joint (1.5; `actuators` gives nominal)" in message


def class_of(outcome, name):
    (node,) = ET.fromstring(outcome.files["robot.xml"]).findall(f".//worldbody//joint[@name='{name}']")
    return node.get("class")


@pytest.mark.parametrize(
    ("values", "name"), [({}, "own"), ({"effort": 5.0}, "hinge"), ({"effort": 8.0}, "own")]
)
def test_class_has_the_name_of_a_motor_only_with_its_values(values, name):
    plan = plan_of(
        joints={"arm_joint": values}, motors={"own": FULL}, actuators={"arm_joint": {"motor": "own"}}
    )
    outcome = export(with_limits_and_dynamics(pendulum(), plan.joints, Diagnostics()), NO_MESHES, plan)
    assert class_of(outcome, "arm_joint") == name


@pytest.mark.parametrize("gear", [3.0, -20.0])
def test_gear_between_motor_and_joint_keeps_power_and_energy(gear):
    """At the joint: torque · speed, ½ · armature · speed² and all losses are the motor's."""
    model, record = compiled(driven_by(FULL, gear=gear)), dof_of(driven_by(FULL, gear=gear))
    ratio, speed = abs(gear), 0.7
    assert record["effort"] * record["velocity"] == pytest.approx(8 * 6, rel=1e-12)
    assert record["effort"] == pytest.approx(8 * ratio)
    assert 0.5 * model.dof_armature[0] * speed**2 == pytest.approx(0.5 * 0.03 * (ratio * speed) ** 2)
    assert model.dof_damping[0] * speed**2 == pytest.approx(0.6 * (ratio * speed) ** 2)
    assert model.dof_frictionloss[0] * speed == pytest.approx(0.05 * ratio * speed)
    assert model.actuator_gainprm[0][0] * gear**2 == pytest.approx(40 * gear**2)


def test_rotor_counts_with_the_square_of_the_motors_own_gear():
    outcome = driven_by(motor(rotor_inertia=1.2e-5, gear=50))
    assert compiled(outcome).dof_armature[0] == pytest.approx(0.03, rel=1e-12)
    assert dof_of(outcome)["provenance"]["armature"] == (
        f"motor own: {BENCH}: rotor_inertia (measured); {BENCH}: gear (measured)"
    )


def test_motor_moves_a_slide_through_a_gear_alone():
    entries = {"lift": {"motor": "own"}}
    code, message, hint = problem_with(both(), entries)
    assert (code, message) == ("E-MOTOR", "the motor own turns, but lift slides")
    assert "actuators: {lift: {gear: ...}}" in hint
    outcome = exported(both(), motors={"own": FULL}, actuators={"lift": {"motor": "own", "gear": 100}})
    model = compiled(outcome)
    assert model.jnt_actfrcrange[model.joint("lift").id][1] == 800


def problem_with(robot, entries):
    with pytest.raises(ExportError) as error:
        exported(robot, motors={"own": FULL}, actuators=entries)
    (only,) = error.value.problems
    return only.code, only.message, only.hint


def test_undriven_joint_has_no_motor_and_another_type_keeps_it():
    entries = {"*": {"motor": "own", "gear": 10}, "arm_joint": "none"}
    outcome = exported(both(), motors={"own": FULL}, actuators=entries)
    first, second = json.loads(outcome.files["robot.json"])["joints"]
    assert first["dofs"][0]["effort"] == 80
    assert second["dofs"][0]["effort"] is None
    entries = {"*": {"motor": "own"}, "arm*": "velocity"}
    (only,) = exported(pendulum(), motors={"own": FULL}, actuators=entries).written.actuation.actuators
    assert (only.type, only.motor) == ("velocity", "own")


def test_effort_bounds_what_the_motor_does_to_the_joint():
    model = compiled(driven_by(FULL, type="motor", ctrlrange=[-50, 50]))
    data = mujoco.MjData(model)
    data.ctrl[0] = 50
    mujoco.mj_forward(model, data)
    assert data.qfrc_actuator[0] == 8


def test_motor_at_full_torque_runs_at_its_no_load_speed():
    """A servo far from its target: the speed at which friction and back-EMF take all of the stall torque."""
    content = yaml.safe_load((OURS / "sts3215.yaml").read_text(encoding="utf-8"))
    disc = joint("revolute", "base", "disc", [0.0])
    model = compiled(driven_by(content, robot_with([disc], inertials={"disc": lump(0.1, 0, 0, 0)})))
    data = mujoco.MjData(model)
    data.ctrl[0] = 1000.0
    speed = run(model, data, 3.0).qvel[0]
    assert speed == pytest.approx(content["values"]["velocity"]["value"], rel=1e-3)


def test_build_with_a_motor_passes_its_checks(tmp_path):
    plan = plan_of(actuators={"*": {"motor": "mx106"}})
    outcome = write(pendulum(), tmp_path, plan)
    assert failing(tmp_path, outcome, plan) == []
    assert abs(at_home(compiled(outcome), 2.0).qpos[0]) < 0.2


def test_type_none_takes_a_motor_out():
    assert not compiled(exported(pendulum(), actuators={"*": {"motor": "sts3215"}, "arm*": "none"})).nu


def test_motor_after_the_type_none_needs_a_type():
    entries = {"*": "none", "arm_joint": {"motor": "sts3215"}}
    code, message, hint = problem(pendulum(), **entries)
    assert (code, hint) == ("E-ACTUATOR", "give a type, too: position, motor, ...")
    assert message == "'arm_joint' gives a motor, but an earlier entry gives arm_joint the type none"
    entries["arm_joint"] = {"motor": "sts3215", "type": "position"}
    assert compiled(exported(pendulum(), actuators=entries)).nu == 1


@pytest.mark.parametrize("first", [{"kp": 7, "gear": 3}, {"motor": "sts3215", "kp": 7, "gear": 3}])
def test_type_that_an_entry_repeats_or_adds_keeps_parameters(first):
    entries = {"*": first, "arm_joint": "position"}
    (servo,) = exported(pendulum(), actuators=entries).written.actuation.actuators
    assert (servo.kp, servo.gear) == (7, 3)


@since(3, 7)
def test_dc_motor_whose_constants_nobody_knows_is_told():
    entries = {"*": {"type": "dcmotor", "motor": "erob80_100"}}
    code, message, _ = problem(pendulum(), **entries)
    assert code == "E-ACTUATOR"
    assert "type dcmotor needs the constants of its motor" in message
    assert exported(pendulum(), actuators={"*": {**entries["*"], "resistance": 2}}).written.actuation


def test_plan_of_a_motor_has_its_content():
    tree = {"source": {"kind": "sample"}, "actuators": {"*": {"motor": "sts3215"}}}
    plan = Plan.parse(tree)
    assert (plan.motors["sts3215"].values["armature"].value, Plan.parse(plan.tree())) == (0.0284, plan)


def test_joints_of_a_robots_file_win_over_its_motors():
    joints = {"arm_joint": {"rotor_inertia": 1e-5, "gear": 50, "effort": 12}}
    plan = plan_of(joints=joints, actuators={"arm_joint": {"motor": "mx106"}})
    dof = dof_of(export(with_limits_and_dynamics(pendulum(), plan.joints, Diagnostics()), NO_MESHES, plan))
    assert (dof["armature"], dof["effort"], dof["velocity"]) == (pytest.approx(0.025), 12, 5.096)
    assert (dof["provenance"]["armature"], dof["provenance"]["effort"]) == ("given", "given")
    assert dof["provenance"]["velocity"].startswith("motor mx106: ")


def test_control_of_a_motor_on_a_slide_is_its_turn():
    entry = {
        "motor": "own", "gear": 100, "type": "position", "ctrlrange": ["0 deg", "90 deg"], "encoder": True,
    }  # fmt: skip
    outcome = exported(both(), motors={"own": FULL}, actuators={"lift": entry})
    assert compiled(outcome).actuator("lift").ctrlrange == pytest.approx([0, math.pi / 2])
    order = json.loads(outcome.files["robot.json"])["order"]["mjcf"]
    (control,) = order["actuators"]
    assert control["unit"] == "rad"
    assert [sensor["unit"] for sensor in order["sensors"]] == ["rad", "rad/s"]
    message = problem_with(both(), {"lift": entry | {"ctrlrange": [0, "90 mm"]}})[1]
    assert message == "ctrlrange of lift: '90 mm' is no angle, and the motor own turns"


@pytest.mark.parametrize(("entries", "hint"), [
    ({"*": {"motor": "own"}}, "these motors sag with their own kp: give another kp, or gravcomp"),
    ({"a_joint": {"type": "position", "kp": 1}, "arm_joint": {"motor": "own"}},
     "raise kp; some of these kp are the motors' own: give another kp, or gravcomp"),
    ({"*": {"type": "position", "kp": 1}}, "raise kp, or leave it out: it is estimated then"),
], ids=["motors", "both", "none"])  # fmt: skip
def test_hint_of_a_sag_knows_whose_kp_it_is(entries, hint):
    limits = {"a_joint": Limits(-1.0, 1.0), "arm_joint": Limits(-1.0, 1.0)}
    swings = [joint("revolute", "base", name, [0.0], place=ACROSS, limits=limits) for name in ("a", "arm")]
    robot = robot_with(swings, inertials=dict.fromkeys(("a", "arm"), lump(5.0, 0.3, 0, 0)))
    outcome = exported(robot, motors={"own": motor(kp=2, kv=0.1, effort=50)}, actuators=entries)
    assert only(outcome, "W-ACTUATOR-SAG").hint == hint
