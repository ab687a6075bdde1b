"""Writes the MJCF of the robot alone, `<name>.xml` (the scene around it is another file).

Elements and attributes follow MuJoCo's XML reference. Each body has the `inertial` of CAD; geoms have no
mass. Orientation is always `quat`.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from linkwright.stages.export.configuration.mujoco_section import ROBOT_FILE_OPTIONS
from linkwright.stages.export.mjcf.actuators import write_actuation
from linkwright.stages.export.mjcf.bodies import BodyWriter, asset_name
from linkwright.stages.export.mjcf.contact.contacts import write_contacts
from linkwright.stages.export.mjcf.contact.filters import Filters
from linkwright.stages.export.mjcf.defaults.classes import write_classes
from linkwright.stages.export.mjcf.keyframes import write_keyframes
from linkwright.stages.export.mjcf.loops import MAX_IMPEDANCE, Closures, stable_solref
from linkwright.stages.export.mjcf.sections import restore_source_order, write_sections
from linkwright.stages.export.mjcf.sensing.cameras import carried_cameras, write_camera
from linkwright.stages.export.mjcf.sensing.sites import write_sites_and_cameras
from linkwright.stages.export.mjcf.settings import attribute_text
from linkwright.stages.export.paints import Paint, materials
from linkwright.stages.formats.numbers import TURN, number, spaced
from linkwright.stages.formats.xml import Element, element, to_bytes
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS, MjcfExtras
from linkwright.stages.robot.model.robot import Configuration, Relation, Robot, Value
from linkwright.stages.robot.text.names import free_name

if TYPE_CHECKING:
    from linkwright.stages.export.writer import WriterInput

RELATION_SOLREF = (0.005, 1.0)
"""Time constant [s] and damping ratio of relations: the default of loops."""


def write_mjcf(inputs: "WriterInput", contact_filters: Filters) -> bytes:
    """Returns the content of `<name>.xml`. Its qpos0 is the robot's `start`: values of the dofs of the tree
    and of the loops. `contact_filters`: the contact filters of the links that have bodies."""
    written, timestep = inputs.written, inputs.keys.scene.option.timestep
    robot, geometry, actuation = written.as_mjcf.robot, written.shapes, written.actuation
    root = element(None, "mujoco", model=robot.name)
    textures = "assets" if any(shape.texture for shape in geometry.shapes) else None
    element(root, "compiler", angle="radian", meshdir="assets", texturedir=textures, autolimits="true")
    extras = written.extras
    _option(root, inputs.keys.scene.option, extras)
    # MuJoCo's outermost class is `main`; `visual` and `collision` are inside the robot's class.
    reserved_classes = {"main", "visual", "collision"}
    robot_class = free_name(robot.name, reserved_classes)
    class_element = _defaults(root, robot_class, geometry.self_contact)
    material_names = _assets(root, geometry)
    closures = Closures(robot)
    world = element(root, "worldbody")
    world_from_root = inputs.standing.placed(written.start)
    bodies = BodyWriter(world, written, world_from_root, material_names, closures, contact_filters.bits)
    bodies.write()
    cameras = inputs.keys.scene.cameras
    for link, frames in carried_cameras(robot, cameras).items():
        body, body_from_link = bodies.elements[link]
        for name, link_from_frame in frames:
            write_camera(body, name, cameras[name], body_from_link @ link_from_frame)
    write_sites_and_cameras(bodies.elements, written.as_mjcf.held, written.sensing)
    bodies.write_mounted()
    for body in world.iterchildren("body"):
        body.set("childclass", robot_class)
    write_contacts(root, contact_filters, bodies.colliders, bodies.contacts)
    _equalities(root, robot, written.start, closures, timestep)
    write_actuation(root, actuation, written.sensing.sensors, extras)
    motors = {
        actuator.dof: actuator.motor
        for actuator in actuation.actuators
        if actuator.motor and actuator.dof not in actuation.overridden
    }
    write_classes(root, class_element, {robot_class, *reserved_classes}, motors)
    write_sections(root, extras.sections)
    restore_source_order(root, extras)
    if not extras.moves_in_scene:
        write_keyframes(root, inputs)
    return to_bytes(root)


def _option(root: Element, option: Any, extras: MjcfExtras) -> None:
    """Writes the options that affect stability, and those of an MJCF source. The scene has the others."""
    names = {*ROBOT_FILE_OPTIONS, *dict(extras.option)}
    option_element = element(
        root,
        "option",
        **{name: attribute_text(value) for name, value in option.explicit().items() if name in names},
    )
    flags = {name: value for name, value in option.flag.explicit().items() if name in dict(extras.flag)}
    if flags:
        element(option_element, "flag", **flags)


def _defaults(root: Element, robot_class: str, self_contact: bool) -> Element:
    """Writes the robot's own class, with the classes of visual and collision geoms, and returns its element.

    Bits: all colliders collide with the geoms of the scene (bit 1). They collide with each other only with
    `self_contact`: otherwise `contype` 1 and `conaffinity` 2 have no bit in common.
    """
    class_element = element(element(root, "default"), "default", class_=robot_class)
    visual = element(class_element, "default", class_="visual")
    element(visual, "geom", type="mesh", group="2", contype="0", conaffinity="0", density="0")
    collision = element(class_element, "default", class_="collision")
    bits = "1" if self_contact else "2"
    element(collision, "geom", type="mesh", group="3", contype="1", conaffinity=bits, density="0")
    return class_element


def _assets(root: Element, geometry: Geometry) -> dict[Paint, str]:
    """Writes textures, materials and meshes, and returns the names of the materials."""
    asset = element(root, "asset")
    material_names = materials(geometry)
    for texture in sorted({texture for _, texture in material_names if texture}):
        element(asset, "texture", type="2d", name=asset_name(texture), file=texture)
    for (colour, texture), name in material_names.items():
        texture_name = asset_name(texture) if texture else None
        element(asset, "material", name=name, texture=texture_name, rgba=spaced(colour))
    visual_files = {shape.file for shape in geometry.shapes if shape.role == "visual"}
    files = (shape.file for shape in geometry.shapes if shape.ellipsoid is None)
    for file in dict.fromkeys(file for file in files if file is not None):
        # Geoms have no mass here, so the volume of a mesh does not matter; "shell" accepts open meshes.
        element(asset, "mesh", file=file, inertia="shell" if file in visual_files else None)
    return material_names


def _equalities(
    root: Element, robot: Robot, start: Configuration, closures: Closures, timestep: float
) -> None:
    """Writes loops as equalities of sites, and relations as equalities of joints."""
    if not robot.loops and not robot.relations:
        return
    equality = element(root, "equality")
    extras = (robot.mjcf or NO_EXTRAS).attributes_of("equality")
    closures.write_equalities(equality, timestep, extras)
    for relation in robot.relations:
        stiffness = {"solref": spaced(stable_solref(RELATION_SOLREF, timestep)), "solimp": MAX_IMPEDANCE}
        _relation(equality, relation, start, extras.get(relation.name), stiffness)


def _relation(
    equality: Element,
    relation: Relation,
    start: Configuration,
    source_attributes: Mapping[str, str] | None,
    stiffness: Mapping[str, str],
) -> None:
    """Writes a relation in MuJoCo's form, relative to qpos0: y − y₀ = a₀ + a₁ (x − x₀). `source_attributes`:
    the attributes of its stiffness in an MJCF source. Without these, the relation is solved for the joint for
    which |a₁| ≥ 1, and has the attributes `stiffness`.

    MuJoCo scales the constraint by the inverse inertias of both joints, but not by a₁: with |a₁| < 1 a screw,
    or a motor behind a gearbox, would slip under load.
    """
    y, x, factor, offset = relation.follower, relation.driver, relation.multiplier, relation.offset
    if source_attributes is None and 0.0 < abs(factor) < 1.0:
        y, x, factor, offset = x, y, 1 / factor, -offset / factor
    constant = factor * _scalar(start[x]) + offset - _scalar(start[y])
    # If qpos0 satisfies the relation, the constant is rounding noise on the scale of the joint values.
    scale = abs(_scalar(start[y]))
    element(
        equality,
        "joint",
        name=relation.name,
        joint1=y,
        joint2=x,
        polycoef=f"{number(constant, scale, TURN)} {number(factor)} 0 0 0",
        **(source_attributes or stiffness),
    )


def _scalar(value: Value) -> float:
    """Returns the value [rad or m] of a turn or slide."""
    assert not isinstance(value, tuple), "only turns and slides are related"
    return value
