"""Writes all files of the format, from what the other modules of this room make of the robot."""

from linkwright.stages.export.usd.joints import usd_joints
from linkwright.stages.export.usd.model import UsdPlan, write_usd
from linkwright.stages.export.usd.section import UsdFormatSection
from linkwright.stages.export.usd.shapes import meshes_layer
from linkwright.stages.export.writer import Case, FormatFiles, WriterInput
from linkwright.stages.formats.robot_json.files import FormatRecord, RenamedRecord
from linkwright.stages.formats.usd.drives import drives_of
from linkwright.stages.formats.usd.names import usd_names
from linkwright.stages.formats.usd.zeros import ball_zeros
from linkwright.stages.robot.motion.start_pose import home


def write(given: WriterInput) -> FormatFiles:
    """The files of the format, with what they lose of the robot."""
    robot, geometry, plan = given.written.robot, given.written.shapes, _plan(given)
    keys = given.keys.export.usd or UsdFormatSection()
    model, meshes = UsdFormatSection.paths(robot.name)
    layer, places = meshes_layer(geometry)
    files = {
        model: write_usd(robot, geometry, plan, places, meshes).bytes(),
        meshes: layer.bytes(keys.geometry),
    }
    case = Case("usd", given.written, robot, model, plan)
    return FormatFiles(files, (case,), record=_record(plan))


def _record(plan: UsdPlan) -> dict[str, FormatRecord]:
    """What `robot.json` tells of the USD: names and zeros that are not the robot's."""
    renamed = RenamedRecord.from_model(plan.names) if any(plan.names.changed) else None
    told = FormatRecord(renamed, plan.zeros or None)
    return {} if told == FormatRecord() else {"usd": told}


def _plan(given: WriterInput) -> UsdPlan:
    robot = given.written.robot
    names = usd_names(robot)
    at_home = home(robot)
    zeros = ball_zeros(robot, at_home)
    return UsdPlan(
        names,
        usd_joints(robot, names, zeros),
        drives_of(robot, given.written.actuation, at_home),
        given.written.sensing,
        at_home,
        zeros,
        given.standing.world_from_root,
    )
