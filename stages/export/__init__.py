"""The export stage: a robot and its geometry become files, and the same input gives the same bytes."""

from collections.abc import Collection, Mapping
from dataclasses import replace
from importlib import import_module
from typing import TYPE_CHECKING

from stages.export.writer import Exported, Writer, WriterInput

if TYPE_CHECKING:
    from stages.export.amend.amend import Amended
    from stages.export.keys import ExportKeys
    from stages.robot.geometry import Geometry
    from stages.robot.model import Robot

VERSION = 59
"""Grows with every change of what this stage makes of the same input."""

WRITERS = (
    "urdf",
    "mjcf",
    "sdf",
    "ros2",
    "usd",
    "python",
)
"""All formats, in the order in which they are written: folders of this stage, each with its `Writer`."""

PACKAGES = ("ros2",)
"""Those that pack the files of others, as the user's own XML leaves them, with the meshes."""

OF_ALL = ("python",)
"""Those that pack robot.json, too."""


def writer_of(name: str) -> Writer:
    """The writer of a format."""
    found: Writer = import_module(f"stages.export.{name}.writer").WRITER
    return found


def expected_paths(keys: "ExportKeys", robot: str) -> list[str]:
    """The paths of the files of a robot of this name, before they are made. The names of the meshes are
    not known by then: a glob stands for them."""
    paths = [path for name in keys.export.chosen for path in writer_of(name).paths(robot)]
    return ["robot.json", "assets/*", *paths]


def export(
    robot: "Robot", geometry: "Geometry", keys: "ExportKeys", texts: Mapping[str, str] | None = None
) -> Exported:
    """The robot's files in every chosen format, sorted by path. A diagnostic names each thing that a
    format cannot express. `texts`: of the files that `elements` name, by entry."""
    from stages.export.actuators.advice import advice
    from stages.export.actuators.gravity import gravity_of
    from stages.export.driven import driven
    from stages.export.mjcf.form import form_of as mjcf_form_of
    from stages.export.mjcf_only import mjcf_only
    from stages.export.order_tables import order_tables
    from stages.export.python.writer import package_record
    from stages.export.readers import dropped
    from stages.export.robot_json import describe
    from stages.export.scene_records import scene_of
    from stages.export.sensors.resolve import sensing_of
    from stages.export.settled import settled
    from stages.export.standing import stand
    from stages.export.urdf.form import form_of
    from stages.robot.driven import as_driven
    from stages.robot.start_pose import starting_point

    keys = settled(keys, robot)
    start, standing = starting_point(robot), stand(robot, geometry, keys)
    actuation, remarks = driven(robot, geometry, keys, start, standing)
    robot = as_driven(robot, actuation)
    form, mjcf_form = form_of(robot, keys, actuation), mjcf_form_of(robot, geometry, keys)
    sensing, of_sensors = sensing_of(robot, geometry, actuation, keys, mjcf_form.fused)
    given = WriterInput(robot, geometry, keys, start, {}, actuation, standing, form, mjcf_form, sensing)
    written: dict[str, Exported] = {}
    needed = _needed(keys.export.chosen)
    alone = [name for name in needed if name not in (*PACKAGES, *OF_ALL)]
    for name in alone:
        writer = writer_of(name)
        own = {path: data for other in writer.reads for path, data in written[other].files.items()}
        written[name] = writer.write(replace(given, files=own))
    assets = {f"assets/{name}": data for name, data in geometry.files.items()}
    mine = _amended(assets | _files(written, alone), robot.name, alone, keys, texts or {})
    every = {**assets, **_files(written, alone), **mine.files}
    for name in [name for name in PACKAGES if name in needed]:
        written[name] = writer_of(name).write(replace(given, files=every))
    order = order_tables(robot, actuation, form, every)
    told = {key: table for one in written.values() for key, table in one.record.items()}
    if "python" in needed:
        told |= package_record(given)
    known = actuation, form, mjcf_form, sensing, order, mine.amendments, told
    paths = {*assets, *_files(written, [name for name in keys.export.chosen if name in written])}
    scene = scene_of(robot, keys, standing, start)
    every["robot.json"] = describe(robot, start, *known, geometry, paths, scene)
    for name in [name for name in OF_ALL if name in needed]:
        written[name] = writer_of(name).write(replace(given, files=every))
    files = {**assets, "robot.json": every["robot.json"], **_files(written, keys.export.chosen)}
    files |= {path: data for path, data in mine.files.items() if path in files}
    diagnostics = [diagnostic for name in needed for diagnostic in written[name].diagnostics]
    diagnostics += mjcf_only(robot, geometry, mjcf_form.extras, needed)
    remarks = (*diagnostics, *standing.diagnostics, *remarks, *of_sensors, *mine.diagnostics)
    tip = advice(robot, actuation, standing.world_from_root, gravity_of(keys.scene.option))
    what = actuation, tip, form, mjcf_form, order, sensing, mine.amendments
    others = dropped(robot, geometry, needed)
    return Exported(dict(sorted(files.items())), remarks, *what, readers=others, scene=scene)


def _files(written: Mapping[str, Exported], names: Collection[str]) -> dict[str, bytes]:
    """The files of these formats."""
    return {path: data for name in names for path, data in written[name].files.items()}


def _amended(
    files: Mapping[str, bytes],
    robot: str,
    written: Collection[str],
    keys: "ExportKeys",
    texts: Mapping[str, str],
) -> "Amended":
    """The files with the user's own XML. `written`: the formats."""
    from stages.export.amend.amend import Amended, amended
    from stages.export.amend.documents import ROLES as AMENDABLE

    if not keys.elements and not keys.attributes:
        return Amended({})
    formats = {name: writer_of(name).paths(robot) for name in written if name in AMENDABLE}
    return amended(files, formats, keys, texts)


def _needed(chosen: Collection[str]) -> list[str]:
    """The chosen formats and those that their writers read, in the order of the table."""
    needed = set(chosen)
    for name in reversed(WRITERS):
        if name in needed:
            needed |= set(writer_of(name).reads)
    return [name for name in WRITERS if name in needed]
