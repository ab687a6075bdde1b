"""A number that is not a number (NaN) fails the check that compares it, whatever the other numbers are."""

import math

import numpy as np
import pytest

from linkwright.stages.validate.checks.mechanism import loops, parity, placement
from linkwright.stages.validate.checks.world import keyframes, sensors
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.engines import mujoco_engine
from tests.support.building import plan_of, write
from tests.support.robots import joint, robot_with
from tests.unit.export.test_urdf_mimic import parallelogram


@pytest.fixture
def built(tmp_path):
    """A free base with two arms, and a site on each."""
    robot = robot_with([joint("revolute", "base", "first"), joint("revolute", "base", "second")], fixed=False)
    sites = {name: {"type": "imu", "frame": name} for name in ("first", "second")}
    exported = write(robot, tmp_path, plan_of(sensors=sites))
    path = tmp_path / "robot.xml"
    return CompiledModel(path, mujoco_engine.load(path).model, exported.written)


def results(check, compiled):
    return {result.name.partition(": ")[2]: result for result in check(compiled)}


def test_keyframe_and_placement(built):
    model = built.model
    assert all(result.passed for check in (keyframes.check, placement.check) for result in check(built))
    for key in range(model.nkey):
        model.key_qpos[key][2] = np.nan
    assert not results(placement.check, built)["placement in keyframes"].passed
    home = model.key("home").id
    model.key_qpos[home][2], model.key_qpos[home][-1] = 0.0, np.nan
    assert not results(keyframes.check, built)["keyframe home"].passed


def test_mass_matrix(built):
    assert results(parity.check, built)["parity in MuJoCo"].passed
    built.model.body_inertia[-1] = np.nan
    assert not results(parity.check, built)["parity in MuJoCo"].passed


def test_place_of_the_last_sensor(built):
    assert results(sensors.check, built)["places of sensors"].passed
    built.model.site_pos[-1] = np.nan
    assert not results(sensors.check, built)["places of sensors"].passed


def test_gap_of_a_loop_of_a_urdf(tmp_path, monkeypatch):
    robot = parallelogram(limits=True)
    written = write(robot, tmp_path).written
    path = tmp_path / f"{robot.name}.urdf"
    compiled = CompiledModel(path, mujoco_engine.load(path).model, written)
    assert results(loops.check, compiled)["loops"].passed
    monkeypatch.setattr(loops, "gap", lambda *_: math.nan)
    assert not results(loops.check, compiled)["loops"].passed
