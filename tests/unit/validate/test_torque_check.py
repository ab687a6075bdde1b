"""What each joint needs to hold the weight: closed forms, the virtual work of a loop, and a payload."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.model.poses import from_parts
from linkwright.stages.robot.model.robot import Dynamics, Frame, Limits, Relation, frozen
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.validate import validate
from linkwright.stages.validate.check_options import CheckOptions
from linkwright.stages.validate.checks.simulation.torque import check
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.simulate.holding import driven_joints, holding_forces, strength
from tests.support.building import plan_of, robot_of, write
from tests.support.kit import Kit, four_bar
from tests.support.robots import at, joint, robot_with, solid

GRAVITY = 9.81
AROUND_Y = from_parts(np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]), np.zeros(3))
"""A frame whose z axis is the y axis of the one that it stands in, and whose x axis is the same."""

SERVOS = {"*": {"type": "position", "kp": 100, "kv": 10}}


def arm(effort=None):
    """Two links of 1 kg and 2 kg with their masses 0.3 m along x, on hinges about y with a range of ±1 rad;
    the second hinge is 0.5 m along x, and a frame another 0.5 m."""
    made = {
        "limits": {"low_joint": Limits(-1, 1), "up_joint": Limits(-1, 1)},
        "dynamics": Dynamics(effort=effort),
    }
    joints = [
        joint("revolute", "base", "low", [0.0], place=AROUND_Y, **made),
        joint("revolute", "low", "up", [0.0], place=at(0.5, 0, 0), **made),
    ]
    return robot_with(
        joints,
        frames=[Frame("tip", "up", frozen(at(0.5, 0, 0)), "Tip")],
        inertials={"low": solid(1.0, (0.3, 0, 0)), "up": solid(2.0, (0.3, 0, 0))},
    )


def compiled_model(robot, folder, payload=(), **keys):
    exported = write(robot, folder, plan_of(**{"actuators": SERVOS, **keys}))
    model = mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))
    options = CheckOptions(payload=tuple(payload))
    return CompiledModel(folder / "robot.xml", model, exported.written, options)


POSES = [{"low_joint": 0.0, "up_joint": 0.0}, {"low_joint": 0.4, "up_joint": -0.9}]


@pytest.mark.parametrize("payload", [{}, {"tip": 3.0}, {"up": 3.0}, {"low": 0.5, "tip": 0.25}])
def test_arm_holds_its_weight_and_its_payload_on_its_levers(payload, tmp_path):
    made = compiled_model(arm(), tmp_path)
    forces = holding_forces(made.model, made.robot, POSES, payload)
    levers = {"low": (0.3, 0.0), "up": (0.5, 0.3), "tip": (0.5, 0.5)}
    masses = [("low", 1.0), ("up", 2.0), *payload.items()]
    for row, pose in enumerate(POSES):
        low, both = pose["low_joint"], pose["low_joint"] + pose["up_joint"]
        # A turn about y moves x down.
        upper = -sum(m * GRAVITY * math.cos(both) * levers[name][1] for name, m in masses)
        lower = upper - sum(m * GRAVITY * math.cos(low) * levers[name][0] for name, m in masses)
        assert forces["up_joint"][row] == pytest.approx(upper, abs=1e-12)
        assert forces["low_joint"][row] == pytest.approx(lower, abs=1e-12)


@pytest.mark.parametrize(
    ("motors", "expected"),
    [
        ([("0 10", 1)], 0.0),
        ([("-5 10", 2)], 10.0),
        ([("0 10", 1), ("-10 0", 1)], 10.0),
        ([("-8 0", 1), ("-6 0", -1)], 6.0),
        ([("1 3", 1)], 0.0),
    ],
)
@pytest.mark.parametrize("transmission", ["joint", "jointinparent"])
def test_strength_of_a_joint_is_what_its_actuators_have_together(motors, expected, transmission):
    rows = "".join(
        f'<motor {transmission}="turn" gear="{gear}" forcerange="{forces}" forcelimited="true"/>'
        for forces, gear in motors
    )
    body = '<body><joint name="turn"/><geom size=".1"/></body>'
    text = f"<mujoco><worldbody>{body}</worldbody><actuator>{rows}</actuator></mujoco>"
    model = mujoco.MjModel.from_xml_string(text)
    assert driven_joints(model) == [0]
    assert strength(model, 0) == expected


def test_driver_carries_what_its_follower_has(tmp_path):
    """The virtual work of a relation: the driver's force, and the follower's times its rate."""
    robot = replace(arm(), relations=(Relation("gear", "up_joint", "low_joint", -1.5, 0.0),))
    poses = [{"low_joint": 0.3, "up_joint": -0.45}]
    free = holding_forces(compiled_model(arm(), tmp_path).model, arm(), poses, {})
    made = compiled_model(robot, tmp_path, actuators={"low_joint": {"type": "motor"}})
    forces = holding_forces(made.model, robot, poses, {})
    assert set(forces) == {"low_joint"}
    expected = free["low_joint"][0] - 1.5 * free["up_joint"][0]
    assert forces["low_joint"][0] == pytest.approx(expected, abs=1e-12)


def test_one_joint_holds_a_loop_by_virtual_work(tmp_path):
    """The slope of the potential energy along the way on which the parallelogram stays closed."""
    kit = Kit()
    four_bar(kit)
    plan = plan_of(actuators={"drive": {"type": "motor"}})
    robot = robot_of(kit.document, plan)
    write(robot, tmp_path, plan)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    model.opt.gravity = (1.0, -GRAVITY, 0.3)

    def pose(q):
        return {"drive": q, "pin": -q, "swing": q, "close": -q}

    def energy(q):
        poses = link_poses(robot, pose(q))
        places = {
            link.name: robot.world_from_root @ poses[link.name] @ np.append(link.inertial.com, 1.0)
            for link in robot.links
        }
        return -sum(link.inertial.mass * places[link.name][:3] @ model.opt.gravity for link in robot.links)

    for q in (0.2, 0.5, 0.9):
        forces = holding_forces(model, robot, [pose(q)], {})
        assert set(forces) == {"drive"}
        slope = (energy(q + 1e-5) - energy(q - 1e-5)) / 2e-5
        assert forces["drive"][0] == pytest.approx(slope, rel=1e-6)


def test_effort_that_does_not_suffice_is_a_warning(tmp_path):
    """Stretched out, 1 kg at 0.3 m and 2 kg at 0.8 m take 18.6 N m: that is `home`, and the most."""
    need = GRAVITY * (0.3 + 2 * 0.8)
    for effort, passes in ((1.01 * need, True), (0.99 * need, False)):
        (verdict,) = check(compiled_model(arm(effort), tmp_path))
        assert verdict.passed == passes
        assert verdict.warns == (not passes)
        assert verdict.value == pytest.approx(need / effort, rel=1e-9)
    assert [finding.element for finding in verdict.findings] == ['joint "low_joint"']
    assert verdict.findings[0].attribute == "actuatorfrcrange"
    rows = {row[0]: dict(zip(verdict.table.header[2:], row[2:], strict=True)) for row in verdict.table.rows}
    assert abs(rows["low_joint"]["holds at home"]) == pytest.approx(need, abs=1e-6)
    assert rows["low_joint"]["can hold"] == pytest.approx(0.99 * need, abs=1e-6)
    assert rows["up_joint"]["holds at most"] == pytest.approx(2 * GRAVITY * 0.3, rel=1e-2)


def test_payload_may_be_too_much(tmp_path):
    (bare,) = check(compiled_model(arm(20.0), tmp_path))
    (loaded,) = check(compiled_model(arm(20.0), tmp_path, [("tip", 0.5)]))
    assert bare.passed
    assert loaded.warns
    assert loaded.value - bare.value == pytest.approx(0.5 * GRAVITY * 1.0 / 20.0, rel=1e-9)
    assert "0.5 kg at tip" in loaded.detail


def test_payload_is_a_key(tmp_path):
    robot = arm(20.0)
    plan = plan_of(actuators=SERVOS, validate={"payload": {"tip": 0.5}})
    exported = write(robot, tmp_path, plan)
    (check,) = [check for check in validate(tmp_path, exported.written, plan) if "torque" in check.name]
    assert check.warns
    assert check.value == pytest.approx(GRAVITY * 2.4 / 20.0, rel=1e-9)
    wrong = plan_of(actuators=SERVOS, validate={"payload": {"tipp": 0.5}})
    with pytest.raises(ConfigError, match=r"validate\.payload\.tipp") as error:
        validate(tmp_path, exported.written, wrong)
    assert "tip" in error.value.hint
