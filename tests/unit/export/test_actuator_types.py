"""Types of actuators with a state of their own, or that only newer MuJoCos have, in the compiled model."""

import importlib.metadata
import math
import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from linkwright.pipeline.run.preflight import plan_problems
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Dynamics, Keyframe, Limits
from tests.support.building import plan_of, write
from tests.support.exports import exported, failing
from tests.support.pendulums import (
    ACROSS,
    ARM,
    GRAVITY,
    MASS,
    at_home,
    driven_model,
    lump,
    pendulum,
    targeted,
)
from tests.support.robots import joint, robot_with
from tests.support.states import run, state

pytestmark = pytest.mark.usefixtures("no_score")

INSTALLED = tuple(map(int, re.findall(r"\d+", mujoco.__version__)[:2]))

HEAVY = MASS * GRAVITY * ARM


def since(*version):
    wanted = ".".join(map(str, version))
    return pytest.mark.skipif(version > INSTALLED, reason=f"needs MuJoCo {wanted}")


DC = {"type": "dcmotor", "motorconst": [0.5], "resistance": 2}


def sledge(**dynamics):
    """A mass of 2 kg that slides level."""
    slide = joint("prismatic", "base", "sledge", [0.0], place=ACROSS, dynamics=Dynamics(**dynamics))
    return robot_with([slide], inertials={"sledge": lump(MASS, 0, 0, 0)})


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
    (
        {"type": "general", "dyntype": "filter", "dynprm": [0.5]},
        "dyntype",
        0,
        int(mujoco.mjtDyn.mjDYN_FILTER),
    ),
    ({"type": "intvelocity", "kp": 77, "kv": 5}, "biasprm", 1, -77),
    ({"type": "intvelocity", "kp": 77, "kv": 5}, "biasprm", 2, -5),
    ({"type": "intvelocity", "gear": -2}, "actrange", 1, 2),
    ({"type": "damper", "kv": 5}, "gainprm", 2, -5),
    ({"type": "damper", "kv": 5}, "ctrlrange", 1, 1),
    ({"type": "damper", "ctrlrange": [0.1, 0.4]}, "ctrlrange", 0, 0.1),
    pytest.param({"type": "pid", "kp": 77}, "biasprm", 1, -77, marks=since(3, 12)),
    pytest.param({"type": "pid", "kp": 7, "ki": 9, "imax": 2}, "gainprm", 0, 9, marks=since(3, 12)),
    pytest.param({"type": "pid", "kp": 7, "ki": 9, "imax": 2}, "dynprm", 0, 2, marks=since(3, 12)),
    pytest.param({"type": "pid", "kp": 7, "slewmax": 3}, "dynprm", 1, 3, marks=since(3, 12)),
    pytest.param({**DC, "motorconst": [0.4, 0.9]}, "gainprm", 1, 0.6, marks=since(3, 7)),
    pytest.param(DC, "gainprm", 0, 2, marks=since(3, 7)),
    pytest.param({**DC, "saturation": [3]}, "forcerange", 1, 3, marks=since(3, 7)),
    pytest.param({**DC, "inductance": [0, 0.02]}, "dynprm", 0, 0.02, marks=since(3, 7)),
    pytest.param({**DC, "cogging": [0.1, 6, 0.2]}, "biasprm", 1, 6, marks=since(3, 7)),
    pytest.param({**DC, "thermal": [1, 2, 0, 0.004, 25, 25]}, "gainprm", 2, 0.004, marks=since(3, 12)),
    pytest.param({**DC, "lugre": [100, 1, 0.1, 0.2, 0.3]}, "biasprm", 3, 0.1, marks=since(3, 12)),
    pytest.param({"type": "dcmotor", "nominal": [12, 3, 5]}, "ctrlrange", 1, 12, marks=since(3, 7)),
    pytest.param({"type": "motor", "delay": 0.01}, "delay", 0, 0.01, marks=since(3, 5)),
    pytest.param({"type": "motor", "delay": 0.01, "interp": "linear"}, "history", 1, 1, marks=since(3, 5)),
]


@pytest.mark.parametrize(("entry", "field", "index", "value"), GIVEN)
def test_given_values_are_in_the_model(entry, field, index, value):
    values = getattr(driven_model(pendulum(saved=0.2), entry), f"actuator_{field}")[0]
    assert np.ravel(values)[index] == pytest.approx(value, rel=1e-12)


ENTRIES = [pytest.param(row.values[0], marks=row.marks) if hasattr(row, "marks") else row[0] for row in GIVEN]


@pytest.mark.slow
@pytest.mark.parametrize("entry", ENTRIES)
def test_given_values_pass_the_checks(entry, tmp_path):
    plan = plan_of(actuators={"*": entry})
    names = failing(tmp_path, write(pendulum(saved=0.2), tmp_path, plan), plan)
    assert [name for name in names if "trial" not in name] == []


def test_target_of_an_intvelocity_moves_at_its_control():
    model = driven_model(pendulum(saved=0.4, velocity=2.0), "intvelocity")
    assert list(model.actuator_ctrlrange[0]) == [-2, 2]
    data = state(model, "home")
    target = float(data.act[0])
    assert 0.4 < target < 0.41
    run(model, data, 1.0)
    assert data.qpos[0] == pytest.approx(0.4, abs=1e-9)
    data.ctrl[0] = -0.5
    run(model, data, 1.0)
    assert data.act[0] == pytest.approx(target - 0.5, abs=1e-9)
    assert data.qpos[0] == pytest.approx(0.4 - 0.5, abs=0.03)
    run(model, data, 3.0)
    assert data.act[0] == -1.0


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_damper_slows_a_sledge_as_the_closed_form_says(share):
    """m v' = −share · kv · v."""
    robot = sledge(armature=0.5)
    model = driven_model(robot, {"type": "damper", "kv": 3}, scene__option={"timestep": 1e-4})
    data = mujoco.MjData(model)
    data.qvel[0], data.ctrl[0] = 1.0, share
    run(model, data, 0.8)
    assert data.qvel[0] == pytest.approx(math.exp(-share * 3 * 0.8 / (MASS + 0.5)), rel=1e-3)


@since(3, 12)
def test_integral_part_of_a_pid_takes_the_sag_away():
    def sunk(**more):
        entry = {"type": "pid", "kp": 200, "kv": 20, **more}
        return -float(targeted(driven_model(pendulum(), entry), 12.0).qpos[0])

    assert sunk() == pytest.approx(HEAVY / 200, rel=0.01)
    assert abs(sunk(ki=200)) < 1e-3
    assert sunk(ki=200, imax=HEAVY / 2 / 200) == pytest.approx(HEAVY / 2 / 200, rel=0.02)
    for more in ({}, {"ki": 200}, {"ki": 200, "imax": HEAVY / 2 / 200}):
        entry = {"type": "pid", "kp": 200, "kv": 20, **more}
        held = at_home(driven_model(pendulum(), entry), 12.0)
        assert held.qpos[0] == pytest.approx(0.0, abs=1e-9)


@since(3, 12)
def test_target_of_a_pid_moves_at_most_at_its_slew_rate():
    entry = {"type": "pid", "slewmax": 0.5}
    model = driven_model(pendulum(saved=0.4), entry)
    data = at_home(model, 0.5)
    assert data.act[0] == pytest.approx(data.ctrl[0], rel=1e-9)
    assert data.qpos[0] == pytest.approx(0.4, abs=1e-9)
    data.ctrl[0] = -0.6
    run(model, data, 1.0)
    assert data.qpos[0] == pytest.approx(0.4 - 0.5, abs=0.03)


@since(3, 17)
def test_pid_may_have_both_and_its_states_are_in_order():
    entry = {"type": "pid", "ki": 5, "slewmax": 0.5}
    model = driven_model(pendulum(saved=0.4), entry)
    weight = HEAVY * math.cos(0.4)
    assert list(model.key_act[model.key("home").id]) == pytest.approx([0.4, weight / 5])
    assert at_home(model, 1.0).qpos[0] == pytest.approx(0.4, abs=1e-9)


@since(3, 7)
@pytest.mark.parametrize("gear", [1.0, -30.0])
def test_dc_motor_has_its_stall_torque_and_its_no_load_speed(gear):
    entry = {"type": "dcmotor", "nominal": [12, 3, 5], "gear": gear}
    model = driven_model(pendulum(), entry)
    data = mujoco.MjData(model)
    for speed, torque in ((0.0, 3.0), (2.5, 1.5), (5.0, 0.0)):
        data.ctrl[0], data.qvel[0] = 12, speed / gear
        mujoco.mj_forward(model, data)
        assert data.qfrc_actuator[0] == pytest.approx(torque * gear, abs=1e-9)


HOLDING = [
    {"type": "position", "kp": 60, "kv": 8},
    {"type": "intvelocity", "kp": 60, "kv": 8},
    {"type": "motor"},
    {"type": "motor", "gear": 7},
    {"type": "general", "gainprm": [3]},
    {"type": "general", "gainprm": [900], "biastype": "affine", "biasprm": [2, -900, -40]},
    pytest.param({"type": "dcmotor", "nominal": [12, 30, 5]}, marks=since(3, 7)),
    pytest.param({**DC, "motorconst": [0.4, 0.9], "gear": 20}, marks=since(3, 7)),
]


@pytest.mark.parametrize("entry", HOLDING)
def test_controls_of_each_keyframe_hold_it(entry):
    """A motor's control is the weight: the pose is in balance, if not stable. A servo's is a target beyond
    the pose, by what it sags."""
    robot = replace(pendulum(saved=0.4), keyframes=(Keyframe("up", (("arm_joint", -0.7),)),))
    model = driven_model(robot, entry)
    assert model.nkey == 3
    for key, angle in (("cad", 0.4), ("home", 0.4), ("up", -0.7)):
        data = state(model, key)
        assert data.qfrc_bias[0] == pytest.approx(HEAVY * math.cos(angle), rel=1e-12)
        assert data.qfrc_actuator[0] == pytest.approx(data.qfrc_bias[0], rel=1e-9)
        if entry["type"] in ("position", "intvelocity"):
            mujoco.mj_step(model, data, 2000)
            assert data.qpos[0] == pytest.approx(angle, abs=1e-9)


def test_intvelocity_without_limits_has_a_wide_range():
    turn = joint("revolute", "base", "arm", [0.7], place=ACROSS)
    model = driven_model(robot_with([turn]), {"type": "intvelocity", "gear": 3})
    assert list(model.actuator_actrange[0]) == [-3e6, 3e6]


@since(3, 5)
@pytest.mark.parametrize(("delay", "steps"), [(0.01, 5), (0.002, 1), (0.0065, 4)])
def test_control_acts_after_its_delay(delay, steps):
    model = driven_model(sledge(), {"type": "motor", "delay": delay})
    data = mujoco.MjData(model)
    data.ctrl[0] = 1.0
    forces = []
    for _ in range(steps + 2):
        mujoco.mj_step(model, data)
        forces.append(float(data.actuator_force[0]))
    assert forces == [0.0] * steps + [1.0] * 2


def too_old(monkeypatch, version, **actuators):
    monkeypatch.setattr(importlib.metadata, "version", lambda name: version)
    problems = plan_problems(plan_of(actuators=actuators))
    return [f"{problem.code} {problem.where}: {problem.message} | {problem.hint}" for problem in problems]


def test_features_of_newer_mujocos_are_errors_with_both_versions(monkeypatch):
    newer = {"a": ("type pid", "3.12"), "b": ("type dcmotor", "3.7"), "c": ("delay", "3.5")}
    assert too_old(monkeypatch, "3.4.0", a="pid", b=DC, c={"type": "motor", "delay": 0.1}, d="damper") == [
        f"E-ACTUATOR actuators.{key}: {feature} needs MuJoCo {first}; installed is 3.4.0 "
        f'| pip install "mujoco>={first}"'
        for key, (feature, first) in newer.items()
    ]
    both = {"type": "pid", "ki": 1, "slewmax": 1}
    assert too_old(monkeypatch, "3.12.0", a="pid", b=DC, c={"delay": 0.1}) == []
    (text,) = too_old(monkeypatch, "3.13.0", a=both)
    assert "ki with slewmax needs MuJoCo 3.17" in text
    assert too_old(monkeypatch, "3.17.0", a=both) == []


def test_entries_may_complete_each_other():
    entries = {"*": {"type": "pid", "ki": 3}, "arm*": {"imax": 2}}
    driven = exported(pendulum(), actuators=entries).written.actuation
    assert isinstance(driven, Actuation)
    assert dict(driven.actuators[0].terms) == {"input": "pos", "ki": "3", "imax": "2"}
    assert driven.actuators[0].sag == 0


def test_limits_bound_a_pid_as_a_position_servo():
    limits = {"arm_joint": Limits(-0.25, 0.5)}
    robot = robot_with([joint("revolute", "base", "arm", [0.0], place=ACROSS, limits=limits)])
    driven = exported(robot, actuators={"*": "pid"}).written.actuation
    assert driven.actuators[0].control == (-0.25, 0.5)


@pytest.mark.parametrize("gear", [1.0, -4.0])
def test_target_of_a_general_integrator_is_in_the_keyframe(gear):
    """As an MJCF's intvelocity reads when it is compiled."""
    entry = {
        "type": "general", "dyntype": "integrator", "gainprm": [900], "biastype": "affine",
        "biasprm": [0, -900, -40], "gear": gear,
    }  # fmt: skip
    model = driven_model(pendulum(saved=0.4), entry)
    sag = HEAVY * math.cos(0.4) / (900 * gear)
    assert model.key_act[model.key("home").id][0] == pytest.approx(0.4 * gear + sag, rel=1e-9)
    assert at_home(model, 2.0).qpos[0] == pytest.approx(0.4, abs=1e-9)
