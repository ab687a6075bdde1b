"""Writes all files of the format SDF."""

from linkwright.stages.export.sdf.contacts import sdf_contacts
from linkwright.stages.export.sdf.lowering import lower
from linkwright.stages.export.sdf.model import SdfPlan, write_config, write_sdf
from linkwright.stages.export.sdf.section import SdfFormatSection
from linkwright.stages.export.sdf.sensors import sensors_of
from linkwright.stages.export.writer import Case, FormatFiles, WriterInput
from linkwright.stages.formats.robot_json.files import FormatRecord, NameChangesRecord
from linkwright.stages.formats.robot_json.values import as_value
from linkwright.stages.formats.sdf.names import sdf_names


def write(inputs: WriterInput) -> FormatFiles:
    """Returns the files of the format, and the case by which their losses are found."""
    written, plan = inputs.written, _plan(inputs)
    model, config = SdfFormatSection.paths(written.robot.name)
    keys = inputs.keys.export.sdf or SdfFormatSection()
    files = {
        model: write_sdf(written.robot, written.shapes, keys, plan),
        config: write_config(written.robot.name),
    }
    case = Case("sdf", written, written.robot, model, plan)
    return FormatFiles(files, (case,), record={"sdf": _record(plan)})


def _record(plan: SdfPlan) -> FormatRecord:
    """Returns the entry of the SDF in robot.json."""
    zeros = {name: as_value(value) for name, value in plan.lowered.nonzero_values.items()}
    return FormatRecord(NameChangesRecord.from_model(plan.names), zeros)


def _plan(inputs: WriterInput) -> SdfPlan:
    """Returns the parts of the robot in terms of SDF."""
    robot, geometry = inputs.written.robot, inputs.written.shapes
    names = sdf_names(robot)
    lowered = lower(robot, inputs.written.start, names)
    # Engines exclude contact of links that a joint of their tree joins, but not of those that close a loop.
    links = {sdf_name: name for name, sdf_name in names.links.items()}
    tree = [
        joint
        for joint in lowered.joints
        if joint.carries_child and {joint.parent, joint.child} <= links.keys()
    ]
    joined = {frozenset((links[joint.parent], links[joint.child])) for joint in tree}
    jointed_links = [joint.child for joint in robot.joints if joint.type != "free"]
    links_with_colliders = sorted({shape.link for shape in geometry.shapes if shape.role == "collision"})
    return SdfPlan(
        names,
        lowered,
        sensors_of(robot, inputs.written.sensing, jointed_links, links_with_colliders),
        sdf_contacts(geometry, joined),
        inputs.standing.placed(lowered.stance),
    )
