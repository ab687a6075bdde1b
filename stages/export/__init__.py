"""The export stage: one robot and its geometry become files, byte for byte the same every time."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stages.robot.errors import Diagnostic

if TYPE_CHECKING:
    from stages.export.keys import ExportKeys
    from stages.robot.geometry import Geometry
    from stages.robot.model import Robot

VERSION = 5


@dataclass(frozen=True, slots=True)
class Exported:
    """`files`: path below the output folder → bytes, sorted by path."""

    files: Mapping[str, bytes]
    diagnostics: tuple[Diagnostic, ...]


def foreseen(keys: "ExportKeys", name: str) -> list[str]:
    """The paths of the files of a robot of that name, as far as they are known before it is: of meshes
    the folder alone, as a glob."""
    files = ["robot.json", "assets/*"]
    if keys.export.urdf is not None:
        files.append(f"{name}.urdf")
    if keys.export.mjcf is not None:
        files += [f"{name}.xml", "scene.xml"]
    return files


def export(robot: "Robot", geometry: "Geometry", keys: "ExportKeys") -> Exported:
    """Writes every chosen format; what a format cannot say is told in a diagnostic."""
    from stages.export.mjcf.model import write_mjcf
    from stages.export.mjcf.scene import write_scene
    from stages.export.robot_json import describe
    from stages.export.start_pose import starting_point
    from stages.export.urdf.model import write_urdf

    start = starting_point(robot)
    files = {f"assets/{name}": data for name, data in geometry.files.items()}
    files["robot.json"] = describe(robot, start)
    diagnostics: list[Diagnostic] = []
    if keys.export.urdf is not None:
        files[f"{robot.name}.urdf"] = write_urdf(robot, geometry, diagnostics)
    if keys.export.mjcf is not None:
        files[f"{robot.name}.xml"] = write_mjcf(robot, geometry, keys, start, diagnostics)
        files["scene.xml"] = write_scene(robot, keys)
    return Exported(dict(sorted(files.items())), tuple(diagnostics))
