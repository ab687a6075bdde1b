"""Runs the export stage: actuators, sensors and scene, then writer after writer."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace

from linkwright.stages.export.actuators.advice import advice
from linkwright.stages.export.actuators.gravity import gravity_of
from linkwright.stages.export.amend.amend import Amended, amend
from linkwright.stages.export.amend.documents import ROLES as AMENDABLE
from linkwright.stages.export.driven import stable_actuation
from linkwright.stages.export.ground.standing import Placement, stand
from linkwright.stages.export.losses import losses
from linkwright.stages.export.losses.mjcf_only import mjcf_only
from linkwright.stages.export.mjcf.form import form_of as mjcf_form_of
from linkwright.stages.export.order_tables import order_of
from linkwright.stages.export.python.build import package_record
from linkwright.stages.export.robot_json import describe
from linkwright.stages.export.scene import scene_of
from linkwright.stages.export.section import FORMATS, ExportSections
from linkwright.stages.export.sensors.measure import sensing_of
from linkwright.stages.export.settled import report_changes, settle
from linkwright.stages.export.urdf.form import form_of
from linkwright.stages.export.variants.build import make_variants
from linkwright.stages.export.writer import Exported, FormatFiles, WriterInput
from linkwright.stages.export.writers import WRITERS
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.dynamics.driven import with_actuation
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.text.globs import name_list
from linkwright.stages.targets.diagnostic import replacement_diagnostic
from linkwright.stages.targets.options import REPLACEABLE_ACTUATORS, actuation_of, targets_replacing
from linkwright.stages.targets.things import reader_rows_of_robot

PACKAGES = ("ros2",)
"""Formats that pack the files of other formats, with the user's own XML in them, and the meshes."""

PACKAGES_WITH_ROBOT_JSON = ("python",)
"""Formats that pack robot.json, too."""

GLB_FORMATS = frozenset({"urdf", "sdf", "ros2"})
"""Formats that show a link's visual meshes as one GLB, if the geometry has it."""

MESH_FORMATS = frozenset({"mjcf", "usd"})
"""Formats that show the meshes themselves: MuJoCo reads no GLB, and a USD has the triangles in it."""


def build(
    robot: Robot, geometry: Geometry, keys: ExportSections, texts: Mapping[str, str] | None = None
) -> Exported:
    """Returns the robot's files in every chosen format, sorted by path. A diagnostic names each thing that a
    format cannot express. `texts`: entry of `elements` → the text of the file that it names."""
    keys, changed = settle(keys, robot), [*report_changes(keys, robot)]
    standing = stand(robot, geometry, keys)
    written, remarks = _written(robot, geometry, keys, standing)
    inputs = WriterInput(written, keys, standing)
    outputs: dict[str, FormatFiles] = {}
    needed = _needed(keys.export.chosen)
    separate = [name for name in needed if name not in (*PACKAGES, *PACKAGES_WITH_ROBOT_JSON)]
    for name in separate:
        writer = WRITERS[name]
        files_to_read = {path: data for other in writer.reads for path, data in outputs[other].files.items()}
        outputs[name] = writer.write(replace(inputs, files=files_to_read))
    shown = geometry.shown(meshes=bool(MESH_FORMATS & {*needed}), whole=bool(GLB_FORMATS & {*needed}))
    assets = {f"assets/{name}": data for name, data in shown.files.items()}
    amendments = _amended(assets | _files(outputs, separate), robot.name, separate, keys, texts or {})
    all_files = {**assets, **_files(outputs, separate), **amendments.files}
    for name in [name for name in PACKAGES if name in needed]:
        outputs[name] = WRITERS[name].write(replace(inputs, files=all_files))
    order = order_of(written, all_files)
    record = {key: table for format_files in outputs.values() for key, table in format_files.record.items()}
    if "python" in needed:
        record |= package_record(inputs)
    written = replace(written, amendments=amendments.amendments)
    variants = make_variants(written, keys, all_files)
    all_files |= variants.files
    record |= variants.record
    paths = {
        *assets,
        *variants.files,
        *_files(outputs, [name for name in keys.export.chosen if name in outputs]),
    }
    all_files["robot.json"] = describe(replace(written, geometry=shown), order, record, paths)
    for name in [name for name in PACKAGES_WITH_ROBOT_JSON if name in needed]:
        outputs[name] = WRITERS[name].write(replace(inputs, files=all_files))
    files = {
        **assets,
        "robot.json": all_files["robot.json"],
        **_files(outputs, keys.export.chosen),
    }
    files |= {path: data for path, data in amendments.files.items() if path in files} | dict(variants.files)
    diagnostics = [diagnostic for name in needed for diagnostic in _diagnostics(outputs[name])]
    diagnostics += mjcf_only(written, needed)
    all_diagnostics = (
        *diagnostics,
        *changed,
        *standing.diagnostics,
        *remarks,
        *amendments.diagnostics,
        *variants.diagnostics,
    )
    tip = advice(written.robot, written.actuation, standing.world_from_root, gravity_of(keys.scene.option))
    readers = reader_rows_of_robot(written.robot, geometry, needed, keys.target.versions)
    return Exported(
        dict(sorted(files.items())), all_diagnostics, written, tip, order, readers, variants.summary
    )


def _written(
    robot: Robot, geometry: Geometry, keys: ExportSections, standing: Placement
) -> tuple[Written, tuple[Diagnostic, ...]]:
    """Returns the robot as its files will have it, without the user's own XML, and the diagnostics of its
    actuators and sensors."""
    written = Written(robot, geometry=geometry, mjcf_form=mjcf_form_of(robot, geometry, keys))
    own_actuation, actuator_diagnostics = stable_actuation(written, keys, standing)
    actuation = actuation_of(keys.target.chosen, own_actuation)
    replacement_diagnostics = _report_replaced_actuators(keys, own_actuation, actuation)
    robot = with_actuation(robot, actuation)
    sensing, sensor_diagnostics = sensing_of(robot, geometry, actuation, keys, written.mjcf_form)
    written = replace(
        written,
        robot=robot,
        actuation=actuation,
        urdf_form=form_of(robot, keys, actuation),
        sensing=sensing,
        scene=scene_of(robot, keys, standing, written.start),
    )
    return written, (*actuator_diagnostics, *replacement_diagnostics, *sensor_diagnostics)


def _report_replaced_actuators(
    keys: ExportSections, before: Actuation, after: Actuation
) -> Iterator[Diagnostic]:
    """Reports the actuators that are written in another form for a target (I-TARGET)."""
    pairs = [*zip(before.actuators, after.actuators, strict=True)]
    for kind, thing in REPLACEABLE_ACTUATORS.items():
        changed = [(old.name, new.type) for old, new in pairs if old.type == kind != new.type]
        if changed:
            names = name_list(name for name, _ in changed)
            text = f"actuators have another form with the same force, {kind} → {changed[0][1]}: {names}"
            yield replacement_diagnostic(text, targets_replacing(keys.target.chosen, thing))


def _diagnostics(format_files: FormatFiles) -> Iterator[Diagnostic]:
    """Yields the losses of a format, and its other diagnostics."""
    for case in format_files.cases:
        yield from losses(case)
    yield from format_files.diagnostics


def _files(outputs: Mapping[str, FormatFiles], names: Collection[str]) -> dict[str, bytes]:
    """Returns the files of the formats with these names."""
    return {path: data for name in names for path, data in outputs[name].files.items()}


def _amended(
    files: Mapping[str, bytes],
    robot: str,
    format_names: Collection[str],
    keys: ExportSections,
    texts: Mapping[str, str],
) -> Amended:
    """Returns the files that the user's own XML changes. `files`: path → content, with the meshes;
    `format_names`: the written formats; `texts`: entry of `elements` → the text of the file that it names."""
    if not keys.elements and not keys.attributes:
        return Amended({})
    formats = {name: FORMATS[name].paths(robot) for name in format_names if name in AMENDABLE}
    return amend(files, formats, keys, texts)


def _needed(chosen: Collection[str]) -> list[str]:
    """Returns the chosen formats and the formats that their writers read, in the order of the table."""
    needed = set(chosen)
    for name in reversed(WRITERS):
        if name in needed:
            needed |= set(WRITERS[name].reads)
    return [name for name in WRITERS if name in needed]
