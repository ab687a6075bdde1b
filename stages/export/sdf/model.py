"""Writes the model of a robot as SDF 1.9, in one file.

Element rules are those of sdformat's 1.9 specification, except `<mimic>`, which is that of 1.11: sdformat 12
ignores it in a file of 1.9, and reports errors for a file of 1.11. A link stands in the frame of the joint
that carries it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from linkwright.stages.export.sdf.bodies import write_colliders, write_link, write_pose, write_shapes
from linkwright.stages.export.sdf.contacts import SdfContacts
from linkwright.stages.export.sdf.joints import write_joint
from linkwright.stages.export.sdf.lowering import SdfJoints
from linkwright.stages.export.sdf.section import SdfFormatSection
from linkwright.stages.export.sdf.sensors import SdfSensor, Sensors, write_sensor
from linkwright.stages.formats.sdf.names import SdfNames
from linkwright.stages.formats.xml import Element, element, to_bytes
from linkwright.stages.robot.dynamics.inertia import TINY_INERTIAL
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Array, Robot
from linkwright.stages.robot.text.names import free_name

VERSION = "1.9"
"""Version of SDF: the newest that Gazebo Fortress and Debian 12 read."""


@dataclass(frozen=True, slots=True, eq=False)
class SdfPlan:
    """The names, joints, sensors and contacts of a robot's SDF."""

    names: SdfNames
    lowered: SdfJoints
    sensors: Sensors
    contacts: SdfContacts

    world_from_root: Array
    """The pose (4, 4) of the model."""


def write_sdf(robot: Robot, geometry: Geometry, keys: SdfFormatSection, plan: SdfPlan) -> bytes:
    """Returns the robot as SDF, with the paths of meshes as `keys` choose."""
    names, lowered = plan.names, plan.lowered
    root = element(None, "sdf", version=VERSION)
    root_link = names.links[robot.root.name]
    model = element(root, "model", name=robot.name, canonical_link=root_link)
    write_pose(model, plan.world_from_root)
    if plan.contacts.collides:
        element(model, "self_collide").text = "true"
    assets = "assets/" if keys.meshes == "relative" else f"model://{robot.name}/assets/"
    carriers = {joint.child: joint for joint in lowered.joints if joint.carries_child}
    shapes = geometry.with_whole_visuals.by_link()
    for link in robot.links:
        sdf_name = names.links[link.name]
        # SDF has no links without mass.
        inertial = link.inertial if link.inertial.mass > 0 else TINY_INERTIAL
        node = write_link(model, sdf_name, inertial, carriers, lowered)
        sibling_names: set[str] = set()
        write_shapes(node, shapes[link.name, "visual"], "visual", assets, sibling_names)
        colliders = write_colliders(
            node, link.name, shapes[link.name, "collision"], assets, sibling_names, plan.contacts.masks
        )
        for sensor in plan.sensors.mounted:
            if sensor.link == link.name and not sensor.is_on_joint:
                _write_placed_sensor(node, sensor, sibling_names, colliders)
    for name in lowered.added_links:
        write_link(model, name, TINY_INERTIAL, carriers, lowered)
    if robot.base.fixed:
        base = element(model, "joint", name=names.base_joint, type="fixed")
        element(base, "parent").text = "world"
        element(base, "child").text = root_link
    load_sensors: dict[str, list[SdfSensor]] = {}
    for sensor in plan.sensors.mounted:
        if sensor.is_on_joint:
            load_sensors.setdefault(names.links[sensor.link], []).append(sensor)
    for joint in lowered.joints:
        node = write_joint(model, joint)
        sibling_names = set()
        for sensor in load_sensors.get(joint.child, ()) if joint.carries_child else ():
            _write_placed_sensor(node, sensor, sibling_names, (), relative_to=joint.child)
    for frame in robot.frames:
        node = element(model, "frame", name=names.frames[frame.name], attached_to=names.links[frame.link])
        write_pose(node, frame.link_from_frame)
    return to_bytes(root)


def write_config(robot: str) -> bytes:
    """Returns the file `model.config`, by which Gazebo finds the SDF in a folder."""
    root = element(None, "model")
    element(root, "name").text = robot
    element(root, "version").text = "1.0"
    element(root, "sdf", version=VERSION).text = f"{robot}.sdf"
    element(root, "description").text = f"The robot {robot}"
    return to_bytes(root)


def _write_placed_sensor(
    parent: Element,
    sensor: SdfSensor,
    sibling_names: set[str],
    colliders: Sequence[str],
    relative_to: str | None = None,
) -> None:
    """Writes a sensor with its pose, under a name that no sibling has."""
    name = free_name(sensor.name, sibling_names)
    sibling_names.add(name)
    node = write_sensor(parent, sensor, name, colliders)
    write_pose(node, sensor.link_from_sensor, relative_to)
