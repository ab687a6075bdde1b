"""Chooses the form of a robot's URDF from the configuration."""

from dataclasses import replace
from typing import TYPE_CHECKING

from linkwright.stages.formats.urdf.form import UrdfForm
from linkwright.stages.formats.urdf.urdf_robot import urdf_form
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.robot import Robot

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections
    from linkwright.stages.export.urdf.section import UrdfFormatSection


def form_of(robot: Robot, keys: "ExportSections", actuation: Actuation) -> UrdfForm:
    """Returns the differences between the robot and its URDF. Driven dofs are preferred as drivers of
    relations."""
    urdf = keys.export.urdf
    driven_dofs = [actuator.dof for actuator in actuation.actuators]
    driven_dofs += [transmission.joint for transmission in robot.transmissions]
    form = urdf_form(robot, urdf is not None and urdf.fixed_joints == "merge", driven_dofs)
    return form if urdf is None else replace(form, package=package_of(urdf, robot.name))


def package_of(keys: "UrdfFormatSection", robot: str) -> str:
    """Returns the package by which the URDF of a robot of this name refers to its meshes; "" for relative
    paths."""
    return keys.package or robot if keys.meshes == "package" else ""
