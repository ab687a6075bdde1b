"""MJCF: the robot alone, as `<name>.xml` (the scene around it is another file).

Element and attribute rules are those of MuJoCo's XML reference. Every body has CAD's own
`inertial`; geoms have no mass. Orientation is always `quat`.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from stages.export.mjcf.actuators import controls, states, write_actuation
from stages.export.mjcf.bodies import BodyWriter, stem
from stages.export.mjcf.cameras import carried_cameras, write_camera
from stages.export.mjcf.classes import write_classes
from stages.export.mjcf.contacts import write_contacts
from stages.export.mjcf.filters import Filters
from stages.export.mjcf.joints import free_joint_name, free_qpos, qpos
from stages.export.mjcf.loops import STIFF, Closures, held
from stages.export.mjcf.sensing import write_mounted
from stages.export.mujoco_keys import IN_THE_ROBOT
from stages.export.paints import Paint, materials
from stages.formats.mjcf_written import as_written, holders
from stages.formats.numbers import TURN, number, spaced
from stages.formats.xml import Element, element, to_bytes
from stages.robot.actuation import Actuation
from stages.robot.fusing import members
from stages.robot.geometry import Geometry
from stages.robot.model import Array, Configuration, Relation, Robot, Value
from stages.robot.names import free
from stages.robot.poses import UNMOVED
from stages.robot.start_pose import HOME, keyframes

if TYPE_CHECKING:
    from stages.export.standing import Stance
    from stages.export.writer import WriterInput

SOLREF = (0.005, 1.0)
"""Of relations: time constant [s] and damping ratio; the same as the default of loops."""


def write_mjcf(given: "WriterInput", kept_apart: Filters) -> bytes:
    """The model, whose qpos0 is `given.start` (values of the tree's dofs and of the loops' own).
    `kept_apart`: by the links that have bodies."""
    geometry, start, actuation = given.geometry, given.start, given.actuation
    held_by = holders(given.robot, given.mjcf_form)
    groups = members(given.robot, held_by)
    robot = as_written(given.robot, given.mjcf_form)
    root = element(None, "mujoco", model=robot.name)
    textures = "assets" if any(shape.texture for shape in geometry.shapes) else None
    element(root, "compiler", angle="radian", meshdir="assets", texturedir=textures, autolimits="true")
    _option(root, given.keys.scene.option)
    top = free(robot.name, {"main", "visual", "collision"})
    classes = _defaults(root, top, geometry.self_contact)
    painted = _assets(root, geometry)
    closures = Closures(robot)
    world = element(root, "worldbody")
    place = given.standing.placed(start)
    bits = kept_apart.bits
    bodies = BodyWriter(world, robot, groups, geometry, start, place, painted, closures, actuation, bits)
    bodies.write()
    cameras = given.keys.scene.cameras
    for link, every in carried_cameras(robot, cameras).items():
        body, body_from_link = bodies.elements[link]
        for name, link_from_frame in every:
            write_camera(body, name, cameras[name], body_from_link @ link_from_frame)
    write_mounted(bodies.elements, held_by, given.sensing)
    for body in world.iterchildren("body"):
        body.set("childclass", top)
    write_contacts(root, kept_apart, bodies.colliders, bodies.contacts)
    _equalities(root, robot, start, closures, given.keys.scene.option.timestep)
    write_actuation(root, actuation, given.sensing.sensors)
    _keyframes(root, world, robot, start, given.standing, actuation)
    motors = {
        actuator.dof: actuator.motor
        for actuator in actuation.actuators
        if actuator.motor and actuator.dof not in actuation.overruled
    }
    write_classes(root, classes, {top, "main", "visual", "collision"}, motors)
    return to_bytes(root)


def _option(root: Element, option: Any) -> None:
    """What the robot's stability was judged with; all else is the scene's."""
    given = {name: value for name, value in option.given().items() if name in IN_THE_ROBOT}
    texts = {name: value if isinstance(value, str) else number(value) for name, value in given.items()}
    element(root, "option", **texts)


def _defaults(root: Element, top: str, self_contact: bool) -> Element:
    """The robot's own class, with those of visual and collision geoms.

    Bits: the robot meets the world (1), and itself only where it shall: else 1 & 2 = 0.
    """
    robot = element(element(root, "default"), "default", class_=top)
    visual = element(robot, "default", class_="visual")
    element(visual, "geom", type="mesh", group="2", contype="0", conaffinity="0", density="0")
    collision = element(robot, "default", class_="collision")
    bits = "1" if self_contact else "2"
    element(collision, "geom", type="mesh", group="3", contype="1", conaffinity=bits, density="0")
    return robot


def _assets(root: Element, geometry: Geometry) -> dict[Paint, str]:
    """Textures, materials and meshes; the names of the materials."""
    asset = element(root, "asset")
    names = materials(geometry)
    for texture in sorted({texture for _, texture in names if texture}):
        element(asset, "texture", type="2d", name=stem(texture), file=texture)
    for (colour, texture), name in names.items():
        image = stem(texture) if texture else None
        element(asset, "material", name=name, texture=image, rgba=spaced(colour))
    seen = {shape.file for shape in geometry.shapes if shape.role == "visual"}
    for file in dict.fromkeys(shape.file for shape in geometry.shapes if shape.file is not None):
        # Geoms have no mass here, so the volume of a mesh does not matter; "shell" accepts open meshes.
        element(asset, "mesh", file=file, inertia="shell" if file in seen else None)
    return names


def _equalities(
    root: Element, robot: Robot, start: Configuration, closures: Closures, timestep: float
) -> None:
    """Loops between sites, and relations between joints."""
    if not robot.loops and not robot.relations:
        return
    equality = element(root, "equality")
    closures.write_equalities(equality, timestep)
    for relation in robot.relations:
        _relation(equality, relation, start, spaced(held(SOLREF, timestep)))


def _relation(equality: Element, relation: Relation, start: Configuration, solref: str) -> None:
    """A relation as MuJoCo has it, relative to qpos0: y − y₀ = a₀ + a₁ (x − x₀), solved for |a₁| ≥ 1.

    MuJoCo scales it by the inverse inertias of both joints, but not by a₁: with |a₁| < 1 a screw, or a
    motor behind a gearbox, would slip under load.
    """
    y, x, factor, offset = relation.follower, relation.driver, relation.multiplier, relation.offset
    if 0.0 < abs(factor) < 1.0:
        y, x, factor, offset = x, y, 1 / factor, -offset / factor
    constant = factor * _scalar(start[x]) + offset - _scalar(start[y])
    # Where qpos0 satisfies the relation the constant is rounding noise on the joints' own scale.
    scale = abs(_scalar(start[y]))
    element(
        equality,
        "joint",
        name=relation.name,
        joint1=y,
        joint2=x,
        polycoef=f"{number(constant, scale, TURN)} {number(factor)} 0 0 0",
        solref=solref,
        solimp=STIFF,
    )


def _scalar(value: Value) -> float:
    assert not isinstance(value, tuple), "only turns and slides are related"
    return value


def _keyframes(
    root: Element,
    world: Element,
    robot: Robot,
    start: Configuration,
    standing: "Stance",
    actuation: Actuation,
) -> None:
    """The named poses of the robot, each where the scene puts it, with the controls for which the actuators
    rest there."""
    joints = [node.get("name") for node in world.iter("joint", "freejoint")]
    if not joints:
        return
    keyframe = element(root, "keyframe")
    for name, q in keyframes(robot).items():
        texts = dict(_qpos(robot, q, start, standing.placed(q)))
        qpos_text = " ".join(texts[joint] for joint in joints)
        ctrl = controls(actuation, None if name == HOME else q)
        element(keyframe, "key", name=name, qpos=qpos_text, act=states(actuation, q), ctrl=ctrl)


def _qpos(
    robot: Robot, q: Configuration, start: Configuration, world_from_root: Array
) -> Iterator[tuple[str, str]]:
    """(name, numbers) of every joint of the model at `q`."""
    if not robot.base.fixed:
        yield free_joint_name(robot), free_qpos(world_from_root)
    chains = [(joint.parent_from_joint, joint.dofs) for joint in robot.joints]
    chains += [(loop.b_from_frame, loop.dofs) for loop in robot.loops]
    for parent_from_joint, dofs in chains:
        for dof in dofs:
            world_from_joint = world_from_root @ parent_from_joint if dof.kind == "free" else UNMOVED
            yield dof.name, qpos(dof, q[dof.name], start[dof.name], world_from_joint)
