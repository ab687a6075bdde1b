"""URDF: the tree of links and joints.

Element rules are those of urdfdom's 1.0 format. A link's frame is its joint's; `rpy` is extrinsic
xyz. What URDF cannot say (loops; joints of several degrees of freedom; cones; a joint without
numbers) is told in one diagnostic each.
"""

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from stages.export.urdf.lowering import Lowered, Step, lower, unset
from stages.formats.numbers import number, numbers, spaced
from stages.formats.urdf.names import UrdfNames, urdf_names
from stages.formats.xml import Element, element, parse, to_bytes
from stages.robot.errors import Diagnostic
from stages.robot.geometry import Colour, Geometry, Role, Shape
from stages.robot.inertia import NEXT_TO_NOTHING, SPECK
from stages.robot.model import Array, Inertial, Limits, Primitive, Robot
from stages.robot.poses import from_parts, rpy_from_rotation

UNSET_EFFORT = 100.0
UNSET_VELOCITY = 10.0
UNSET_REACH = {"revolute": 2 * math.pi, "prismatic": 1.0}
"""What stands in for a limit that nobody set [rad, m]: URDF demands a number."""


def write_urdf(robot: Robot, geometry: Geometry, diagnostics: list[Diagnostic]) -> bytes:
    """The robot as URDF, meshes at paths relative to the file."""
    root = element(None, "robot", name=robot.name)
    # MuJoCo would strip the mesh paths, fuse a fixed root away and drop the visuals.
    mujoco = element(root, "mujoco")
    element(mujoco, "compiler", strippath="false", fusestatic="false", discardvisual="false")
    colours = _materials(root, geometry)
    for link in robot.links:
        solid = any(shape.link == link.name for shape in geometry.shapes)
        node = _link(root, link.name, link.inertial, solid)
        _shapes(node, link.name, geometry, colours)
    lowered = lower(robot)
    for joint in lowered:
        for name in joint.between:
            _link(root, name, SPECK, False)
    steps = [step for joint in lowered for step in joint.steps]
    relations = {relation.follower: relation for relation in robot.relations}
    for step in steps:
        node = _joint(root, step)
        relation = relations.get(step.name)
        if relation is not None:
            element(
                node,
                "mimic",
                joint=relation.driver,
                multiplier=number(relation.multiplier),
                offset=number(relation.offset) if relation.offset else None,
            )
    names = urdf_names(robot)
    _frames(root, robot, names)
    for text in robot.controls:
        root.append(parse(text.encode()))
    _tell(robot, lowered, diagnostics)
    diagnostics += _renamed(robot, names)
    return to_bytes(root)


def _origin(parent: Element, pose: Array) -> None:
    rpy = rpy_from_rotation(pose[:3, :3])
    # Angles are measured on the scale of a turn: 1e-12 rad, whatever the other two are.
    element(parent, "origin", xyz=spaced(pose[:3, 3]), rpy=spaced(rpy, 1.0))


def _materials(root: Element, geometry: Geometry) -> dict[Colour, str]:
    colours = sorted({shape.colour for shape in geometry.shapes if shape.colour is not None})
    names = {colour: f"colour_{count}" for count, colour in enumerate(colours)}
    for colour, name in names.items():
        element(element(root, "material", name=name), "color", rgba=spaced(colour))
    return names


def _link(root: Element, name: str, body: Inertial, shaped: bool) -> Element:
    node = element(root, "link", name=name)
    # MuJoCo would weigh the shapes of a link that says nothing of its mass.
    if body.mass > 0 or shaped:
        inertial = element(node, "inertial")
        element(inertial, "origin", xyz=spaced(body.com), rpy="0 0 0")
        element(inertial, "mass", value=number(body.mass))
        texts = numbers(body.inertia)
        keys = {"ixx": 0, "ixy": 1, "ixz": 2, "iyy": 4, "iyz": 5, "izz": 8}
        element(inertial, "inertia", **{key: texts[index] for key, index in keys.items()})
    return node


def _shapes(node: Element, link: str, geometry: Geometry, colours: Mapping[Colour, str]) -> None:
    roles: tuple[Role, ...] = ("visual", "collision")
    for role in roles:
        for shape in geometry.of(link, role):
            for pose, tag, attributes in _solids(shape):
                holder = element(node, role)
                _origin(holder, pose)
                element(element(holder, "geometry"), tag, **attributes)
                if shape.colour is not None:
                    element(holder, "material", name=colours[shape.colour])


def _solids(shape: Shape) -> Iterator[tuple[Array, str, dict[str, str]]]:
    """The URDF geometries of a shape: link_from_solid (4, 4), element, attributes."""
    if shape.primitive is None:
        yield np.eye(4), "mesh", {"filename": f"assets/{shape.file}"}
    else:
        yield from _primitive(shape.primitive)


def _primitive(primitive: Primitive) -> Iterator[tuple[Array, str, dict[str, str]]]:
    pose, size = primitive.link_from_shape, primitive.size
    if primitive.kind == "box":
        yield pose, "box", {"size": spaced(size)}
        return
    radius = {"radius": number(size[0])}
    if primitive.kind == "sphere":
        yield pose, "sphere", radius
        return
    yield pose, "cylinder", {**radius, "length": number(size[1])}
    if primitive.kind == "capsule":
        # URDF has no capsule: a ball at either end makes one.
        for end in (-size[1] / 2, size[1] / 2):
            yield pose @ from_parts(np.eye(3), np.array([0.0, 0.0, end])), "sphere", radius


def _joint(root: Element, step: Step) -> Element:
    node = element(root, "joint", name=step.name, type=step.type)
    _origin(node, step.parent_from_step)
    element(node, "parent", link=step.parent)
    element(node, "child", link=step.child)
    if step.axis is None:
        return node
    limits, dynamics = step.limits, step.dynamics
    element(node, "axis", xyz=spaced(step.axis))
    low, high = (None, None) if step.type == "continuous" else map(number, _range(step.type, limits))
    element(
        node,
        "limit",
        lower=low,
        upper=high,
        effort=number(UNSET_EFFORT if dynamics.effort is None else dynamics.effort),
        velocity=number(UNSET_VELOCITY if dynamics.velocity is None else dynamics.velocity),
    )
    if dynamics.damping is not None or dynamics.friction is not None:
        element(
            node,
            "dynamics",
            damping=number(dynamics.damping or 0.0),
            friction=number(dynamics.friction or 0.0),
        )
    return node


def _range(kind: str, limits: Limits) -> tuple[float, float]:
    """Both ends of the range; an open one lies a fixed reach away, beyond zero and the other end."""
    reach = UNSET_REACH[kind]
    low, high = limits.lower, limits.upper
    if low is None:
        low = -reach if high is None else min(-reach, high - reach)
    if high is None:
        high = max(reach, low + reach)
    return low, high


def _frames(root: Element, robot: Robot, names: UrdfNames) -> None:
    """Frames, and both sides of every loop, as links without mass on fixed joints."""
    markers = [(names.frames[frame.name], frame.link, frame.link_from_frame) for frame in robot.frames]
    for loop in robot.loops:
        first, second = names.ends[loop.name]
        markers.append((first, loop.link_a, loop.a_from_frame))
        markers.append((second, loop.link_b, loop.b_from_frame))
    for name, parent, pose in markers:
        element(root, "link", name=name)
        node = element(root, "joint", name=names.holders[name], type="fixed")
        _origin(node, pose)
        element(node, "parent", link=parent)
        element(node, "child", link=name)


def _renamed(robot: Robot, names: UrdfNames) -> list[Diagnostic]:
    return [
        Diagnostic(
            "I-URDF-NAME",
            f"the frame {frame!r} is the link {name!r} there: another link has its name",
            f"{robot.name}.urdf",
            "the MJCF has it as it is; robot.json has the URDF's name, under urdf",
        )
        for frame, name in names.frames.items()
        if name != frame
    ]


def _tell(robot: Robot, lowered: Sequence[Lowered], diagnostics: list[Diagnostic]) -> None:
    def tell(code: str, message: str, hint: str) -> None:
        diagnostics.append(Diagnostic(code, message, f"{robot.name}.urdf", hint))

    several = [
        f"{item.joint.name} ({item.joint.type}: {', '.join(step.name for step in item.steps)})"
        for item in lowered
        if item.between
    ]
    if several:
        tell(
            "I-URDF-LOWERED",
            "a URDF joint has one degree of freedom, so several stand for each of these, with links of "
            f"{number(NEXT_TO_NOTHING)} kg between them: " + "; ".join(several),
            "the MJCF needs none; robot.json lists them under lowered",
        )
    cones = [dof.name for dof in robot.dofs if dof.kind == "ball" and dof.limits.upper is not None]
    if cones:
        tell(
            "W-BALL-CONE",
            "URDF has no limit of a ball's tilt, so these tilt freely there: " + ", ".join(cones),
            "robot.json has the half angle of the cone",
        )
    afloat = [joint.name for joint in robot.joints if joint.type == "free"]
    if afloat:
        tell(
            "I-URDF-FREE",
            "joints of type floating, which many readers of URDF leave out or hold fixed: "
            + ", ".join(afloat),
            "use the MJCF where these bodies must move: of a URDF, MuJoCo takes such a joint only under a "
            "root link called world",
        )
    if robot.loops:
        tell(
            "I-URDF-LOOP",
            "URDF has no loops: "
            + ", ".join(loop.name for loop in robot.loops)
            + " stay(s) open there, with a frame on either side (<name>_a, <name>_b)",
            "the MJCF closes them; robot.json lists them under loops",
        )
    rotors = [dof.name for dof in robot.dofs if dof.dynamics.armature]
    if rotors:
        tell(
            "I-URDF-ARMATURE",
            f"URDF has no word for a rotor's inertia, so these joints have none there: {', '.join(rotors)}",
            "the MJCF and robot.json have it (armature)",
        )
    lacking = {dof.name: unset(dof) for dof in robot.dofs if unset(dof)}
    if lacking:
        tell(
            "I-URDF-UNSET",
            "URDF demands numbers that nobody gave, and got stand-ins (effort 100, velocity 10, "
            "±1 m, ±2π rad): " + "; ".join(f"{name}: {', '.join(keys)}" for name, keys in lacking.items()),
            'set them: joints: {"*": {effort: ..., velocity: ...}}',
        )
