"""Writes all files of the format, from what the other modules of this room make of the robot."""

from linkwright.stages.export.sdf.contacts import sdf_contacts
from linkwright.stages.export.sdf.lowering import lower
from linkwright.stages.export.sdf.model import SdfPlan, write_config, write_sdf
from linkwright.stages.export.sdf.section import SdfFormatSection
from linkwright.stages.export.sdf.sensors import sensors_of
from linkwright.stages.export.writer import Case, FormatFiles, WriterInput
from linkwright.stages.formats.robot_json.files import FormatRecord, RenamedRecord
from linkwright.stages.formats.robot_json.values import as_value
from linkwright.stages.formats.sdf.names import sdf_names


def write(given: WriterInput) -> FormatFiles:
    """The files of the format, with what they lose of the robot."""
    written, plan = given.written, _plan(given)
    model, config = SdfFormatSection.paths(written.robot.name)
    keys = given.keys.export.sdf or SdfFormatSection()
    files = {
        model: write_sdf(written.robot, written.shapes, keys, plan),
        config: write_config(written.robot.name),
    }
    case = Case("sdf", written, written.robot, model, plan)
    return FormatFiles(files, (case,), record={"sdf": _record(plan)})


def _record(plan: SdfPlan) -> FormatRecord:
    """What robot.json tells of the SDF."""
    zeros = {name: as_value(value) for name, value in plan.lowered.moved.items()}
    return FormatRecord(RenamedRecord.from_model(plan.names), zeros)


def _plan(given: WriterInput) -> SdfPlan:
    robot, geometry = given.written.robot, given.written.shapes
    names = sdf_names(robot)
    lowered = lower(robot, given.written.start, names)
    # Engines leave out by themselves what a joint of their tree joins, but not what closes a loop.
    link = {own: name for name, own in names.links.items()}
    tree = [joint for joint in lowered.joints if joint.carries and {joint.parent, joint.child} <= link.keys()]
    joined = {frozenset((link[joint.parent], link[joint.child])) for joint in tree}
    held = [joint.child for joint in robot.joints if joint.type != "free"]
    solid = sorted({shape.link for shape in geometry.shapes if shape.role == "collision"})
    return SdfPlan(
        names,
        lowered,
        sensors_of(robot, given.written.sensing, held, solid),
        sdf_contacts(geometry, joined),
        given.standing.placed(lowered.stands),
    )
