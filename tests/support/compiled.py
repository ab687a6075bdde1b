"""Compiled models of MJCF texts written by hand, as a check gets them."""

from pathlib import Path
from typing import Any

import mujoco

from linkwright.stages.formats.mjcf.form import MjcfForm
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.validate.compiled import CompiledModel
from tests.support.robots import robot_with


def compiled_of(bodies: str, robot: Robot | None = None, *, more: str = "", **known: Any) -> CompiledModel:
    """The model of these bodies of the world, with `more` elements beside them, without any of a robot.
    `known`: as in `Written`."""
    text = f"<mujoco><worldbody>{bodies}</worldbody>{more}</mujoco>"
    model = mujoco.MjModel.from_xml_string(text)
    robot = robot or robot_with([], root="base")
    written = Written(robot, mjcf_form=MjcfForm((), robot.mjcf), **known)
    return CompiledModel(Path("scene.xml"), model, written)


def only(checks: Any, name: str) -> Check:
    """The result of this name, whatever the file."""
    (found,) = [one for one in checks if one.name == f"scene.xml: {name}"]
    return found
