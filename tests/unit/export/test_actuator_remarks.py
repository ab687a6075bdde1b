"""Diagnostics and advice about actuators: what falls, sags, is driven twice or has no range."""

from dataclasses import replace

import pytest

from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Limits, Relation, frozen
from tests.support.exports import compiled, exported, messages_of
from tests.support.pendulums import ACROSS, ARM, GRAVITY, MASS, actuation, at_home, lump, pendulum, targeted
from tests.support.reported import notes
from tests.support.robots import at, joint, robot_with
from tests.unit.robot.test_home import four_bar as planar_bar


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
