"""MJCF: the robot alone, as `<name>.xml` (the scene around it is another file).

Element and attribute rules are those of MuJoCo's XML reference. Every body has CAD's own
`inertial`; geoms have no mass. Orientation is always `quat`.
"""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from stages.export.mjcf.actuators import controls, write_actuators
from stages.export.mjcf.filters import WORLD, Filters, Geom
from stages.export.mjcf.joints import free_joint_name, free_qpos, qpos, write_joints
from stages.export.mjcf.loops import STIFF, Closures, held
from stages.export.mjcf.placement import placement
from stages.export.paints import Paint, materials, paint
from stages.export.scene_pose import scene_pose
from stages.formats.numbers import number, rounded, spaced
from stages.formats.xml import Element, element, to_bytes
from stages.robot.actuation import NONE, Actuation
from stages.robot.geometry import Geometry, Shape
from stages.robot.inertia import principal_axes
from stages.robot.kinematics import chain
from stages.robot.model import Array, Configuration, Frame, Inertial, Joint, Primitive, Relation, Robot, Value
from stages.robot.names import free
from stages.robot.poses import from_parts
from stages.robot.start_pose import HOME, keyframes

if TYPE_CHECKING:
    from stages.export.keys import ExportKeys

SOLREF = (0.005, 1.0)
"""Of relations: time constant [s] and damping ratio; the same as the default of loops."""


def write_mjcf(
    robot: Robot,
    geometry: Geometry,
    keys: "ExportKeys",
    start: Configuration,
    kept_apart: Filters,
    actuation: Actuation = NONE,
) -> bytes:
    """The model, whose qpos0 is `start` (values of the tree's dofs and of the loops' own)."""
    root = element(None, "mujoco", model=robot.name)
    textures = "assets" if any(shape.texture for shape in geometry.shapes) else None
    element(root, "compiler", angle="radian", meshdir="assets", texturedir=textures, autolimits="true")
    element(root, "option", timestep=number(keys.scene.option.timestep), integrator="implicitfast")
    top = free(robot.name, {"main", "visual", "collision"})
    _defaults(root, top, geometry.self_contact)
    painted = _assets(root, geometry)
    closures = Closures(robot)
    world = element(root, "worldbody")
    place = scene_pose(keys)
    _Bodies(world, robot, geometry, start, place, painted, closures, actuation, kept_apart.bits).write()
    for body in world.iterchildren("body"):
        body.set("childclass", top)
    _excludes(root, kept_apart)
    _equalities(root, robot, start, closures, keys.scene.option.timestep)
    write_actuators(root, actuation)
    _keyframes(root, world, robot, start, place, actuation)
    return to_bytes(root)


def _defaults(root: Element, top: str, self_contact: bool) -> None:
    """Visual and collision classes. Bits: the robot meets the world (1), and itself only where it shall: else
    1 & 2 = 0."""
    robot = element(element(root, "default"), "default", class_=top)
    visual = element(robot, "default", class_="visual")
    element(visual, "geom", type="mesh", group="2", contype="0", conaffinity="0", density="0")
    collision = element(robot, "default", class_="collision")
    bits = "1" if self_contact else "2"
    element(collision, "geom", type="mesh", group="3", contype="1", conaffinity=bits, density="0")


def _assets(root: Element, geometry: Geometry) -> dict[Paint, str]:
    """Textures, materials and meshes; the names of the materials."""
    asset = element(root, "asset")
    names = materials(geometry)
    for texture in sorted({texture for _, texture in names if texture}):
        element(asset, "texture", type="2d", name=stem(texture), file=texture)
    for (colour, texture), name in names.items():
        image = stem(texture) if texture else None
        element(asset, "material", name=name, texture=image, rgba=spaced(colour))
    for shape in geometry.shapes:
        # Geoms have no mass here, so the volume of a mesh does not matter; "shell" accepts open meshes.
        if shape.file is not None:
            inertia = "shell" if shape.role == "visual" else None
            element(asset, "mesh", file=shape.file, inertia=inertia)
    return names


class _Bodies:
    """The tree of bodies, below the worldbody."""

    def __init__(
        self,
        world: Element,
        robot: Robot,
        geometry: Geometry,
        start: Configuration,
        world_from_root: Array,
        painted: dict[Paint, str],
        closures: Closures,
        actuation: Actuation,
        bits: Mapping[Geom, tuple[int, int]],
    ) -> None:
        self.world = world
        self.robot = robot
        self.geometry = geometry
        self.start = start
        self.world_from_root = world_from_root
        self.painted = painted
        self.closures = closures
        self.compensated = dict(actuation.compensated)
        self.compensating = frozenset(actuation.compensating)
        self.bits = bits
        self.elements: dict[str, tuple[Element, Array]] = {}
        """By link: its element, and element_from_link (4, 4), which only the link `world` needs."""

    def write(self) -> None:
        joints = {joint.child: joint for joint in self.robot.joints}
        frames: dict[str, list[Frame]] = {}
        for frame in self.robot.frames:
            frames.setdefault(frame.link, []).append(frame)
        for link in self.robot.links:
            joint = joints.get(link.name)
            body, place = self._root() if joint is None else (self._child(joint), np.eye(4))
            self.elements[link.name] = body, place
            if link.name in self.compensated:
                body.set("gravcomp", number(self.compensated[link.name]))
            _inertial(body, self.closures.share(link.name, link.inertial))
            self._geoms(body, link.name, place)
            for frame in frames.get(link.name, ()):
                element(body, "site", name=frame.name, **placement(place @ frame.link_from_frame))
            self.closures.write_sites(body, link.name, place)
        for carrier in self.closures.carriers:
            above, place = self.elements[carrier.parent]
            pose = place @ carrier.pose(self.start)
            body = element(above, "body", name=carrier.name, **placement(pose))
            write_joints(body, carrier.dofs, self.start)
            _inertial(body, self.closures.carries(carrier))
            self.closures.write_sites(body, carrier.name, np.eye(4))

    def _root(self) -> tuple[Element, Array]:
        name = self.robot.root.name
        if name == WORLD:
            element(self.world, "site", name=WORLD, **placement(self.world_from_root))
            return self.world, self.world_from_root
        body = element(self.world, "body", name=name, **placement(self.world_from_root))
        if not self.robot.base.fixed:
            element(body, "freejoint", name=free_joint_name(self.robot))
        return body, np.eye(4)

    def _child(self, joint: Joint) -> Element:
        above, place = self.elements[joint.parent]
        if joint.type == "free":
            above, place = self.world, self.world_from_root
        pose = place @ joint.parent_from_joint @ chain(joint.dofs, self.start)
        body = element(above, "body", name=joint.child, **placement(pose))
        write_joints(body, joint.dofs, self.start, self.compensating)
        return body

    def _geoms(self, body: Element, link: str, place: Array) -> None:
        for shape in self.geometry.of(link, "visual"):
            own = paint(shape)
            form = {**_form(shape, place), **_contact(shape)}
            material = None if own is None else self.painted[own]
            element(body, "geom", class_="visual", **form, material=material)
        collisions = self.geometry.of(link, "collision")
        for count, shape in enumerate(collisions):
            suffix = f"_{count}" if len(collisions) > 1 else ""
            name = f"{link}_collision{suffix}"
            form = {**_form(shape, place), **_contact(shape)}
            if (link, count) in self.bits:
                form |= zip(("contype", "conaffinity"), map(str, self.bits[link, count]), strict=True)
            element(body, "geom", name=name, class_="collision", **form)


def _inertial(body: Element, inertial: Inertial) -> None:
    """Mass properties about principal axes: from `fullinertia` MuJoCo up to 3.13 finds the axes to 1e-6
    only, and ignores entries below 1e-12 kg m²."""
    if inertial.mass == 0.0:
        return
    # Of the rounded tensor: the digits below differ between machines.
    moments, axes = principal_axes(rounded(inertial.inertia))
    element(
        body,
        "inertial",
        pos=spaced(inertial.com),
        **placement(from_parts(axes, np.zeros(3))),
        mass=number(inertial.mass),
        diaginertia=spaced(moments),
    )


def _form(shape: Shape, body_from_link: Array) -> dict[str, str]:
    """The attributes of a geom: a mesh, which is in the link's frame, or a primitive."""
    if shape.file is not None:
        return {"mesh": stem(shape.file), **placement(body_from_link)}
    assert shape.primitive is not None
    primitive = shape.primitive
    pose = placement(body_from_link @ primitive.link_from_shape)
    return {"type": primitive.kind, "size": spaced(_half_sizes(primitive)), **pose}


def _contact(shape: Shape) -> dict[str, str]:
    """The attributes of a geom's contacts, as far as the configuration gives them."""
    if shape.contact is None:
        return {}
    return {
        key: " ".join(number(one) for one in value) if isinstance(value, tuple) else number(value)
        for key, value in shape.contact.given().items()
    }


def _half_sizes(primitive: Primitive) -> list[float]:
    """MuJoCo's sizes: radii, and half lengths."""
    size = primitive.size
    if primitive.kind == "box":
        return [length / 2 for length in size]
    return [size[0], *(length / 2 for length in size[1:])]


def stem(file: str) -> str:
    """A mesh's name in MuJoCo: its file's, without the extension."""
    return file.rsplit(".", 1)[0]


def _excludes(root: Element, kept_apart: Filters) -> None:
    """The pairs of bodies that do not collide at all, but for those that MuJoCo leaves out by itself."""
    if kept_apart.pairs:
        contact = element(root, "contact")
        for one, other in kept_apart.pairs:
            element(contact, "exclude", body1=one, body2=other)


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
    scale = max(1.0, abs(_scalar(start[y])))
    element(
        equality,
        "joint",
        name=relation.name,
        joint1=y,
        joint2=x,
        polycoef=f"{number(constant, scale)} {number(factor)} 0 0 0",
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
    world_from_root: Array,
    actuation: Actuation,
) -> None:
    """The named poses of the robot, with the controls for which the actuators rest there."""
    joints = [node.get("name") for node in world.iter("joint", "freejoint")]
    if not joints:
        return
    keyframe = element(root, "keyframe")
    for name, q in keyframes(robot).items():
        texts = dict(_qpos(robot, q, start, world_from_root))
        qpos_text = " ".join(texts[joint] for joint in joints)
        ctrl = controls(actuation, None if name == HOME else q)
        element(keyframe, "key", name=name, qpos=qpos_text, ctrl=ctrl)


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
            place = world_from_root @ parent_from_joint
            yield dof.name, qpos(dof, q[dof.name], start[dof.name], place)
