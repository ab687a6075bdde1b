"""Lists the joints, actuators and sensors of a robot's files in file order, for robot.json and the report."""

from collections.abc import Mapping

from linkwright.stages.export.order.of_mjcf import MjcfOrder
from linkwright.stages.export.order.of_urdf import urdf_rows
from linkwright.stages.export.urdf.lowering import lower
from linkwright.stages.formats.robot_json.files import OrderRecord, UrdfOrderRecord
from linkwright.stages.formats.written import Written
from linkwright.stages.formats.xml import Element, Malformed, parse


def order_of(written: Written, files: Mapping[str, bytes]) -> OrderRecord | None:
    """Returns, for each of MJCF and URDF that is among `files`, its joints in file order, and for the MJCF
    its actuators and sensors too; None without both. An MJCF that is nested too deeply to be parsed has no
    table."""
    robot = written.robot
    mates = {dof.name: joint.mate.name for joint in robot.joints if joint.mate for dof in joint.dofs}
    mates |= {dof.name: loop.mate.name for loop in robot.loops for dof in loop.dofs}
    joints = _urdf_joints(written)
    of_mjcf, of_urdf = None, None
    mjcf, urdf = files.get(f"{robot.name}.xml"), files.get(f"{robot.name}.urdf")
    root = None if mjcf is None else _parsed(mjcf)
    if root is not None:
        urdf_joints = joints if urdf is not None else {}
        of_mjcf = MjcfOrder(root, robot, written.actuation, mates, urdf_joints).record()
    if urdf is not None:
        dofs = {name: dof for dof, names in joints.items() for name in names}
        of_urdf = UrdfOrderRecord(tuple(urdf_rows(parse(urdf, large=True), dofs, mates)))
    return OrderRecord(of_mjcf, of_urdf) if of_mjcf or of_urdf else None


def _parsed(mjcf: bytes) -> Element | None:
    """Returns the root of an MJCF; None if it is nested too deeply."""
    try:
        return parse(mjcf, large=True)
    except Malformed:
        return None


def _urdf_joints(written: Written) -> dict[str, list[str]]:
    """Returns, by dof, the joints of the URDF that represent it, from parent to child."""
    robot, turns = written.as_urdf.robot, written.urdf_names.turns
    moving = {joint.name for item in lower(robot) for joint in item.joints}
    joints_of_dof = {dof.name: list(turns.get(dof.name, (dof.name,))) for dof in robot.dofs}
    return {dof: names for dof, names in joints_of_dof.items() if moving.issuperset(names)}
