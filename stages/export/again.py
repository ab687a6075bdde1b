"""The packages of a finished build, written again from its robot.json and from the files beside them."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from stages.export import writer_of
from stages.export.keys import ExportKeys
from stages.export.standing import Stance
from stages.export.urdf.model import write_urdf
from stages.export.urdf.srdf.model import plan_of, write_srdf
from stages.export.writer import WriterInput
from stages.formats.described import Truth
from stages.robot.driven import as_driven
from stages.robot.geometry import Geometry
from stages.robot.model import Robot
from stages.robot.poses import UNMOVED
from stages.robot.start_pose import starting_point

ASSETS = "assets/"

NOWHERE = Stance(UNMOVED, np.full(3, -np.inf), np.full(3, np.inf), lambda values, keyframe="": UNMOVED)
"""Where the robot stands, of which a package only has how far RViz looks from."""


def package_again(truth: Truth, name: str, files: Mapping[str, bytes]) -> Mapping[str, bytes]:
    """The files by path of the package of this format, of which the robot.json tells. `files`: those of the
    build that are in no package, by path. What the user sets in a package, as who maintains it, has its
    default."""
    robot, geometry = as_driven(truth.robot, truth.actuation), truth.geometry or Geometry((), {})
    meshes = {path.removeprefix(ASSETS): data for path, data in files.items() if path.startswith(ASSETS)}
    geometry = replace(geometry, files=meshes)
    if name == "ros2":
        files = {**_described(truth, robot, geometry, files), **files}
    given = WriterInput(
        robot,
        geometry,
        _keys(truth),
        starting_point(robot),
        files,
        truth.actuation,
        NOWHERE,
        truth.form,
        truth.mjcf_form,
        truth.sensing,
    )
    return writer_of(name).write(given).files


def _keys(truth: Truth) -> ExportKeys:
    """Those of the packages, and of the URDF where its meshes are in a package."""
    sections: dict[str, dict[str, Any]] = {
        name: {"package": record.package} for name, record in truth.packages.items()
    }
    if "ros2" in sections:
        sections["ros2"]["moveit"] = any(path.endswith("/.setup_assistant") for path in truth.files)
    if truth.form.package:
        sections["urdf"] = {"meshes": "package", "package": truth.form.package}
    return ExportKeys.model_validate({"export": sections})


def _described(
    truth: Truth, robot: Robot, geometry: Geometry, files: Mapping[str, bytes]
) -> dict[str, bytes]:
    """The URDF and the SRDF that the package of ROS is made of, where a build leaves none beside it."""
    urdf, srdf = f"{robot.name}.urdf", f"{robot.name}.srdf"
    found = {}
    if urdf not in files:
        found[urdf] = write_urdf(robot, geometry, None, truth.form)
    if srdf not in files:
        plan = plan_of(robot, geometry, truth.actuation, truth.form, truth.srdf)
        found[srdf] = write_srdf(robot, plan)
    return found
