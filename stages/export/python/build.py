"""Writes all files of the format, from what the other modules of this room make of the robot."""

from linkwright.stages.export import VERSION
from linkwright.stages.export.package_names import package_of
from linkwright.stages.export.python.package import text_files
from linkwright.stages.export.python.section import PythonFormatSection, module_of
from linkwright.stages.export.writer import FormatFiles, WriterInput
from linkwright.stages.formats.robot_json.files import PackageRecord

FOLDER = "python"
"""Where the package lies in the output."""


def write(given: WriterInput) -> FormatFiles:
    """Its files, with copies of all that the other formats have, and of robot.json."""
    robot = given.written.robot.name
    keys = given.keys.export.python or PythonFormatSection()
    package, folder = _names(given)
    own = module_of(package)
    data = {f"{own}/{folder}/{path}": text for path, text in given.files.items()}
    files = {
        **text_files(package, robot, folder, keys, given.files),
        f"{own}/py.typed": b"",
        **data,
    }
    return FormatFiles({f"{FOLDER}/{path}": text for path, text in files.items()})


def package_record(given: WriterInput) -> dict[str, PackageRecord]:
    """What robot.json tells of the package, which holds it."""
    package, folder = _names(given)
    place = f"{FOLDER}/{module_of(package)}/{folder}"
    return {"python": PackageRecord(package, VERSION, place)}


def _names(given: WriterInput) -> tuple[str, str]:
    """The name of the package, and that of the folder of the robot's files in its module."""
    robot, urdf = given.written.robot.name, given.keys.export.urdf
    keys = given.keys.export.python or PythonFormatSection()
    # Who looks for package:// looks for a folder of that name.
    in_package = urdf is not None and urdf.meshes == "package"
    folder = (urdf.package if urdf is not None and in_package else None) or robot
    return keys.package or package_of(robot), folder
