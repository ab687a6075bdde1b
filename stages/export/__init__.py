"""The export stage: a robot and its geometry become files, and the same input gives the same bytes.

- build: Runs the export stage: actuators, sensors and scene, then writer after writer.
- driven: Builds the actuation of the written robot, with armatures that keep its simulation stable.
- order_tables: Lists the joints, actuators and sensors of a robot's files in file order, for robot.json and
  the report.
- package_names: Derives the names of packages from the name of a robot.
- paints: Names the materials of a robot: a colour, or an image times a colour.
- provenance: Tells where the limits and dynamics of a dof come from.
- requirements: Checks that the installed packages, and the chosen formats, suffice for an export.
- rewrite_packages: Writes the packages of a finished build again, from its robot.json and its other files.
- robot_json: Writes robot.json, from the records that `stages.formats.robot_json` defines.
- scene: Builds the scene around the robot from the configuration.
- section: Defines the configuration of the export stage.
- settled: Completes the configuration with the settings of the MJCF source and the targets.
- unknown_names: Reports entries of `actuators`, `sensors`, `scene.cameras` and `variants` that match nothing
  of the robot.
- writer: Defines the interface of the writers of all formats, their input and their output.
- writers: Lists the writers of all formats.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from linkwright.stages.export.writer import Exported

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections
    from linkwright.stages.robot.model.geometry import Geometry
    from linkwright.stages.robot.model.robot import Robot

VERSION = 67
"""Number that grows whenever the stage gives other files for the same input."""


def export(
    robot: "Robot", geometry: "Geometry", keys: "ExportSections", texts: Mapping[str, str] | None = None
) -> Exported:
    """Returns the robot's files in every chosen format, sorted by path. A diagnostic names each thing that a
    format cannot express. `texts`: entry of `elements` → the text of the file that it names."""
    from linkwright.stages.export.build import build  # the version alone is read without the writers

    return build(robot, geometry, keys, texts)
