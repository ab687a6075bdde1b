"""SDF 1.9: the model of a robot, in one file.

Element rules are those of sdformat's 1.9 specification; `<mimic>` is that of 1.11: sdformat 12 takes it
as unknown in a file of 1.9, and reports errors for a file that says 1.11. A link stands in the frame of the
joint that carries it.
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
from linkwright.stages.robot.dynamics.inertia import SPECK
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Array, Robot
from linkwright.stages.robot.text.names import free

VERSION = "1.9"
"""The newest that Gazebo Fortress and Debian 12 read."""


@dataclass(frozen=True, slots=True, eq=False)
class SdfPlan:
    """How a robot is said in SDF. `world_from_root` (4, 4): where the model stands."""

    names: SdfNames
    lowered: SdfJoints
    sensors: Sensors
    contacts: SdfContacts
    world_from_root: Array


def write_sdf(robot: Robot, geometry: Geometry, keys: SdfFormatSection, plan: SdfPlan) -> bytes:
    """The robot as SDF, with the paths of meshes as `keys` choose."""
    names, lowered = plan.names, plan.lowered
    root = element(None, "sdf", version=VERSION)
    first = names.links[robot.root.name]
    model = element(root, "model", name=robot.name, canonical_link=first)
    write_pose(model, plan.world_from_root)
    if plan.contacts.collides:
        element(model, "self_collide").text = "true"
    assets = "assets/" if keys.meshes == "relative" else f"model://{robot.name}/assets/"
    carriers = {joint.child: joint for joint in lowered.joints if joint.carries}
    shapes = geometry.by_link()
    for link in robot.links:
        own = names.links[link.name]
        # SDF has no links without mass.
        body = link.inertial if link.inertial.mass > 0 else SPECK
        node = write_link(model, own, body, carriers, lowered)
        taken: set[str] = set()
        write_shapes(node, shapes[link.name, "visual"], "visual", assets, taken)
        colliders = write_colliders(
            node, link.name, shapes[link.name, "collision"], assets, taken, plan.contacts.masks
        )
        for one in plan.sensors.mounted:
            if one.link == link.name and not one.on_joint:
                _mounted(node, one, taken, colliders)
    for name in lowered.between:
        write_link(model, name, SPECK, carriers, lowered)
    if robot.base.fixed:
        base = element(model, "joint", name=names.base, type="fixed")
        element(base, "parent").text = "world"
        element(base, "child").text = first
    loads: dict[str, list[SdfSensor]] = {}
    for one in plan.sensors.mounted:
        if one.on_joint:
            loads.setdefault(names.links[one.link], []).append(one)
    for joint in lowered.joints:
        made = write_joint(model, joint)
        taken = set()
        for one in loads.get(joint.child, ()) if joint.carries else ():
            _mounted(made, one, taken, (), relative_to=joint.child)
    for frame in robot.frames:
        made = element(model, "frame", name=names.frames[frame.name], attached_to=names.links[frame.link])
        write_pose(made, frame.link_from_frame)
    return to_bytes(root)


def write_config(robot: str) -> bytes:
    """`model.config`, by which Gazebo finds the SDF of a folder."""
    root = element(None, "model")
    element(root, "name").text = robot
    element(root, "version").text = "1.0"
    element(root, "sdf", version=VERSION).text = f"{robot}.sdf"
    element(root, "description").text = f"The robot {robot}"
    return to_bytes(root)


def _mounted(
    above: Element, one: SdfSensor, taken: set[str], colliders: Sequence[str], relative_to: str | None = None
) -> None:
    """A sensor, whose name no sibling has."""
    name = free(one.name, taken)
    taken.add(name)
    node = write_sensor(above, one, name, colliders)
    write_pose(node, one.link_from_sensor, relative_to)
