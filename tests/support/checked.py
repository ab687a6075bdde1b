"""The checks of a robot's files, of which a test says no more than it needs."""

from pathlib import Path
from typing import Any

from linkwright.stages.formats.mjcf import written as mjcf_written
from linkwright.stages.formats.urdf.as_written import form_with
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.validate import validate
from linkwright.stages.validate.section import ValidateSections


def checked(folder: Path, robot: Robot, keys: ValidateSections, **known: Any) -> tuple[Check, ...]:
    """The checks of the files in `folder`. `known`: as in `Written`; by default the URDF has what closed
    loops ask for, and in the MJCF links on fixed joints are part of others."""
    if "urdf_form" not in known:  # to find it takes seconds where loops are closed
        known["urdf_form"] = form_with(robot)
    if "mjcf_form" not in known:
        known["mjcf_form"] = mjcf_written.form_with(robot)
    return validate(folder, Written(robot, **known), keys)
