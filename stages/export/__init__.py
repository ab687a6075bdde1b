"""The export stage: a robot and its geometry become files, and the same input gives the same bytes.

- build: The main flow of the export stage: what drives, measures and shows the robot, then writer after
  writer.
- driven: What drives the robot that is written, and the armatures with which its simulation holds.
- order_tables: The order of things in the files of a robot, as robot.json and the report have it.
- package_names: The names of packages that hold a robot.
- paints: The materials of a robot: a colour, or an image times a colour.
- provenance: Where the limits and dynamics of a dof come from.
- readers: What other readers drop from our files: one table, for the documentation and for the report of a
  build.
- requirements: What the installed packages must have for an export.
- rewrite_packages: The packages of a finished build, written again from its robot.json and from the files
  beside them.
- robot_json: robot.json: writes what `stages.formats.robot_json` says that it has.
- scene: The scene of the configuration.
- section: Configuration of the export stage: formats, ground, scene.
- settled: The configuration with what an MJCF source says where the configuration says nothing.
- unknown_names: What `actuators`, `sensors` and `scene.cameras` ask of a robot that it does not have.
- writer: The interface of the writers of all formats.
- writers: The table of formats.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from linkwright.stages.export.writer import Exported

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections
    from linkwright.stages.robot.model.geometry import Geometry
    from linkwright.stages.robot.model.robot import Robot

VERSION = 60
"""Grows with every change of what this stage makes of the same input."""


def export(
    robot: "Robot", geometry: "Geometry", keys: "ExportSections", texts: Mapping[str, str] | None = None
) -> Exported:
    """The robot's files in every chosen format, sorted by path. A diagnostic names each thing that a
    format cannot express. `texts`: of the files that `elements` name, by entry."""
    from linkwright.stages.export.build import build  # the version alone is read without the writers

    return build(robot, geometry, keys, texts)
