"""The export stage: a robot and its geometry become files, and the same input gives the same bytes."""

from collections.abc import Collection
from typing import TYPE_CHECKING

from stages.export.mjcf import MjcfWriter
from stages.export.urdf import UrdfWriter
from stages.export.writer import Exported, Writer, WriterInput

if TYPE_CHECKING:
    from stages.export.keys import ExportKeys
    from stages.robot.geometry import Geometry
    from stages.robot.model import Robot

VERSION = 6
"""Grows with every change of what this stage makes of the same input."""

WRITERS: tuple[Writer, ...] = (
    UrdfWriter(),
    MjcfWriter(),
)
"""All formats, in the order in which they are written."""


def expected_paths(keys: "ExportKeys", robot: str) -> list[str]:
    """The paths of the files of a robot of this name, before they are made. The names of the meshes are
    not known by then: a glob stands for them."""
    chosen = [writer for writer in WRITERS if writer.name in keys.export.chosen]
    return ["robot.json", "assets/*", *(path for writer in chosen for path in writer.paths(robot))]


def export(robot: "Robot", geometry: "Geometry", keys: "ExportKeys") -> Exported:
    """The robot's files in every chosen format, sorted by path. A diagnostic names each thing that a
    format cannot express."""
    from stages.export.robot_json import describe
    from stages.export.start_pose import starting_point

    start = starting_point(robot)
    written: dict[str, Exported] = {}
    for writer in _needed(keys.export.chosen):
        files = {path: data for name in writer.reads for path, data in written[name].files.items()}
        written[writer.name] = writer.write(WriterInput(robot, geometry, keys, start, files))
    exported = [written[writer.name] for writer in WRITERS if writer.name in keys.export.chosen]
    files = {f"assets/{name}": data for name, data in geometry.files.items()}
    files["robot.json"] = describe(robot, start)
    for one in exported:
        files |= one.files
    diagnostics = tuple(diagnostic for one in exported for diagnostic in one.diagnostics)
    return Exported(dict(sorted(files.items())), diagnostics)


def _needed(chosen: Collection[str]) -> list[Writer]:
    """The writers of the chosen formats and of those that they read, in the order of the table."""
    needed: list[Writer] = []
    names = set(chosen)
    for writer in reversed(WRITERS):
        if writer.name in names:
            needed.insert(0, writer)
            names |= set(writer.reads)
    return needed
