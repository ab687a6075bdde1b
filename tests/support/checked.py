"""The checks of a robot's files, of which a test says no more than it needs."""

from dataclasses import replace

import pytest

from linkwright.stages.formats.described import read_robot_json
from linkwright.stages.formats.mjcf import written as mjcf_written
from linkwright.stages.formats.urdf.urdf_robot import urdf_form
from linkwright.stages.formats.written import Written
from linkwright.stages.validate import validate
from linkwright.stages.validate.srdf.read_back import check_file
from tests.support.building import plan_of, write


def checked(folder, robot, keys, **forms):
    """The checks of the files in `folder`. `known`: as in `Written`; by default the URDF has what closed
    loops ask for, and in the MJCF links on fixed joints are part of others."""
    if "urdf_form" not in forms:  # to find it takes seconds where loops are closed
        forms["urdf_form"] = urdf_form(robot)
    if "mjcf_form" not in forms:
        forms["mjcf_form"] = mjcf_written.mjcf_form(robot)
    return validate(folder, Written(robot, **forms), keys)


def srdf_checks(folder):
    """The checks of `robot.srdf` in a folder, against its robot.json alone."""
    truth = read_robot_json((folder / "robot.json").read_bytes())
    return list(check_file(folder / "robot.srdf", replace(truth.written, srdf_form=None), quick=False))


def failures(folder, robot):
    """Writes a robot into `folder`; the checks that fail. Readiness, which never fails, is left out."""
    write(robot, folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("linkwright.stages.validate.run.readiness", lambda *_: ())
        return [check for check in checked(folder, robot, plan_of()) if check.fails]
