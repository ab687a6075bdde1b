"""The main flow of the export stage: what drives, measures and shows the robot, then writer after writer."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace

from linkwright.stages.export.actuators.advice import advice
from linkwright.stages.export.actuators.gravity import gravity_of
from linkwright.stages.export.amend.amend import Amended, amended
from linkwright.stages.export.amend.documents import ROLES as AMENDABLE
from linkwright.stages.export.driven import driven
from linkwright.stages.export.ground.standing import Stance, stand
from linkwright.stages.export.losses import losses
from linkwright.stages.export.losses.mjcf_only import mjcf_only
from linkwright.stages.export.mjcf.form import form_of as mjcf_form_of
from linkwright.stages.export.order_tables import order_of
from linkwright.stages.export.python.build import package_record
from linkwright.stages.export.readers import dropped
from linkwright.stages.export.robot_json import describe
from linkwright.stages.export.scene import scene_of
from linkwright.stages.export.section import FORMATS, ExportSections
from linkwright.stages.export.sensors.measure import sensing_of
from linkwright.stages.export.settled import settled
from linkwright.stages.export.urdf.form import form_of
from linkwright.stages.export.writer import Exported, FormatFiles, WriterInput
from linkwright.stages.export.writers import WRITERS
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.dynamics.driven import as_driven
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Robot

PACKAGES = ("ros2",)
"""Formats that pack the files of others, as the user's own XML leaves them, with the meshes."""

OF_ALL = ("python",)
"""Those that pack robot.json, too."""


def build(
    robot: Robot, geometry: Geometry, keys: ExportSections, texts: Mapping[str, str] | None = None
) -> Exported:
    """The robot's files in every chosen format, sorted by path. A diagnostic names each thing that a
    format cannot express. `texts`: of the files that `elements` name, by entry."""
    keys = settled(keys, robot)
    standing = stand(robot, geometry, keys)
    written, remarks = _written(robot, geometry, keys, standing)
    given = WriterInput(written, keys, standing)
    made: dict[str, FormatFiles] = {}
    needed = _needed(keys.export.chosen)
    alone = [name for name in needed if name not in (*PACKAGES, *OF_ALL)]
    for name in alone:
        writer = WRITERS[name]
        own = {path: data for other in writer.reads for path, data in made[other].files.items()}
        made[name] = writer.write(replace(given, files=own))
    assets = {f"assets/{name}": data for name, data in geometry.files.items()}
    mine = _amended(assets | _files(made, alone), robot.name, alone, keys, texts or {})
    every = {**assets, **_files(made, alone), **mine.files}
    for name in [name for name in PACKAGES if name in needed]:
        made[name] = WRITERS[name].write(replace(given, files=every))
    order = order_of(written, every)
    record = {key: table for one in made.values() for key, table in one.record.items()}
    if "python" in needed:
        record |= package_record(given)
    written = replace(written, amendments=mine.amendments)
    paths = {*assets, *_files(made, [name for name in keys.export.chosen if name in made])}
    every["robot.json"] = describe(written, order, record, paths)
    for name in [name for name in OF_ALL if name in needed]:
        made[name] = WRITERS[name].write(replace(given, files=every))
    files = {**assets, "robot.json": every["robot.json"], **_files(made, keys.export.chosen)}
    files |= {path: data for path, data in mine.files.items() if path in files}
    diagnostics = [diagnostic for name in needed for diagnostic in _diagnostics(made[name])]
    diagnostics += mjcf_only(written, needed)
    found = (*diagnostics, *standing.diagnostics, *remarks, *mine.diagnostics)
    tip = advice(written.robot, written.actuation, standing.world_from_root, gravity_of(keys.scene.option))
    readers = dropped(written.robot, geometry, needed)
    return Exported(dict(sorted(files.items())), found, written, tip, order, readers)


def _written(
    robot: Robot, geometry: Geometry, keys: ExportSections, standing: Stance
) -> tuple[Written, tuple[Diagnostic, ...]]:
    """The robot as its files will have it, before the user's own XML; and what is worth knowing about what
    drives and measures it."""
    written = Written(robot, geometry=geometry, mjcf_form=mjcf_form_of(robot, geometry, keys))
    actuation, of_actuators = driven(written, keys, standing)
    robot = as_driven(robot, actuation)
    sensing, of_sensors = sensing_of(robot, geometry, actuation, keys, written.mjcf_form.fused)
    written = replace(
        written,
        robot=robot,
        actuation=actuation,
        urdf_form=form_of(robot, keys, actuation),
        sensing=sensing,
        scene=scene_of(robot, keys, standing, written.start),
    )
    return written, (*of_actuators, *of_sensors)


def _diagnostics(made: FormatFiles) -> Iterator[Diagnostic]:
    """The losses of a format, and what else is worth knowing of it."""
    for case in made.cases:
        yield from losses(case)
    yield from made.diagnostics


def _files(made: Mapping[str, FormatFiles], names: Collection[str]) -> dict[str, bytes]:
    """The files of these formats."""
    return {path: data for name in names for path, data in made[name].files.items()}


def _amended(
    files: Mapping[str, bytes],
    robot: str,
    written: Collection[str],
    keys: ExportSections,
    texts: Mapping[str, str],
) -> Amended:
    """The files with the user's own XML. `written`: the formats."""
    if not keys.elements and not keys.attributes:
        return Amended({})
    formats = {name: FORMATS[name].paths(robot) for name in written if name in AMENDABLE}
    return amended(files, formats, keys, texts)


def _needed(chosen: Collection[str]) -> list[str]:
    """The chosen formats and those that their writers read, in the order of the table."""
    needed = set(chosen)
    for name in reversed(WRITERS):
        if name in needed:
            needed |= set(WRITERS[name].reads)
    return [name for name in WRITERS if name in needed]
