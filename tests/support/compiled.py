"""Compiled models of MJCF texts written by hand, as a check gets them."""

from pathlib import Path

import mujoco

from linkwright.stages.formats.mjcf.form import MjcfForm
from linkwright.stages.formats.written import Written
from linkwright.stages.validate.compiled import CompiledModel
from tests.support.robots import joint, robot_with

ONE_HINGE = robot_with([joint("revolute", "base", "arm")])


def compiled_of(text, robot=ONE_HINGE, geometry=None):
    """What a check gets of this MJCF."""
    model = mujoco.MjModel.from_xml_string(text)
    return CompiledModel(Path("robot.xml"), model, Written(robot, geometry=geometry))


def world_of(bodies, robot=None, *, more="", **forms):
    """The model of these bodies of the world, with `more` elements beside them, without any of a robot.
    `known`: as in `Written`."""
    text = f"<mujoco><worldbody>{bodies}</worldbody>{more}</mujoco>"
    model = mujoco.MjModel.from_xml_string(text)
    robot = robot or robot_with([], root="base")
    written = Written(robot, mjcf_form=MjcfForm((), robot.mjcf), **forms)
    return CompiledModel(Path("scene.xml"), model, written)


def only(checks, name):
    """The result of this name, whatever the file."""
    (check,) = [check for check in checks if check.name == f"scene.xml: {name}"]
    return check
