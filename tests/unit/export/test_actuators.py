"""The key `actuators`: which dofs are driven, with what, and what the compiled model does with it."""

import json
import math
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest

from linkwright.stages.export import Exported, export
from linkwright.stages.export.actuators.actuate import actuate
from linkwright.stages.robot.errors import ExportError
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Dynamics, Inertial, Limits, Relation, Robot, frozen
from tests.fake_onshape.sample import sample_document
from tests.support.building import NO_MESHES, plan_of, robot_of
from tests.support.kit import SIDE, TOP, Kit, four_bar
from tests.support.robots import at, joint, robot_with
from tests.unit.robot.test_home import four_bar as planar_bar

ARM, MASS, GRAVITY = 0.3, 2.0, 9.81
ACROSS = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0.0], [0, 0, 0, 1]])
"""A joint's frame with its z axis across gravity."""


def lump(mass: float, *com: float) -> Inertial:
    return Inertial(mass, frozen(com), frozen(np.eye(3) * mass * 1e-4))


def pendulum(saved: float = 0.0, **dynamics: float) -> Robot:
    """A turn about −y with a mass `MASS` at `ARM` along x: its weight at q is m g l cos q."""
    limits = {"arm_joint": Limits(-1.0, 1.0)}
    swing = joint(
        "revolute", "base", "arm", [saved], place=ACROSS, limits=limits, dynamics=Dynamics(**dynamics)
    )
    return robot_with([swing], inertials={"arm": lump(MASS, ARM, 0, 0)})


def both(**dynamics: float) -> Robot:
    """A slide upwards, and on it the pendulum."""
    limits = {"lift": Limits(0.0, 0.2), "arm_joint": Limits(-1.0, 1.0)}
    more = {"limits": limits, "dynamics": Dynamics(**dynamics)}
    lift = joint("prismatic", "base", "column", [0.1], name="lift", **more)
    swing = joint("revolute", "column", "arm", [0.0], place=ACROSS, **more)
    return robot_with([lift, swing], inertials={"column": lump(1.0, 0, 0, 0), "arm": lump(MASS, ARM, 0, 0)})


def pair(**keys: object) -> Robot:
    """Two turns of which the second follows the first."""
    joints = [
        joint("revolute", "base", name, [0.0], place=at(x, 0, 0)) for name, x in (("a", 0.0), ("b", 0.2))
    ]
    return robot_with(joints, relations=[Relation("gear", "b_joint", "a_joint", -2.0, 0.0)])


def exported(robot: Robot, **keys: object) -> Exported:
    return export(robot, NO_MESHES, plan_of(**keys))


def actuation(robot: Robot, **actuators: object) -> Actuation:
    found = exported(robot, actuators=actuators).written.actuation
    assert found is not None
    return found


def compiled(robot: Robot, **keys: object) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(exported(robot, **keys).files["robot.xml"].decode())


def at_home(model: mujoco.MjModel, seconds: float) -> mujoco.MjData:
    """The state after some time at the keyframe `home`, its controls held."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
    return data


def targeted(model: mujoco.MjModel, seconds: float) -> mujoco.MjData:
    """The state after some time from `home`, where the target of each servo is the pose itself."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    mujoco.mj_forward(model, data)
    data.ctrl[:], data.act[:] = data.actuator_length, 0.0
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
    return data


def problem(robot: Robot, **actuators: object) -> tuple[str, str, str]:
    with pytest.raises(ExportError) as error:
        exported(robot, actuators=actuators)
    (only,) = error.value.problems
    return only.code, only.message, only.hint


def test_without_the_key_nothing_is_driven_and_the_advice_names_what_falls() -> None:
    found = exported(pendulum())
    assert found.written.actuation == Actuation()
    assert b"<actuator" not in found.files["robot.xml"]
    assert b"ctrl=" not in found.files["robot.xml"]
    assert found.advice == "nothing holds arm_joint against its weight: try actuators=position"


def test_there_is_no_advice_where_friction_holds_or_something_drives_or_no_weight_is_on_a_dof() -> None:
    assert exported(pendulum(friction=MASS * GRAVITY * ARM * 1.01)).advice == ""
    assert exported(pendulum(friction=MASS * GRAVITY * ARM * 0.99)).advice != ""
    assert exported(pendulum(), actuators={"*": "motor"}).advice == ""
    upright = robot_with([joint("revolute", "base", "arm", [0.0])])
    assert exported(upright).advice == ""


def test_the_load_is_the_weight_over_the_range_and_the_sag_follows_from_the_stiffness() -> None:
    (servo,) = actuation(pendulum(saved=0.8), **{"*": "position"}).actuators
    weight = MASS * GRAVITY * ARM
    assert servo.home_load == pytest.approx(weight * math.cos(0.8), rel=1e-9)
    assert servo.home_load < servo.load <= weight
    assert servo.load == pytest.approx(weight, rel=0.01)
    assert servo.kp is not None
    assert servo.kp >= 1.9 * weight / 0.01
    assert servo.sag == pytest.approx(servo.home_load / servo.kp)
    assert servo.estimated == ("kp", "kv")


def two_arms(heavier: float = 0.0) -> Robot:
    """A left and a right arm of two turns each, mirror images of each other but for what the right hand has
    more; masses are at ends of links."""
    rows = []
    for side, y, sign in (("left", 0.1, 1), ("right", -0.1, -1)):
        limits = {f"{side}_shoulder": Limits(*sorted((-1.2 * sign, 0.4 * sign)))}
        limits |= {f"{side}_elbow": Limits(*sorted((0.1 * sign, 2.0 * sign)))}
        upper = {"name": f"{side}_shoulder", "place": at(0, y, 0) @ ACROSS, "limits": limits}
        rows.append(joint("revolute", "base", f"{side}_upper", [0.0], **upper))
        lower = {"name": f"{side}_elbow", "place": at(0.3, 0, 0), "limits": limits}
        rows.append(joint("revolute", f"{side}_upper", f"{side}_lower", [0.2 * sign], **lower))
    masses = {f"{side}_{part}": lump(1.0, 0.3, 0, 0) for side in ("left", "right") for part in ("upper",)}
    masses |= {"left_lower": lump(0.5, 0.3, 0, 0), "right_lower": lump(0.5 + heavier, 0.3, 0, 0)}
    return robot_with(rows, inertials=masses)


def test_copies_of_a_joint_share_what_is_estimated_and_others_do_not() -> None:
    found = actuation(two_arms(), **{"*": "position"})
    kp = {one.name: one.kp for one in found.actuators}
    armatures = {one.dof: one.value for one in found.armatures}
    for values in (kp, armatures):
        assert values["left_shoulder"] == values["right_shoulder"] != values["left_elbow"]
        assert values["left_elbow"] == values["right_elbow"]
    kp = {one.name: one.kp for one in actuation(two_arms(heavier=0.2), **{"*": "position"}).actuators}
    assert kp["left_elbow"] < kp["right_elbow"]


@pytest.mark.parametrize(
    ("entry", "effort", "force"),
    [
        ("position", 2.0, 2.0),
        ("position", 40.0, 40.0),
        ({"type": "position", "gear": -5}, 40.0, 40.0),
        ({"type": "position", "gear": 5, "forcerange": [-3, 1]}, 40.0, 15.0),
        ({"type": "intvelocity", "forcerange": [-6, 6]}, None, 6.0),
    ],
)
def test_a_servo_reaches_its_effort_at_no_less_than_a_tenth_of_a_radian(
    entry: Any, effort: float | None, force: float
) -> None:
    """The force of the compiled servo, as it is limited, for errors up to 0.1 rad: never the whole before."""
    robot = pendulum() if effort is None else pendulum(effort=effort)
    (servo,) = actuation(robot, **{"*": entry}).actuators
    assert servo.kp is not None
    assert servo.kp * servo.gear**2 * 0.1 == pytest.approx(force, rel=0.005)
    (plain,) = actuation(pendulum(), **{"*": "position"}).actuators
    assert plain.kp is not None
    assert plain.kp > servo.kp * servo.gear**2


def test_a_slide_reaches_its_effort_at_no_less_than_ten_millimetres() -> None:
    lift, _ = actuation(both(effort=30.0), **{"*": "position"}).actuators
    assert lift.kp == pytest.approx(30.0 / 0.01)


def test_turns_and_slides_sag_less_than_their_bounds_in_a_simulation() -> None:
    robot = both()
    model = compiled(robot, actuators={"*": "position"})
    data = targeted(model, 5.0)
    slide, turn = (data.joint(name).qpos[0] for name in ("lift", "arm_joint"))
    assert 1e-5 < 0.1 - slide < 1e-3
    assert 1e-3 < -turn < 1e-2
    sags = {one.name: one.sag for one in actuation(robot, **{"*": "position"}).actuators}
    assert 0.1 - slide == pytest.approx(sags["lift"], rel=1e-3)
    assert -turn == pytest.approx(sags["arm_joint"], rel=1e-2)
    lift, arm = model.actuator("lift").gainprm[0], model.actuator("arm_joint").gainprm[0]
    assert lift != arm


def test_a_driven_dof_without_armature_gets_one_that_is_reported_and_one_that_is_given_stays() -> None:
    found = exported(both(), actuators={"*": "position"})
    assert found.written.actuation is not None
    added = {one.dof: one.value for one in found.written.actuation.armatures}
    model = mujoco.MjModel.from_xml_string(found.files["robot.xml"].decode())
    for name in ("lift", "arm_joint"):
        assert model.joint(name).damping[0] == 0
        assert model.dof_armature[model.joint(name).dofadr[0]] == pytest.approx(added[name])
        stiff = model.actuator(name).gainprm[0]
        assert math.sqrt(stiff / added[name]) * model.opt.timestep == pytest.approx(0.4, rel=0.05)
    (remark,) = (one for one in found.diagnostics if one.code == "I-ARMATURE")
    assert f"arm_joint ({added['arm_joint']:g}), lift" in remark.message
    table = json.loads(found.files["robot.json"])
    assert [dof["estimated"] for one in table["joints"] for dof in one["dofs"]] == [["armature"]] * 2
    kept = exported(both(armature=0.02), actuators={"*": "motor"})
    assert kept.written.actuation is not None
    assert kept.written.actuation.armatures == ()
    assert "I-ARMATURE" not in [one.code for one in kept.diagnostics]


def test_a_servo_that_others_follow_gets_more_armature_and_they_follow_it_better() -> None:
    """A step of the control over the whole range: by how much the follower of a gear lags."""
    limits = {name: Limits(-0.5, 0.5) for name in ("a_joint", "b_joint")}
    joints = [
        joint("revolute", "base", name, [0.0], place=at(x, 0, 0), limits=limits)
        for name, x in (("a", 0.0), ("b", 0.2))
    ]
    inertials = {name: lump(0.02, 0.0, 0.0, 0.0) for name in ("a", "b")}
    relation = Relation("gear", "b_joint", "a_joint", -1.0, 0.0)
    robot = robot_with(joints, relations=[relation], inertials=inertials)
    (armature,) = actuation(robot, **{"*": "position"}).armatures

    def lag(model: mujoco.MjModel) -> float:
        data, worst = mujoco.MjData(model), 0.0
        data.ctrl[0] = 0.3
        for _ in range(200):
            mujoco.mj_step(model, data)
            worst = max(worst, abs(data.qpos[0] + data.qpos[1]))
        return worst

    model = compiled(robot, actuators={"*": "position"})
    assert math.sqrt(model.actuator_gainprm[0][0] / armature.value) * 0.002 == pytest.approx(0.2, rel=0.05)
    light = compiled(robot, actuators={"*": "position"})
    light.dof_armature[0] = armature.value / 4
    mujoco.mj_setConst(light, mujoco.MjData(light))
    assert lag(model) < 0.7 * lag(light)


def test_robot_json_has_each_actuator_with_its_load_and_what_was_estimated() -> None:
    table = json.loads(
        exported(pendulum(), actuators={"*": {"type": "position", "kv": 3}}).files["robot.json"]
    )
    (servo,) = table["actuators"]
    assert servo["estimated"] == ["kp"]
    assert servo["kv"] == 3
    assert servo["control"] == [-1, 1]
    assert servo["home_load"] == pytest.approx(MASS * GRAVITY * ARM, rel=1e-5)
    assert "actuators" not in json.loads(exported(pendulum()).files["robot.json"])


GIVEN = [
    ({"type": "position", "kp": 77}, "gainprm", 0, 77),
    ({"type": "position", "kp": 77}, "biasprm", 1, -77),
    ({"type": "position", "kp": 77, "kv": 5}, "biasprm", 2, -5),
    ({"type": "velocity", "kv": 5}, "gainprm", 0, 5),
    ({"type": "velocity", "kv": 5}, "biasprm", 2, -5),
    ({"type": "motor", "gear": 50}, "gear", 0, 50),
    ({"type": "motor", "ctrlrange": [-2, 3]}, "ctrlrange", 1, 3),
    ({"type": "motor", "forcerange": [-4, 5]}, "forcerange", 0, -4),
    ({"type": "general", "gainprm": [9]}, "gainprm", 0, 9),
    ({"type": "general", "biastype": "affine", "biasprm": [0, -8, -1]}, "biasprm", 1, -8),
    ({"type": "general", "gaintype": "affine", "gainprm": [1, 2]}, "gainprm", 1, 2),
    ({"type": "general", "dyntype": "filter", "dynprm": [0.5]}, "dynprm", 0, 0.5),
    ({"type": "general", "dyntype": "filter", "dynprm": [0.5]}, "dyntype", 0, mujoco.mjtDyn.mjDYN_FILTER),
]


@pytest.mark.parametrize(("entry", "field", "index", "value"), GIVEN)
def test_what_is_given_is_in_the_compiled_model(entry: dict, field: str, index: int, value: float) -> None:
    model = compiled(pendulum(), actuators={"*": entry})
    assert np.ravel(getattr(model.actuator("arm_joint"), field))[index] == value


def test_ranges_come_from_limits_velocity_and_effort_in_the_units_of_the_actuator() -> None:
    robot = pendulum(effort=12.0, velocity=3.0)

    def ends(**entry: object) -> list[float]:
        return list(compiled(robot, actuators={"*": entry}).actuator("arm_joint").ctrlrange)

    assert ends(type="position") == [-1, 1]
    assert ends(type="position", gear=-10) == [-10, 10]
    assert ends(type="velocity") == [-3, 3]
    assert ends(type="velocity", gear=10) == [-30, 30]
    assert ends(type="motor") == [-12, 12]
    assert ends(type="motor", gear=10) == [-1.2, 1.2]
    free = robot_with([joint("revolute", "base", "arm", [0.0])])
    for kind in ("position", "velocity", "motor"):
        assert not compiled(free, actuators={"*": kind}).actuator_ctrllimited[0]


def test_the_effort_bounds_the_force_in_one_place() -> None:
    model = compiled(pendulum(effort=12.0), actuators={"*": "position"})
    assert list(model.jnt_actfrcrange[0]) == [-12, 12]
    assert not model.actuator_forcelimited[0]


@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0])
def test_the_damping_ratio_is_that_of_the_dof_at_home(ratio: float) -> None:
    entry = {"type": "position", "kp": 500, "dampratio": ratio}
    model = compiled(pendulum(armature=0.02), actuators={"*": entry})
    inertia = 0.02 + MASS * ARM**2 + MASS * 1e-4
    kv = -model.actuator("arm_joint").biasprm[2]
    assert kv == pytest.approx(2 * ratio * math.sqrt(500 * inertia), rel=5e-3)


@pytest.mark.parametrize("gear", [1.0, 20.0, -3.0])
def test_a_gear_changes_no_stiffness_at_the_dof_and_home_is_held_through_it(gear: float) -> None:
    entry = {"type": "position", "gear": gear}
    model = compiled(pendulum(saved=0.3), actuators={"*": entry})
    plain = compiled(pendulum(saved=0.3), actuators={"*": "position"})
    stiff = model.actuator("arm_joint").gainprm[0] * gear**2
    assert stiff == pytest.approx(plain.actuator("arm_joint").gainprm[0], rel=5e-3)
    assert at_home(model, 3.0).qpos[0] == pytest.approx(0.3, abs=0.01)


@pytest.mark.parametrize(
    "entry",
    [
        {"type": "motor"},
        {"type": "motor", "gear": 7},
        {"type": "general", "gainprm": [3]},
        {"type": "general", "gainprm": [900], "biastype": "affine", "biasprm": [2, -900, -40]},
    ],
)
def test_the_control_at_home_holds_it(entry: dict) -> None:
    """Of a motor it is the weight: the pose is in balance, if not stable. Of a servo it is a target beyond
    the pose, by what it sags."""
    model = compiled(pendulum(saved=0.4), actuators={"*": entry})
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    mujoco.mj_forward(model, data)
    assert data.qfrc_bias[0] == pytest.approx(MASS * GRAVITY * ARM * math.cos(0.4), rel=1e-12)
    assert data.qfrc_bias[0] - data.qfrc_actuator[0] == pytest.approx(0.0, abs=1e-9)


def test_a_velocity_servo_drifts_slowly_and_follows_its_speed() -> None:
    model = compiled(pendulum(), actuators={"*": "velocity"})
    assert 0.01 < -at_home(model, 1.0).qpos[0] < 0.1
    data = at_home(model, 0.1)
    data.ctrl[0] = 0.5
    for _ in range(500):
        mujoco.mj_step(model, data)
    assert data.qvel[0] == pytest.approx(0.5, abs=0.1)


def test_compensated_weight_makes_no_sag_and_counts_as_force_of_the_actuator() -> None:
    model = compiled(both(), actuators={"arm_joint": {"type": "position", "gravcomp": 1, "kp": 50}})
    assert model.body_gravcomp[model.body("arm").id] == 1
    assert model.body_gravcomp[model.body("column").id] == 0
    assert model.jnt_actgravcomp[model.joint("arm_joint").id]
    alone = compiled(pendulum(), actuators={"*": {"type": "position", "gravcomp": 1, "kp": 50}})
    assert abs(at_home(alone, 2.0).qpos[0]) < 1e-9
    half = compiled(pendulum(), actuators={"*": {"type": "position", "gravcomp": 0.5, "kp": 500}})
    assert abs(at_home(half, 3.0).qpos[0]) < 1e-9
    sag = -targeted(half, 3.0).qpos[0]
    assert sag == pytest.approx(0.5 * MASS * GRAVITY * ARM / 500, rel=0.01)


def test_a_glob_leaves_followers_out_and_a_name_drives_one_in_place_of_its_driver() -> None:
    robot = pair()
    assert [one.dof for one in actuation(robot, **{"*": "position"}).actuators] == ["a_joint"]
    named = actuation(robot, **{"*": "position", "b_joint": {"kp": 5}})
    assert [one.dof for one in named.actuators] == ["b_joint"]
    two = actuation(robot, a_joint="position", b_joint="position")
    assert [one.dof for one in two.actuators] == ["a_joint", "b_joint"]
    out = actuation(robot, **{"*": "position", "a_joint": "none"})
    assert [one.dof for one in out.actuators] == []


def weighing() -> Robot:
    """Two turns of which the second bears the weight and follows the first."""
    swings = [
        joint("revolute", "base", "a", [0.0], place=ACROSS),
        joint("revolute", "base", "b", [0.0], place=at(0, 0.5, 0) @ ACROSS),
    ]
    inertials = {"a": lump(1.0, 0, 0, 0), "b": lump(MASS, ARM, 0, 0)}
    relation = Relation("gear", "b_joint", "a_joint", 3.0, 0.0)
    return robot_with(swings, relations=[relation], inertials=inertials)


def upright_bar(limits: dict[str, Limits] | None = None) -> Robot:
    """A four-bar that gravity acts on: its plane is upright, and the rocker is heavy."""
    flat = planar_bar(limits)
    first, *rest = flat.joints
    *others, last = rest
    up = [replace(one, parent_from_joint=frozen(ACROSS @ one.parent_from_joint)) for one in (first, last)]
    links = tuple(
        replace(link, inertial=lump(MASS, ARM, 0, 0)) if link.name == "rocker" else link
        for link in flat.links
    )
    return replace(flat, joints=(up[0], *others, up[1]), links=links)


def test_the_advice_names_what_drives_and_not_what_follows() -> None:
    assert exported(weighing()).advice == "nothing holds a_joint against its weight: try actuators=position"
    bar = upright_bar()
    (servo,) = actuation(bar, **{"*": "position"}).actuators
    assert exported(bar).advice == f"nothing holds {servo.dof} against its weight: try actuators=position"


def remarks(robot: Robot, code: str, **actuators: object) -> list[str]:
    return [
        f"{one.message} -> {one.hint}"
        for one in exported(robot, actuators=actuators).diagnostics
        if one.code == code
    ]


def test_a_loop_or_a_relation_that_is_driven_twice_is_reported_with_where_its_gain_is_from() -> None:
    (told,) = remarks(upright_bar(), "W-ACTUATOR-TWICE", drive="position", swing="position")
    assert told.startswith(
        "swing is driven, and so is what moves it already, by a loop or a relation: drive."
    )
    assert "its kp of 1 stands for no load, since drive bears the weight" in told
    assert told.endswith("actuators: {drive: none}")
    (told,) = remarks(
        upright_bar(), "W-ACTUATOR-TWICE", drive="position", swing={"type": "position", "kp": 3}
    )
    assert "its kp" not in told
    assert remarks(weighing(), "W-ACTUATOR-TWICE", a_joint="position", b_joint="motor") != []
    assert remarks(upright_bar(), "W-ACTUATOR-TWICE", **{"*": "position"}) == []


def test_a_target_without_a_range_of_its_own_is_reported_where_others_bound_it() -> None:
    limited = upright_bar({"swing": Limits(-4.0, 4.0)})
    told = remarks(limited, "I-ACTUATOR", drive="position")
    assert told == [
        "drive has no limits of its own, so its control has no range; bounded by limits that it moves with: "
        "swing -> joints: {drive: {limits: [..., ...]}}"
    ]
    assert remarks(upright_bar(), "I-ACTUATOR", drive="position") == []
    both_limited = upright_bar({"swing": Limits(-4.0, 4.0), "drive": Limits(-4.0, 4.0)})
    assert remarks(both_limited, "I-ACTUATOR", drive="position") == []


def test_a_follower_puts_its_weight_on_its_driver() -> None:
    robot = weighing()
    (servo,) = actuation(robot, **{"*": "position"}).actuators
    assert servo.home_load == pytest.approx(3.0 * MASS * GRAVITY * ARM, rel=1e-9)
    data = targeted(compiled(robot, actuators={"*": "position"}), 3.0)
    assert abs(data.joint("a_joint").qpos[0]) == pytest.approx(servo.sag, rel=0.05)


def test_a_loop_has_as_many_driven_dofs_as_it_leaves_free_the_nearest_to_the_root(kit: Kit) -> None:
    four_bar(kit)
    robot = robot_of(kit.document)
    found = exported(robot, actuators={"*": "position"})
    assert found.written.actuation is not None
    assert robot.mobility.dof == 1
    (servo,) = found.written.actuation.actuators
    parents = {dof.name: one.parent for one in robot.joints for dof in one.dofs}
    assert parents[servo.dof] == robot.root.name
    (remark,) = (one for one in found.diagnostics if one.code == "I-ACTUATOR")
    others = sorted(name for name in parents if name != servo.dof)
    assert remark.message == f"closed loops: driven are {servo.dof}; these follow: {', '.join(others)}"
    (other,) = actuation(robot, **{"*": "position", servo.dof: "none"}).actuators
    assert other.dof in others


def test_the_samples_servos_are_those_of_a_person(kit: Kit) -> None:
    robot = robot_of(sample_document())
    driven = [one.dof for one in actuation(robot, **{"*": "position"}).actuators]
    assert driven == [
        *("lift", "shoulder_yaw", "shoulder", "elbow", "wrist_pitch", "wrist_roll", "left_finger"),
    ]
    out = [one.dof for one in actuation(robot, **{"*": "position", "shoulder": "none"}).actuators]
    assert [name for name in out if name not in driven] == ["rod_lower_pivot"]


def test_later_entries_win_property_by_property_and_another_type_begins_anew() -> None:
    entries = {"*": {"type": "position", "kv": 9}, "arm*": {"kp": 80}, "arm_joint": {"kp": 90}}
    (servo,) = actuation(pendulum(), **entries).actuators
    assert (servo.kp, servo.kv, servo.estimated) == (90, 9, ())
    (motor,) = actuation(pendulum(), **entries, **{"arm_join?": "motor"}).actuators
    assert (motor.type, motor.kp, motor.kv) == ("motor", None, None)
    (ratio,) = actuation(
        pendulum(), **{"*": {"type": "position", "kv": 9}, "arm*": {"dampratio": 1}}
    ).actuators
    assert ratio.kv != 9


def test_an_actuator_that_is_too_weak_for_the_weight_is_reported_with_both_numbers() -> None:
    found = exported(pendulum(effort=2.0), actuators={"*": "position"})
    (weak,) = (one for one in found.diagnostics if one.code == "W-ACTUATOR-EFFORT")
    assert "arm_joint (5.89 of 2)" in weak.message
    strong = exported(pendulum(effort=6.0), actuators={"*": "position"})
    assert "W-ACTUATOR-EFFORT" not in [one.code for one in strong.diagnostics]


def test_a_servo_that_sags_is_reported_with_its_load_its_limit_and_its_sag() -> None:
    entry = {"type": "position", "kp": 100}
    found = exported(pendulum(effort=12.0), actuators={"*": entry})
    (far,) = (one for one in found.diagnostics if one.code == "W-ACTUATOR-SAG")
    assert "arm_joint by 0.059 rad (load 5.89, force limit 12, kp 100)" in far.message
    model = compiled(pendulum(effort=12.0), actuators={"*": entry})
    assert -targeted(model, 5.0).qpos[0] == pytest.approx(0.0589, rel=0.01)
    assert abs(at_home(model, 5.0).qpos[0]) < 1e-9
    stiff = exported(pendulum(), actuators={"*": {"type": "position", "kp": 300}})
    assert "W-ACTUATOR-SAG" not in [one.code for one in stiff.diagnostics]


@pytest.mark.parametrize(
    ("entries", "code", "message", "hint"),
    [
        ({"elbow": "position"}, "E-GLOB", "no joint matches 'elbow'", "arm_joint, lift"),
        (
            {"lifft": "position"},
            "E-GLOB",
            "no joint matches 'lifft'",
            "did you mean lift? joints are: arm_joint",
        ),
        (
            {"arm_joint": {"kp": 3}},
            "E-ACTUATOR",
            "'arm_joint' has no type of actuator for arm_joint",
            "motor,",
        ),
        (
            {"lift": "motor", "li*": {"kp": 3}},
            "E-ACTUATOR",
            "'li*' gives kp, which type motor of lift does not have",
            "type motor takes forcerange, gear, ctrlrange, gravcomp",
        ),
        (
            {"*": {"type": "position", "kp": 3}},
            "E-ACTUATOR",
            "'*' gives one kp to turns (arm_joint, ...) and slides (lift, ...)",
            "under its own glob",
        ),
        (
            {"*": {"type": "motor", "forcerange": [-1, 1]}},
            "E-ACTUATOR",
            "'*' gives one forcerange to turns (arm_joint, ...) and slides (lift, ...)",
            "under its own glob",
        ),
    ],
)
def test_a_bad_entry_is_named(entries: dict, code: str, message: str, hint: str) -> None:
    found = problem(both(), **entries)
    assert found[0] == code
    assert message in found[1]
    assert hint in found[2]


def test_a_ball_and_a_joint_of_several_dofs_cannot_be_named() -> None:
    robot = robot_with([joint("ball", "base", "arm"), joint("cylindrical", "arm", "rod", name="rod")])
    code, message, hint = problem(robot, arm_joint="motor")
    assert (code, message) == ("E-ACTUATOR", "'arm_joint' is a ball: an actuator drives one turn or slide")
    assert hint == "name one of: rod_slide, rod_turn"
    code, message, hint = problem(robot, rod="motor")
    assert (code, hint) == ("E-GLOB", "name one of its dofs: rod_slide, rod_turn")
    assert [one.dof for one in actuation(robot, **{"*": "motor"}).actuators] == ["rod_slide", "rod_turn"]


def test_all_problems_are_reported_at_once() -> None:
    with pytest.raises(ExportError) as error:
        exported(both(), actuators={"elbow": "motor", "wrist": "motor", "lift": {"kp": 1}})
    assert [one.code for one in error.value.problems] == ["E-ACTUATOR", "E-GLOB", "E-GLOB"]


def test_the_same_input_gives_the_same_bytes(kit: Kit) -> None:
    robot = robot_of(sample_document())
    first, second = (exported(robot, actuators={"*": "position"}).files for _ in range(2))
    assert first == second


def test_a_robot_without_a_dof_can_be_built_with_servos(kit: Kit) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.fasten("Weld", (arm, TOP), (base, SIDE))
    found = exported(robot_of(kit.document), actuators={"*": "position"})
    assert found.written.actuation == Actuation()


def test_legs_of_a_free_robot_hold_the_rest_of_it() -> None:
    """One of two feet carries all the rest: 10 kg 0.3 m away, and at worst the other leg 0.4 m."""
    legs = [
        joint("revolute", "base", name, [0.0], place=at(0.3, y, 0) @ ACROSS)
        for name, y in (("left", 0.2), ("right", -0.2))
    ]
    inertials = {"base": lump(10.0, 0, 0, 0)} | {name: lump(0.5, 0, -0.4, 0) for name in ("left", "right")}
    robot = robot_with(legs, fixed=False, inertials=inertials)
    servos = actuation(robot, **{"*": "position"}).actuators
    for servo in servos:
        assert servo.load == pytest.approx((10.0 * 0.3 + 0.5 * 0.4) * GRAVITY, rel=0.01)
    held = robot_with(legs, fixed=True, inertials=inertials)
    for servo in actuation(held, **{"*": "position"}).actuators:
        assert servo.load <= 0.5 * 0.4 * GRAVITY * 1.0001


def test_actuate_scales_with_the_time_step() -> None:
    plan = plan_of(actuators={"*": "position"})
    found = {
        h: actuate(pendulum(), plan.actuators, h, np.eye(4))[0].armatures[0].value for h in (0.001, 0.002)
    }
    assert found[0.002] / found[0.001] == pytest.approx(4, rel=0.05)


@pytest.mark.parametrize("gravity", [[0, 0, -1.62], [3.0, 0, -5.0], [0, 0, 0]])
def test_the_weight_is_that_of_the_gravity_that_is_asked_for(gravity: list[float]) -> None:
    """A pendulum out along x: τ = −m g_z l at home, by which its servo sags in MuJoCo."""
    option = {"gravity": gravity}
    found = exported(pendulum(), actuators={"*": "position"}, scene__option=option).written.actuation
    assert found is not None
    (servo,) = found.actuators
    assert servo.home_load == pytest.approx(MASS * ARM * -gravity[2], abs=1e-9)
    model = compiled(pendulum(), actuators={"*": "position"}, scene__option=option)
    model.opt.gravity[:] = gravity
    load = MASS * ARM * -gravity[2]
    sag = math.copysign(servo.sag or 0.0, load)
    assert targeted(model, 2.0).qpos[0] == pytest.approx(-sag, rel=0.02, abs=1e-9)
    assert at_home(model, 2.0).qpos[0] == pytest.approx(0.0, abs=1e-9)
    flag = exported(pendulum(), actuators={"*": "position"}, scene__option={"flag": {"gravity": "disable"}})
    assert flag.written.actuation is not None
    assert flag.written.actuation.actuators[0].load == 0.0
    assert bool(exported(pendulum(), scene__option=option).advice) == bool(gravity[2])


def test_the_control_of_a_position_servo_takes_units() -> None:
    typed = {"lift": {"type": "position", "ctrlrange": ["0 mm", "150 mm"]}}
    typed["arm_joint"] = {"type": "position", "ctrlrange": ["-30 deg", 0.5]}
    model = compiled(both(), actuators=typed)
    assert model.actuator("lift").ctrlrange == pytest.approx([0.0, 0.15])
    assert model.actuator("arm_joint").ctrlrange == pytest.approx([-math.pi / 6, 0.5])
    wrong = {"arm_joint": {"type": "position", "ctrlrange": ["-30 mm", 0.5]}}
    text = "ctrlrange of arm_joint: '-30 mm' is no angle, and arm_joint is a turn"
    assert problem(both(), **wrong) == ("E-ACTUATOR", text, "give it in rad, or as '-90 deg'")
    wrong = {"arm_joint": {"type": "motor", "ctrlrange": ["-30 deg", 0.5]}}
    text = (
        "ctrlrange of arm_joint: '-30 deg' is an angle or a length, and the control of type motor is neither"
    )
    assert problem(both(), **wrong)[1] == text
