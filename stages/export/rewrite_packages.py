"""The packages of a finished build, written again from its robot.json and from the files beside them."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from linkwright.stages.export.ground.standing import Stance
from linkwright.stages.export.section import ExportSections
from linkwright.stages.export.urdf.model import write_urdf
from linkwright.stages.export.urdf.srdf.model import plan_of, write_srdf
from linkwright.stages.export.writer import WriterInput
from linkwright.stages.export.writers import WRITERS
from linkwright.stages.formats.described import Truth
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.model.poses import UNMOVED

ASSETS = "assets/"

NOWHERE = Stance(UNMOVED, np.full(3, -np.inf), np.full(3, np.inf), lambda values, keyframe="": UNMOVED)
"""Where the robot stands, of which a package only has how far RViz looks from."""


def package_again(truth: Truth, name: str, files: Mapping[str, bytes]) -> Mapping[str, bytes]:
    """The files by path of the package of this format, of which the robot.json tells. `files`: those of the
    build that are in no package, by path. What the user sets in a package, as who maintains it, has its
    default."""
    meshes = {path.removeprefix(ASSETS): data for path, data in files.items() if path.startswith(ASSETS)}
    written = replace(truth.written, geometry=replace(truth.written.shapes, files=meshes))
    if name == "ros2":
        files = {**_described(written, files), **files}
    return WRITERS[name].write(WriterInput(written, _keys(truth), NOWHERE, files)).files


def _keys(truth: Truth) -> ExportSections:
    """Those of the packages, and of the URDF where its meshes are in a package."""
    sections: dict[str, dict[str, Any]] = {
        name: {"package": record.package} for name, record in truth.packages.items()
    }
    if "ros2" in sections:
        sections["ros2"]["moveit"] = any(path.endswith("/.setup_assistant") for path in truth.files)
    package = truth.written.urdf_form.package
    if package:
        sections["urdf"] = {"meshes": "package", "package": package}
    return ExportSections.model_validate({"export": sections})


def _described(written: Written, files: Mapping[str, bytes]) -> dict[str, bytes]:
    """The URDF and the SRDF that the package of ROS is made of, where a build leaves none beside it."""
    robot = written.robot
    urdf, srdf = f"{robot.name}.urdf", f"{robot.name}.srdf"
    found = {}
    if urdf not in files:
        found[urdf] = write_urdf(written)
    if srdf not in files:
        found[srdf] = write_srdf(robot, plan_of(written))
    return found
