"""Pendulums that an actuator drives, and their simulation."""

import numpy as np
import pytest

from linkwright.stages.robot.errors import ExportError
from linkwright.stages.robot.model.robot import Dynamics, Inertial, Limits, frozen
from tests.support.exports import compiled, exported
from tests.support.hands import ACROSS
from tests.support.robots import joint, robot_with
from tests.support.states import run, state

ARM, MASS, GRAVITY = 0.3, 2.0, 9.81


def lump(mass, *com):
    return Inertial(mass, frozen(com), frozen(np.eye(3) * mass * 1e-4))


def pendulum(saved=0.0, **dynamics):
    """A turn about −y with a mass `MASS` at `ARM` along x: its weight at q is m g l cos q."""
    limits = {"arm_joint": Limits(-1.0, 1.0)}
    swing = joint(
        "revolute", "base", "arm", [saved], place=ACROSS, limits=limits, dynamics=Dynamics(**dynamics)
    )
    return robot_with([swing], inertials={"arm": lump(MASS, ARM, 0, 0)})


def both(**dynamics):
    """A slide upwards, and on it the pendulum."""
    limits = {"lift": Limits(0.0, 0.2), "arm_joint": Limits(-1.0, 1.0)}
    more = {"limits": limits, "dynamics": Dynamics(**dynamics)}
    lift = joint("prismatic", "base", "column", [0.1], name="lift", **more)
    swing = joint("revolute", "column", "arm", [0.0], place=ACROSS, **more)
    return robot_with([lift, swing], inertials={"column": lump(1.0, 0, 0, 0), "arm": lump(MASS, ARM, 0, 0)})


def actuation(robot, **actuators):
    driven = exported(robot, actuators=actuators).written.actuation
    assert driven is not None
    return driven


def at_home(model, seconds):
    """The state after some time at the keyframe `home`, its controls held."""
    return run(model, state(model, "home"), seconds)


def targeted(model, seconds):
    """The state after some time from `home`, where the target of each servo is the pose itself."""
    data = state(model, "home")
    data.ctrl[:], data.act[:] = data.actuator_length, 0.0
    return run(model, data, seconds)


def problem(robot, **actuators):
    with pytest.raises(ExportError) as error:
        exported(robot, actuators=actuators)
    (only,) = error.value.problems
    return only.code, only.message, only.hint


def driven_model(robot, entry, **keys):
    """The compiled model of a robot with this entry of `actuators` for all of its dofs."""
    return compiled(exported(robot, actuators={"*": entry}, **keys))
