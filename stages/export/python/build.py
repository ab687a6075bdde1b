"""Writes the files of the Python package."""

from linkwright.stages.export import VERSION
from linkwright.stages.export.package_names import package_of
from linkwright.stages.export.python.package import text_files
from linkwright.stages.export.python.section import PythonFormatSection, import_name
from linkwright.stages.export.writer import FormatFiles, WriterInput
from linkwright.stages.formats.robot_json.files import PackageRecord

FOLDER = "python"
"""The package's folder in the output."""


def write(inputs: WriterInput) -> FormatFiles:
    """Returns the files of the package, with copies of robot.json and of the files of all other formats."""
    robot = inputs.written.robot.name
    keys = inputs.keys.export.python or PythonFormatSection()
    package, folder = _names(inputs)
    module = import_name(package)
    data = {f"{module}/{folder}/{path}": text for path, text in inputs.files.items()}
    files = {
        **text_files(package, robot, folder, keys, inputs.files),
        f"{module}/py.typed": b"",
        **data,
    }
    return FormatFiles({f"{FOLDER}/{path}": text for path, text in files.items()})


def package_record(inputs: WriterInput) -> dict[str, PackageRecord]:
    """Returns the record of the package for robot.json, which the package contains."""
    package, folder = _names(inputs)
    path_in_output = f"{FOLDER}/{import_name(package)}/{folder}"
    return {"python": PackageRecord(package, VERSION, path_in_output)}


def _names(inputs: WriterInput) -> tuple[str, str]:
    """Returns the name of the package, and the name of the folder with the robot's files in its module."""
    robot, urdf = inputs.written.robot.name, inputs.keys.export.urdf
    keys = inputs.keys.export.python or PythonFormatSection()
    # A reader that resolves package://NAME looks for a folder with that name.
    in_package = urdf is not None and urdf.meshes == "package"
    folder = (urdf.package if urdf is not None and in_package else None) or robot
    return keys.package or package_of(robot), folder
