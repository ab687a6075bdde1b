"""The form of a robot's URDF, as the configuration wants it."""

from typing import TYPE_CHECKING

from stages.formats.urdf.form import UrdfForm
from stages.robot.model import Robot

if TYPE_CHECKING:
    from stages.export.keys import ExportKeys


def form_of(robot: Robot, keys: "ExportKeys") -> UrdfForm:
    """How the robot's URDF differs from the robot."""
    urdf = keys.export.urdf
    return UrdfForm(merged=urdf is not None and urdf.fixed_joints == "merge")
