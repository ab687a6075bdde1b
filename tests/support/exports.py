"""The files of a robot, in memory, and MuJoCo's model of them."""

from typing import Any

import mujoco

from linkwright.stages.export import Exported, export
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Robot
from tests.support.building import NO_MESHES, plan_of


def exported(robot: Robot, geometry: Geometry = NO_MESHES, **keys: Any) -> Exported:
    """The export of a robot with these keys of the configuration (`plan_of`)."""
    return export(robot, geometry, plan_of(**keys))


def compiled(outcome: Exported) -> mujoco.MjModel:
    """The exported MJCF and its meshes as MuJoCo compiles them."""
    text = outcome.files[f"{outcome.written.robot.name}.xml"].decode()
    meshes = {path: data for path, data in outcome.files.items() if not path.endswith(".xml")}
    return mujoco.MjModel.from_xml_string(text, meshes)


def messages_of(outcome: Exported, code: str) -> list[str]:
    """The messages of the diagnostics with this code."""
    return [diagnostic.message for diagnostic in outcome.diagnostics if diagnostic.code == code]
