"""Models written by hand, as the checks of the validate stage get them."""

from pathlib import Path

import mujoco

from linkwright.stages.formats.written import Written
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.validate.compiled import CompiledModel
from tests.support.robots import joint, robot_with

ONE_HINGE = robot_with([joint("revolute", "base", "arm")])


def compiled_of(text: str, robot: Robot = ONE_HINGE, geometry: Geometry | None = None) -> CompiledModel:
    """What a check gets of this MJCF."""
    model = mujoco.MjModel.from_xml_string(text)
    return CompiledModel(Path("robot.xml"), model, Written(robot, geometry=geometry))
