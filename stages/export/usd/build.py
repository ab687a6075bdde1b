"""Writes all files of the format USD."""

from linkwright.stages.export.usd.joints import added_links, usd_joints
from linkwright.stages.export.usd.metadata import METADATA_KEY, metadata
from linkwright.stages.export.usd.model import UsdPlan, usd_layer
from linkwright.stages.export.usd.section import UsdFormatSection
from linkwright.stages.export.usd.shapes import meshes_layer
from linkwright.stages.export.writer import Case, FormatFiles, WriterInput
from linkwright.stages.formats.robot_json.files import FormatRecord, NameChangesRecord
from linkwright.stages.formats.usd.drives import drives_of
from linkwright.stages.formats.usd.names import usd_names
from linkwright.stages.formats.usd.zeros import ball_zeros
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.show.preview.ask import thumbnail
from linkwright.stages.show.preview.from_model import look_of_model


def write(inputs: WriterInput) -> FormatFiles:
    """Writes the files of the format, with the data for finding its losses. Without a thumbnail it reports
    the reason (I-USD-THUMBNAIL)."""
    robot, geometry, plan = inputs.written.robot, inputs.written.shapes, _plan(inputs)
    keys = inputs.keys.export.usd or UsdFormatSection()
    model_path, meshes_path, picture_path = UsdFormatSection.paths(robot.name)
    meshes_file, meshes = meshes_layer(geometry, meshes_path)
    layer = usd_layer(robot, geometry, plan, meshes)
    body_count = len(robot.links) + len(added_links(robot, plan.names, plan.joints))
    size = inputs.standing.high - inputs.standing.low
    layer.describe(METADATA_KEY, metadata(robot, keys, body_count, size))
    files = {model_path: layer.bytes(), meshes_path: meshes_file.bytes(keys.geometry)}
    picture_or_reason = _picture(inputs)
    diagnostics: tuple[Diagnostic, ...] = ()
    if isinstance(picture_or_reason, bytes):
        files[picture_path] = picture_or_reason
    else:
        text = f"no thumbnail, which the profiles of SimReady ask for: {picture_or_reason}"
        diagnostics = (
            Diagnostic("I-USD-THUMBNAIL", text, model_path, "put a picture of 256 x 256 pixels there"),
        )
    case = Case("usd", inputs.written, robot, model_path, plan)
    return FormatFiles(files, (case,), diagnostics, _record(plan))


def _picture(inputs: WriterInput) -> bytes | str:
    """Returns a picture of the robot at `home`, as the bytes of a PNG, or the reason why there is no
    picture."""
    robot, world_from_root = inputs.written.robot, inputs.standing.world_from_root
    poses = {link: world_from_root @ pose for link, pose in link_poses(robot, home(robot)).items()}
    return thumbnail(look_of_model(robot, inputs.written.shapes, poses))


def _record(plan: UsdPlan) -> dict[str, FormatRecord]:
    """Returns the entry of the USD in `robot.json`: names and zeros that differ from the robot's."""
    renamed = NameChangesRecord.from_model(plan.names) if any(plan.names.changed_names()) else None
    record = FormatRecord(renamed, plan.ball_zeros or None)
    return {} if record == FormatRecord() else {"usd": record}


def _plan(inputs: WriterInput) -> UsdPlan:
    """Returns the names, joints, actuators and poses with which the robot is written, at `home`."""
    robot = inputs.written.robot
    names = usd_names(robot)
    at_home = home(robot)
    zeros = ball_zeros(robot, at_home)
    return UsdPlan(
        names,
        usd_joints(robot, names, zeros),
        drives_of(robot, inputs.written.actuation, at_home),
        inputs.written.actuation.actuators,
        inputs.written.sensing,
        at_home,
        zeros,
        inputs.standing.world_from_root,
    )
