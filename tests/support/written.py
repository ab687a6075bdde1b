"""Models written by hand, as the checks of the validate stage get them."""

from pathlib import Path

import mujoco

from linkwright.stages.formats.written import Written
from linkwright.stages.validate.compiled import CompiledModel
from tests.support.robots import joint, robot_with

ONE_HINGE = robot_with([joint("revolute", "base", "arm")])


def compiled_of(text, robot=ONE_HINGE, geometry=None):
    """What a check gets of this MJCF."""
    model = mujoco.MjModel.from_xml_string(text)
    return CompiledModel(Path("robot.xml"), model, Written(robot, geometry=geometry))
