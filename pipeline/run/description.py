"""Writes `robot.json` of a build that stops before the export."""

from linkwright.pipeline.config.plan import Plan
from linkwright.stages.export.mjcf.form import form_of as mjcf_form_of
from linkwright.stages.export.robot_json import describe
from linkwright.stages.export.urdf.form import form_of
from linkwright.stages.formats.written import NO_SHAPES, Written
from linkwright.stages.robot.dynamics.measuring import available_sensors
from linkwright.stages.robot.model.actuation import NONE
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.model.sensing import Sensing


def description(robot: Robot, plan: Plan) -> bytes:
    """Returns the content of `robot.json`: the robot without meshes and drives, and with only the sensors of
    its source."""
    written = Written(
        robot,
        urdf_form=form_of(robot, plan, NONE),
        mjcf_form=mjcf_form_of(robot, NO_SHAPES, plan),
        sensing=Sensing(available_sensors(robot, NONE)),
    )
    return describe(written)
