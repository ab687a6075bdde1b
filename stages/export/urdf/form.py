"""The form of a robot's URDF, as the configuration wants it."""

from dataclasses import replace
from typing import TYPE_CHECKING

from linkwright.stages.formats.urdf.as_written import form_with
from linkwright.stages.formats.urdf.form import UrdfForm
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Robot

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections
    from linkwright.stages.export.urdf.section import UrdfFormatSection


def form_of(robot: Robot, keys: "ExportSections", actuation: Actuation) -> UrdfForm:
    """How the robot's URDF differs from the robot. What is driven rather drives others than follows them."""
    urdf = keys.export.urdf
    driven = [one.dof for one in actuation.actuators]
    driven += [one.joint for one in robot.transmissions]
    form = form_with(robot, urdf is not None and urdf.fixed_joints == "merge", driven)
    return form if urdf is None else replace(form, package=package_of(urdf, robot.name))


def package_of(keys: "UrdfFormatSection", robot: str) -> str:
    """The package by which the URDF of a robot of this name names its meshes; "" for paths."""
    return keys.package or robot if keys.meshes == "package" else ""
