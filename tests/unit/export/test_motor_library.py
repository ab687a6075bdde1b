"""The motors of the library: plausible, near their datasheets, and with sources."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
import yaml

from linkwright.pipeline.motor_files import library
from linkwright.stages.export.configuration.motor_section import QUANTITIES, MotorSection
from tests.support.pendulums import driven_model, pendulum
from tests.support.places import SHARED


@pytest.mark.parametrize("name", library())
def test_motors_of_the_library_are_plausible_and_have_sources(name):
    content = yaml.safe_load(library()[name].read_text(encoding="utf-8"))
    values = MotorSection.model_validate(content).values
    assert set(values) <= set(QUANTITIES)
    assert {"armature", "damping", "friction", "effort"} <= set(values)
    assert all("://" in value.source or "github.com/" in value.source for value in values.values())
    assert content["notes"]
    numbers = {key: motor_value.value for key, motor_value in values.items()}
    assert 1e-4 < numbers["armature"] < 2
    assert numbers["friction"] < 0.2 * numbers["effort"]
    assert 0.05 < numbers["effort"] < 300
    if "velocity" in numbers:
        assert 1 < numbers["velocity"] < 60
        # Never faster than where back-EMF alone takes the whole voltage.
        assert numbers["velocity"] < numbers["voltage"] / numbers["torque_constant"]
    if "back_emf" in numbers:
        assert numbers["back_emf"] == pytest.approx(
            numbers["torque_constant"] ** 2 / numbers["resistance"], rel=1e-3
        )
        stall = numbers["voltage"] * numbers["torque_constant"] / numbers["resistance"]
        assert 0.95 * stall < numbers["effort"] < 1.001 * stall
        at_speed = (numbers["damping"] + numbers["back_emf"]) * numbers["velocity"] + numbers["friction"]
        assert at_speed == pytest.approx(numbers["effort"], rel=1e-3)
    if "kp" in numbers:
        # The whole torque at an error between a degree and a full turn.
        assert 0.017 < numbers["effort"] / numbers["kp"] < 6.3


SHEETS = {"mx64": (6.0, 63), "mx106": (8.4, 45), "xl330_m288": (0.52, 103)}
"""Motor → stall torque [N m] and no-load speed [rev/min] in the ROBOTIS e-Manual, at the same voltage."""


@pytest.mark.parametrize("name", SHEETS)
def test_identified_motor_is_near_the_datasheet(name):
    values = MotorSection.model_validate(yaml.safe_load(library()[name].read_text(encoding="utf-8"))).values
    torque, speed = SHEETS[name]
    assert values["effort"].value == pytest.approx(torque, rel=0.25)
    assert values["velocity"].value == pytest.approx(speed * 2 * np.pi / 60, rel=0.1)


def test_our_sts3215_is_that_of_the_so101():
    """Its MJCF has the same motor with the back-EMF in the joint's damping, to fewer digits."""
    file = SHARED / "data/robots/so101/Simulation/SO101/joints_properties.xml"
    if not file.exists():
        pytest.skip("there are no shared data")
    theirs = ET.parse(file).find("default[@class='sts3215']")
    turn, servo = theirs.find("joint"), theirs.find("position")
    model = driven_model(pendulum(), {"motor": "sts3215"})
    for key, value in (
        ("armature", model.dof_armature[0]), ("damping", model.dof_damping[0]),
        ("frictionloss", model.dof_frictionloss[0]),
    ):  # fmt: skip
        assert value == pytest.approx(float(turn.get(key)), rel=0.02)
    assert model.actuator_gainprm[0][0] == pytest.approx(float(servo.get("kp")), rel=0.01)
    assert model.jnt_actfrcrange[0][1] == pytest.approx(float(servo.get("forcerange").split()[1]), rel=0.01)
