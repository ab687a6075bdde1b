"""Motors of the library: what they give dofs and actuators, in every format, and where it comes from."""

import json
import math
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import yaml

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.motor_files import OURS, library
from linkwright.stages.export import Exported, export
from linkwright.stages.export.configuration.motor_section import QUANTITIES, MotorSection
from linkwright.stages.graph.passes.limits.joint_limits import with_properties
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Limits, Robot
from linkwright.stages.validate import validate
from tests.fake_onshape.sample import sample_document
from tests.support.building import NO_MESHES, plan_of, robot_of, write
from tests.support.places import SHARED
from tests.support.robots import joint, robot_with
from tests.unit.export.test_actuator_types import since
from tests.unit.export.test_actuators import (
    ACROSS,
    at_home,
    both,
    compiled,
    exported,
    lump,
    pendulum,
    problem,
)

BENCH = "a bench, on paper"


def motor(**values: float) -> dict[str, Any]:
    table = {
        name: {"value": one, "source": f"{BENCH}: {name}", "kind": "measured"} for name, one in values.items()
    }
    return {"title": "A motor", "values": table}


def effort(**value: Any) -> dict[str, Any]:
    return {"title": "x", "values": {"effort": value}}


FULL = motor(
    armature=0.03, damping=0.2, back_emf=0.4, friction=0.05, effort=8, velocity=6, kp=40, kv=0.5,
    torque_constant=1.5, resistance=3, voltage=12,
)  # fmt: skip


def driven_by(content: dict[str, Any], robot: Robot | None = None, **entry: Any) -> Exported:
    return exported(robot or pendulum(), motors={"own": content}, actuators={"*": {"motor": "own", **entry}})


def model_of(found: Exported) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(found.files["robot.xml"].decode())


def dof_of(found: Exported) -> dict[str, Any]:
    record: dict[str, Any] = json.loads(found.files["robot.json"])["joints"][0]["dofs"][0]
    return record


def test_a_motor_gives_its_values_to_the_joint_of_every_format_and_tells_where_they_are_from() -> None:
    found = driven_by(FULL)
    model, record = model_of(found), dof_of(found)
    assert model.dof_armature[0] == 0.03
    assert model.dof_damping[0] == pytest.approx(0.6, rel=1e-12)
    assert model.dof_frictionloss[0] == 0.05
    assert list(model.jnt_actfrcrange[0]) == [-8, 8]
    turn = ET.fromstring(found.files["robot.urdf"]).find("joint[@name='arm_joint']")
    assert turn is not None
    limit, dynamics = turn.find("limit"), turn.find("dynamics")
    assert limit is not None
    assert dynamics is not None
    assert (limit.get("effort"), limit.get("velocity")) == ("8", "6")
    assert (dynamics.get("damping"), dynamics.get("friction")) == ("0.6", "0.05")
    told = f"motor own: {BENCH}: "
    assert record["provenance"] == {
        "lower": "source",
        "upper": "source",
        "armature": f"{told}armature (measured)",
        "damping": f"{told}damping (measured); {BENCH}: back_emf (measured)",
        "friction": f"{told}friction (measured)",
        "effort": f"{told}effort (measured)",
        "velocity": f"{told}velocity (measured)",
    }
    assert "estimated" not in record
    assert record["unset"] == []
    assert not [one for one in found.diagnostics if one.code in ("I-ARMATURE", "I-MOTOR")]


def test_a_motor_is_the_servo_that_it_says_with_its_own_gains() -> None:
    found = driven_by(FULL)
    (servo,) = json.loads(found.files["robot.json"])["actuators"]
    assert (servo["type"], servo["motor"], servo["kp"], servo["kv"]) == ("position", "own", 40, 0.5)
    assert servo["estimated"] == []
    assert servo["provenance"] == {
        "kp": f"motor own: {BENCH}: kp (measured)",
        "kv": f"motor own: {BENCH}: kv (measured)",
    }
    assert list(model_of(found).actuator_biasprm[0][:3]) == [0, -40, -0.5]


def test_ranges_of_the_control_follow_from_what_the_motor_can() -> None:
    for kind, most in (("motor", 8), ("velocity", 6), ("intvelocity", 6)):
        assert list(model_of(driven_by(FULL, type=kind)).actuator_ctrlrange[0]) == [-most, most]


@since(3, 7)
def test_a_dc_motor_has_the_constants_of_the_motor_and_its_back_emf_but_once() -> None:
    """The torque at a speed is the same, whether the joint's damping or the actuator resists it."""
    found = driven_by(FULL, type="dcmotor")
    model = model_of(found)
    assert list(model.actuator_gainprm[0][:2]) == [3, 1.5]
    assert list(model.actuator_ctrlrange[0]) == [-12, 12]
    assert model.dof_damping[0] == 0.2
    data = mujoco.MjData(model)
    data.ctrl[0], data.qvel[0] = 12, 2.0
    mujoco.mj_forward(model, data)
    assert data.qfrc_actuator[0] == pytest.approx(1.5 * (12 - 1.5 * 2) / 3, rel=1e-12)


def test_the_configuration_wins_over_the_motor_and_the_motor_over_the_source() -> None:
    robot = pendulum(damping=0.9, effort=100.0, armature=0.03)
    found = driven_by(FULL, robot)
    assert dof_of(found)["effort"] == 8
    (told,) = (one for one in found.diagnostics if one.code == "I-MOTOR")
    assert "damping of arm_joint (0.9 → 0.6), effort of arm_joint (100 → 8)" in told.message
    (swing,) = robot.joints
    (dof,) = swing.dofs
    mine = replace(dof, given=("effort", "damping"))
    given = replace(robot, joints=(replace(swing, dofs=(mine,)),))
    found = driven_by(FULL, given, kp=70)
    record = dof_of(found)
    assert (record["effort"], record["damping"], record["friction"]) == (100, 0.9, 0.05)
    assert (record["provenance"]["effort"], record["provenance"]["damping"]) == ("given", "given")
    (servo,) = json.loads(found.files["robot.json"])["actuators"]
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
def test_what_is_more_specific_wins_and_each_value_that_loses_is_reported(
    joints: str, entry: str, wins: bool, quantity: str
) -> None:
    plan = plan_of(
        joints={joints: {quantity: 3.25}}, motors={"own": FULL}, actuators={entry: {"motor": "own"}}
    )
    robot = with_properties(pendulum(), plan.joints, Diagnostics())
    found = export(robot, NO_MESHES, plan)
    record = dof_of(found)
    motors = OF_THE_JOINT | ({} if wins else {quantity: 3.25})
    assert {name: record[name] for name in OF_THE_JOINT} == pytest.approx(motors, rel=1e-12)
    assert (record["provenance"][quantity] == "given") == (not wins)
    (told,) = (one for one in found.diagnostics if one.code == "I-MOTOR")
    value = f"{OF_THE_JOINT[quantity]:g}"
    if wins:
        assert f"says: {quantity} of arm_joint (3.25 → {value})" in told.message
        return
    assert told.message == (
        f"values of motors that lose to the configuration: {quantity} of arm_joint "
        f"({value}; `joints` gives 3.25)"
    )
    named = "or name the motor for the joint: actuators: {arm_joint: {motor: own}}"
    assert (named in told.hint) == (entry != "arm_joint")


@pytest.mark.parametrize(
    ("entries", "gains", "lost"),
    [
        ({"*": {"type": "position", "kp": 70, "kv": 3}, "arm_joint": {"motor": "own"}}, (40, 0.5), []),
        ({"arm_joint": {"motor": "own"}, "*": {"kp": 70, "dampratio": 2}}, (40, 0.5), []),
        (
            {"*": {"type": "position", "kv": 3}, "arm_join?": {"motor": "own"}},
            (40, 3),
            ["kv of arm_joint (0.5; `actuators` gives kv)"],
        ),
        (
            {"*": {"motor": "own"}, "arm_joint": {"kp": 70, "kv": 2}},
            (70, 2),
            ["kp of arm_joint (40; `actuators` gives kp)", "kv of arm_joint (0.5; `actuators` gives kv)"],
        ),
        (
            {"arm_joint": {"motor": "own", "kp": 70, "kv": 0.5}},
            (70, 0.5),
            ["kp of arm_joint (40; `actuators` gives kp)"],
        ),
        ({"arm_joint": {"motor": "own", "kp": 40, "kv": 0.5}}, (40, 0.5), []),
    ],
    ids=["a glob before", "a glob after", "both globs", "its own entry", "with the motor", "the same"],
)
def test_a_motors_own_gains_win_over_globs_and_lose_to_the_joints_entry(
    entries: dict[str, Any], gains: tuple[float, float], lost: list[str]
) -> None:
    found = exported(pendulum(), motors={"own": FULL}, actuators=entries)
    (servo,) = json.loads(found.files["robot.json"])["actuators"]
    assert (servo["kp"], servo["kv"]) == gains
    told = [one.message for one in found.diagnostics if one.code == "I-MOTOR"]
    losing = "values of motors that lose to the configuration: "
    assert told == ([losing + ", ".join(lost)] if lost else [])


def test_of_two_motors_that_which_is_named_for_the_joint_drives_it() -> None:
    entries = {"arm_joint": {"motor": "own"}, "*": {"motor": "other"}}
    found = exported(pendulum(), motors={"own": FULL, "other": motor(kp=1, effort=1)}, actuators=entries)
    (servo,) = json.loads(found.files["robot.json"])["actuators"]
    assert (servo["motor"], servo["kp"], dof_of(found)["effort"]) == ("own", 40, 8)


@since(3, 7)
def test_the_constants_of_a_named_motor_win_over_a_globs_nominal() -> None:
    entries = {"*": {"type": "dcmotor", "nominal": [24, 3, 9]}, "arm_joint": {"motor": "own"}}
    model = model_of(exported(pendulum(), motors={"own": FULL}, actuators=entries))
    assert list(model.actuator_gainprm[0][:2]) == [3, 1.5]
    assert list(model.actuator_ctrlrange[0]) == [-12, 12]
    found = exported(pendulum(), motors={"own": FULL}, actuators={"*": entries["*"] | {"motor": "own"}})
    (told,) = (one.message for one in found.diagnostics if one.code == "I-MOTOR")
    assert "resistance of arm_joint (3; `actuators` gives nominal)" in told
    assert "torque_constant of arm_joint (1.5; `actuators` gives nominal)" in told


def test_the_motor_of_one_joint_of_the_sample_has_all_its_values_and_the_class_that_has_its_name() -> None:
    """The sample's own `joints: "*"` gives damping, friction, armature, effort and velocity to all joints."""
    every = {"damping": 0.1, "friction": 0.02, "armature": 0.01, "effort": 20, "velocity": 3}
    plan = plan_of(joints={"*": every}, actuators={"*": "position", "elbow": {"motor": "sts3215"}})
    found = export(robot_of(sample_document(), plan), NO_MESHES, plan)
    values = {name: one.value for name, one in plan.motors["sts3215"].values.items()}
    model = model_of(found)
    elbow, servo = model.joint("elbow"), model.actuator("elbow")
    resistance = values["damping"] + values["back_emf"]
    assert elbow.damping[0] == pytest.approx(resistance, rel=1e-12)
    assert (elbow.frictionloss[0], elbow.armature[0]) == (values["friction"], values["armature"])
    assert list(model.jnt_actfrcrange[elbow.id]) == [-values["effort"], values["effort"]]
    assert list(servo.biasprm[1:3]) == [-values["kp"], -values["kv"]]
    shoulder = model.joint("shoulder")
    assert (shoulder.damping[0], shoulder.armature[0]) == (0.1, 0.01)
    assert class_of(found, "elbow") == "sts3215"


def class_of(found: Exported, name: str) -> str | None:
    root = ET.fromstring(found.files["robot.xml"])
    (own,) = root.findall(f".//worldbody//joint[@name='{name}']")
    return own.get("class")


@pytest.mark.parametrize(
    ("values", "name"), [({}, "own"), ({"effort": 5.0}, "hinge"), ({"effort": 8.0}, "own")]
)
def test_a_class_has_the_name_of_a_motor_only_with_its_values(values: dict[str, float], name: str) -> None:
    plan = plan_of(
        joints={"arm_joint": values}, motors={"own": FULL}, actuators={"arm_joint": {"motor": "own"}}
    )
    found = export(with_properties(pendulum(), plan.joints, Diagnostics()), NO_MESHES, plan)
    assert class_of(found, "arm_joint") == name


@pytest.mark.parametrize("gear", [3.0, -20.0])
def test_a_gear_between_motor_and_joint_keeps_power_and_energy(gear: float) -> None:
    """At the joint: torque · speed, ½ · armature · speed² and all losses are the motor's."""
    model, record = model_of(driven_by(FULL, gear=gear)), dof_of(driven_by(FULL, gear=gear))
    ratio, speed = abs(gear), 0.7
    assert record["effort"] * record["velocity"] == pytest.approx(8 * 6, rel=1e-12)
    assert record["effort"] == pytest.approx(8 * ratio)
    assert 0.5 * model.dof_armature[0] * speed**2 == pytest.approx(0.5 * 0.03 * (ratio * speed) ** 2)
    assert model.dof_damping[0] * speed**2 == pytest.approx(0.6 * (ratio * speed) ** 2)
    assert model.dof_frictionloss[0] * speed == pytest.approx(0.05 * ratio * speed)
    assert model.actuator_gainprm[0][0] * gear**2 == pytest.approx(40 * gear**2)


def test_a_rotor_counts_with_the_square_of_the_motors_own_gear() -> None:
    found = driven_by(motor(rotor_inertia=1.2e-5, gear=50))
    assert model_of(found).dof_armature[0] == pytest.approx(0.03, rel=1e-12)
    assert dof_of(found)["provenance"]["armature"] == (
        f"motor own: {BENCH}: rotor_inertia (measured); {BENCH}: gear (measured)"
    )


def test_a_motor_moves_a_slide_through_a_gear_alone() -> None:
    entries = {"lift": {"motor": "own"}}
    code, message, hint = problem_with(both(), entries)
    assert (code, message) == ("E-MOTOR", "the motor own turns, and lift slides")
    assert "actuators: {lift: {gear: ...}}" in hint
    found = exported(both(), motors={"own": FULL}, actuators={"lift": {"motor": "own", "gear": 100}})
    model = model_of(found)
    assert model.jnt_actfrcrange[model.joint("lift").id][1] == 800


def problem_with(robot: Robot, entries: dict[str, Any]) -> tuple[str, str, str]:
    from linkwright.stages.robot.errors import ExportError

    with pytest.raises(ExportError) as error:
        exported(robot, motors={"own": FULL}, actuators=entries)
    (only,) = error.value.problems
    return only.code, only.message, only.hint


def test_what_is_not_driven_has_no_motor_and_another_type_keeps_it() -> None:
    entries = {"*": {"motor": "own", "gear": 10}, "arm_joint": "none"}
    found = exported(both(), motors={"own": FULL}, actuators=entries)
    first, second = json.loads(found.files["robot.json"])["joints"]
    assert first["dofs"][0]["effort"] == 80
    assert second["dofs"][0]["effort"] is None
    entries = {"*": {"motor": "own"}, "arm*": "velocity"}
    (only,) = exported(pendulum(), motors={"own": FULL}, actuators=entries).written.actuation.actuators  # type: ignore[union-attr]
    assert (only.type, only.motor) == ("velocity", "own")


def test_the_effort_bounds_what_the_motor_does_to_the_joint() -> None:
    model = model_of(driven_by(FULL, type="motor", ctrlrange=[-50, 50]))
    data = mujoco.MjData(model)
    data.ctrl[0] = 50
    mujoco.mj_forward(model, data)
    assert data.qfrc_actuator[0] == 8


def test_a_motor_at_full_torque_runs_at_its_no_load_speed() -> None:
    """A servo far from its target: the speed at which friction and back-EMF take all of the stall torque."""
    content = yaml.safe_load((OURS / "sts3215.yaml").read_text(encoding="utf-8"))
    swing = joint("revolute", "base", "disc", [0.0], limits={})
    robot = robot_with([swing], inertials={"disc": lump(0.1, 0, 0, 0)})
    model = model_of(driven_by(content, robot))
    data = mujoco.MjData(model)
    data.ctrl[0] = 1000.0
    for _ in range(1500):
        mujoco.mj_step(model, data)
    assert data.qvel[0] == pytest.approx(content["values"]["velocity"]["value"], rel=1e-3)


def test_a_build_with_a_motor_passes_its_checks(tmp_path: Path) -> None:
    plan = plan_of(actuators={"*": {"motor": "mx106"}})
    robot = pendulum()
    found = write(robot, tmp_path, plan)
    assert [one.name for one in validate(tmp_path, found.written, plan) if one.fails] == []
    assert abs(at_home(mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml")), 2.0).qpos[0]) < 0.2


@pytest.mark.parametrize("name", library())
def test_every_motor_of_ours_has_plausible_values_each_with_its_source(name: str) -> None:
    content = yaml.safe_load(library()[name].read_text(encoding="utf-8"))
    values = MotorSection.model_validate(content).values
    assert set(values) <= set(QUANTITIES)
    assert {"armature", "damping", "friction", "effort"} <= set(values)
    assert all("://" in one.source or "github.com/" in one.source for one in values.values())
    assert content["notes"]
    found = {key: one.value for key, one in values.items()}
    assert 1e-4 < found["armature"] < 2
    assert found["friction"] < 0.2 * found["effort"]
    assert 0.05 < found["effort"] < 300
    if "velocity" in found:
        assert 1 < found["velocity"] < 60
        # Never faster than where back-EMF alone takes the whole voltage.
        assert found["velocity"] < found["voltage"] / found["torque_constant"]
    if "back_emf" in found:
        assert found["back_emf"] == pytest.approx(
            found["torque_constant"] ** 2 / found["resistance"], rel=1e-3
        )
        stall = found["voltage"] * found["torque_constant"] / found["resistance"]
        assert 0.95 * stall < found["effort"] < 1.001 * stall
        at_speed = (found["damping"] + found["back_emf"]) * found["velocity"] + found["friction"]
        assert at_speed == pytest.approx(found["effort"], rel=1e-3)
    if "kp" in found:
        # The whole torque at an error between a degree and a full turn.
        assert 0.017 < found["effort"] / found["kp"] < 6.3


SHEETS = {"mx64": (6.0, 63), "mx106": (8.4, 45), "xl330_m288": (0.52, 103)}
"""Motor → stall torque [N m] and no-load speed [rev/min] in the ROBOTIS e-Manual, at the same voltage."""


@pytest.mark.parametrize("name", SHEETS)
def test_what_was_identified_is_near_the_datasheet(name: str) -> None:
    values = MotorSection.model_validate(yaml.safe_load(library()[name].read_text(encoding="utf-8"))).values
    torque, speed = SHEETS[name]
    assert values["effort"].value == pytest.approx(torque, rel=0.25)
    assert values["velocity"].value == pytest.approx(speed * 2 * np.pi / 60, rel=0.1)


def test_our_sts3215_is_that_of_the_so101() -> None:
    """Its MJCF has the same motor with the back-EMF in the joint's damping, to fewer digits."""
    file = SHARED / "data/robots/so101/Simulation/SO101/joints_properties.xml"
    if not file.exists():
        pytest.skip("there are no shared data")
    theirs = ET.parse(file).find("default[@class='sts3215']")
    assert theirs is not None
    turn, servo = theirs.find("joint"), theirs.find("position")
    assert turn is not None
    assert servo is not None
    found = model_of(exported(pendulum(), actuators={"*": {"motor": "sts3215"}}))
    assert found.dof_armature[0] == pytest.approx(float(turn.get("armature", "")), rel=0.02)
    assert found.dof_damping[0] == pytest.approx(float(turn.get("damping", "")), rel=0.02)
    assert found.dof_frictionloss[0] == pytest.approx(float(turn.get("frictionloss", "")), rel=0.02)
    assert found.actuator_gainprm[0][0] == pytest.approx(float(servo.get("kp", "")), rel=0.01)
    assert found.jnt_actfrcrange[0][1] == pytest.approx(
        float(servo.get("forcerange", "").split()[1]), rel=0.01
    )


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ({"values": {}}, "motors.own.title: missing"),
        (motor(torque=3), "torque is no quantity of a motor: there are gear"),
        (motor(armatur=3), "armatur is no quantity of a motor: did you mean armature?"),
        (motor(effort=0), "effort must be above 0"),
        (motor(effort=-1), "greater than or equal to 0"),
        (motor(armature=1, rotor_inertia=1, gear=2), "give one"),
        (motor(rotor_inertia=1), "rotor_inertia needs the gear"),
        (
            {"title": "x", "values": {"effort": {"value": 3, "kind": "measured"}}},
            "values.effort.source: missing",
        ),
        (
            {"title": "x", "values": {"effort": {"value": 3, "source": "", "kind": "measured"}}},
            "not be empty",
        ),
        ({"title": "x", "values": {"effort": {"value": 3, "source": "me", "kind": "guess"}}}, "datasheet"),
        ({"title": "x", "values": {"effort": 3}}, "must be a mapping"),
        ({**motor(effort=1), "type": "dcmotor"}, "intvelocity"),
        ({**motor(effort=1), "price": 3}, "motors.own.price"),
    ],
)
def test_a_bad_motor_is_named(content: dict[str, Any], text: str) -> None:
    with pytest.raises(ConfigError) as error:
        plan_of(motors={"own": content})
    assert text in str(error.value)


def test_no_type_takes_a_motor_out_but_none_takes_none() -> None:
    with pytest.raises(ConfigError, match="type none takes nothing else; not motor"):
        plan_of(actuators={"a": {"type": "none", "motor": "sts3215"}})
    assert not compiled(pendulum(), actuators={"*": {"motor": "sts3215"}, "arm*": "none"}).nu


@since(3, 7)
def test_a_dc_motor_whose_constants_nobody_knows_is_told() -> None:
    entries = {"*": {"type": "dcmotor", "motor": "erob80_100"}}
    code, message, _ = problem(pendulum(), **entries)
    assert code == "E-ACTUATOR"
    assert "type dcmotor lacks its motor" in message
    assert exported(pendulum(), actuators={"*": {**entries["*"], "resistance": 2}}).written.actuation


def test_the_plan_of_a_motor_has_its_content_and_so_has_the_cache_key() -> None:
    tree = {"source": {"kind": "sample"}, "actuators": {"*": {"motor": "sts3215"}}}
    plan = Plan.parse(tree)
    assert plan.motors["sts3215"].values["armature"].value == 0.0284
    assert Plan.parse(plan.tree()) == plan


def test_the_joints_of_a_robots_file_win_over_its_motors() -> None:
    plan = plan_of(
        joints={"elbow": {"rotor_inertia": 1e-5, "gear": 50, "effort": 12}},
        actuators={"elbow": {"motor": "mx106"}},
    )
    robot = robot_of(sample_document(), plan)
    table = json.loads(export(robot, NO_MESHES, plan).files["robot.json"])
    (elbow,) = (dof for one in table["joints"] for dof in one["dofs"] if dof["name"] == "elbow")
    assert (elbow["armature"], elbow["effort"]) == (pytest.approx(0.025), 12)
    assert (elbow["provenance"]["armature"], elbow["provenance"]["effort"]) == ("given", "given")
    assert elbow["velocity"] == 5.096
    assert elbow["provenance"]["velocity"].startswith("motor mx106: ")


def test_the_control_of_a_motor_on_a_slide_is_the_turn_of_the_motor() -> None:
    entry = {
        "motor": "own",
        "gear": 100,
        "type": "position",
        "ctrlrange": ["0 deg", "90 deg"],
        "encoder": True,
    }
    found = exported(both(), motors={"own": FULL}, actuators={"lift": entry})
    assert model_of(found).actuator("lift").ctrlrange == pytest.approx([0, math.pi / 2])
    order = json.loads(found.files["robot.json"])["order"]["mjcf"]
    (control,) = order["actuators"]
    assert control["unit"] == "rad"
    assert [one["unit"] for one in order["sensors"]] == ["rad", "rad/s"]
    message = problem_with(both(), {"lift": entry | {"ctrlrange": [0, "90 mm"]}})[1]
    assert message == "ctrlrange of lift: '90 mm' is no angle, and the motor own turns"


@pytest.mark.parametrize(
    ("entries", "hint"),
    [
        ({"*": {"motor": "own"}}, "so do these motors with their own kp; give another one, or gravcomp"),
        (
            {"a_joint": {"type": "position", "kp": 1}, "arm_joint": {"motor": "own"}},
            "raise kp; where a motor gives it, so does the motor: give another one, or gravcomp",
        ),
        ({"*": {"type": "position", "kp": 1}}, "raise kp, or leave it out: it is estimated then"),
    ],
    ids=["motors", "both", "none"],
)
def test_the_hint_of_a_sag_knows_whose_kp_it_is(entries: dict[str, Any], hint: str) -> None:
    limits = {"a_joint": Limits(-1.0, 1.0), "arm_joint": Limits(-1.0, 1.0)}
    swings = [
        joint("revolute", "base", name, [0.0], place=ACROSS, limits=limits, name=f"{name}_joint")
        for name in ("a", "arm")
    ]
    heavy = lump(5.0, 0.3, 0, 0)
    robot = robot_with(swings, inertials={"a": heavy, "arm": heavy})
    found = exported(robot, motors={"own": motor(kp=2, kv=0.1, effort=50)}, actuators=entries)
    (sag,) = (one for one in found.diagnostics if one.code == "W-ACTUATOR-SAG")
    assert sag.hint == hint
