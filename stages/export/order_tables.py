"""The order of things in the files of a robot, as robot.json and the report have it."""

from collections.abc import Mapping

from linkwright.stages.export.order.of_mjcf import MjcfOrder
from linkwright.stages.export.order.of_urdf import urdf_rows
from linkwright.stages.export.urdf.lowering import lower
from linkwright.stages.formats.robot_json.files import OrderRecord, UrdfOrderRecord
from linkwright.stages.formats.written import Written
from linkwright.stages.formats.xml import Element, Malformed, parse


def order_of(written: Written, files: Mapping[str, bytes]) -> OrderRecord | None:
    """For each format that is among `files`: its joints, and of the MJCF its actuators and sensors, each in
    the order of the file as it is read. An MJCF that is nested more deeply than any engine reads has none."""
    robot = written.robot
    mates = {dof.name: joint.mate.name for joint in robot.joints if joint.mate for dof in joint.dofs}
    mates |= {dof.name: loop.mate.name for loop in robot.loops for dof in loop.dofs}
    joints = _urdf_joints(written)
    of_mjcf, of_urdf = None, None
    mjcf, urdf = files.get(f"{robot.name}.xml"), files.get(f"{robot.name}.urdf")
    root = None if mjcf is None else _parsed(mjcf)
    if root is not None:
        there = joints if urdf is not None else {}
        of_mjcf = MjcfOrder(root, robot, written.actuation, mates, there).record()
    if urdf is not None:
        dofs = {name: dof for dof, names in joints.items() for name in names}
        of_urdf = UrdfOrderRecord(tuple(urdf_rows(parse(urdf, large=True), dofs, mates)))
    return OrderRecord(of_mjcf, of_urdf) if of_mjcf or of_urdf else None


def _parsed(mjcf: bytes) -> Element | None:
    try:
        return parse(mjcf, large=True)
    except Malformed:
        return None


def _urdf_joints(written: Written) -> dict[str, list[str]]:
    """By dof: the joints of the URDF that stand for it, from parent to child."""
    robot, turns = written.as_urdf.robot, written.urdf_names.turns
    moving = {joint.name for item in lower(robot) for joint in item.joints}
    every = {dof.name: list(turns.get(dof.name, (dof.name,))) for dof in robot.dofs}
    return {dof: names for dof, names in every.items() if moving.issuperset(names)}
