"""Writes the packages of a finished build again, from its robot.json and its other files."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from linkwright.stages.export.ground.standing import Placement
from linkwright.stages.export.section import ExportSections
from linkwright.stages.export.urdf.model import write_urdf
from linkwright.stages.export.urdf.srdf.model import plan_of, write_srdf
from linkwright.stages.export.writer import WriterInput
from linkwright.stages.export.writers import WRITERS
from linkwright.stages.formats.described import Truth
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.model.poses import UNMOVED

ASSETS = "assets/"

NO_PLACEMENT = Placement(
    UNMOVED, np.full(3, -np.inf), np.full(3, np.inf), lambda values, keyframe="": UNMOVED
)
"""Placement for packages: RViz derives only the distance of its camera from it."""


def package_again(truth: Truth, name: str, files: Mapping[str, bytes]) -> Mapping[str, bytes]:
    """Returns path → content of the package of the format `name`, as robot.json records it. `files`: path →
    content of the build's files outside of packages. Settings that robot.json does not record, such as the
    maintainer, get their defaults."""
    meshes = {path.removeprefix(ASSETS): data for path, data in files.items() if path.startswith(ASSETS)}
    written = replace(truth.written, geometry=replace(truth.written.shapes, files=meshes))
    if name == "ros2":
        files = {**_missing_descriptions(written, files), **files}
    return WRITERS[name].write(WriterInput(written, _keys(truth), NO_PLACEMENT, files)).files


def _keys(truth: Truth) -> ExportSections:
    """Returns the keys of the packages, and of the URDF if its meshes are in a package."""
    sections: dict[str, dict[str, Any]] = {
        name: {"package": record.package} for name, record in truth.packages.items()
    }
    if "ros2" in sections:
        sections["ros2"]["moveit"] = any(path.endswith("/.setup_assistant") for path in truth.files)
    package = truth.written.urdf_form.package
    if package:
        sections["urdf"] = {"meshes": "package", "package": package}
    return ExportSections.model_validate({"export": sections})


def _missing_descriptions(written: Written, files: Mapping[str, bytes]) -> dict[str, bytes]:
    """Returns the URDF and the SRDF for the ROS package, unless they are among `files`."""
    robot = written.robot
    urdf, srdf = f"{robot.name}.urdf", f"{robot.name}.srdf"
    descriptions = {}
    if urdf not in files:
        descriptions[urdf] = write_urdf(written)
    if srdf not in files:
        descriptions[srdf] = write_srdf(robot, plan_of(written))
    return descriptions
