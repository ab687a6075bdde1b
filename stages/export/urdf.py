"""URDF: the tree of links and joints.

Element rules are those of urdfdom's 1.0 format. A link's frame is its joint's; `rpy` is extrinsic
xyz. What URDF cannot say (loops; a joint without numbers) is told in one diagnostic each.
"""

import math
from collections.abc import Mapping, Sequence

from stages.robot.errors import Diagnostic
from stages.robot.geometry import Colour, Geometry, Role
from stages.robot.model import Array, Joint, Link, Robot
from stages.robot.names import free
from stages.robot.numbers import number, numbers, spaced
from stages.robot.poses import rpy_from_rotation
from stages.robot.xml import Element, element, to_bytes

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
        _link(root, link, geometry, colours)
    relations = {relation.follower: relation for relation in robot.relations}
    for joint in robot.joints:
        node = _joint(root, joint)
        relation = relations.get(joint.name)
        if relation is not None:
            element(
                node,
                "mimic",
                joint=relation.driver,
                multiplier=number(relation.multiplier),
                offset=number(relation.offset) if relation.offset else None,
            )
    _frames(root, robot)
    _tell(robot, diagnostics)
    return to_bytes(root)


def unset(joint: Joint) -> list[str]:
    """What URDF demands of a joint and nobody gave: among lower, upper, effort, velocity."""
    missing = [side for side in ("lower", "upper") if getattr(joint.limits, side) is None]
    if joint.type == "revolute" and len(missing) == 2:
        missing = []  # continuous: URDF wants no range then
    return missing + [key for key in ("effort", "velocity") if getattr(joint.dynamics, key) is None]


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


def _link(root: Element, link: Link, geometry: Geometry, colours: Mapping[Colour, str]) -> None:
    node = element(root, "link", name=link.name)
    if link.inertial.mass > 0:
        inertial = element(node, "inertial")
        element(inertial, "origin", xyz=spaced(link.inertial.com), rpy="0 0 0")
        element(inertial, "mass", value=number(link.inertial.mass))
        texts = numbers(link.inertial.inertia)
        keys = {"ixx": 0, "ixy": 1, "ixz": 2, "iyy": 4, "iyz": 5, "izz": 8}
        element(inertial, "inertia", **{key: texts[index] for key, index in keys.items()})
    roles: tuple[Role, ...] = ("visual", "collision")
    for role in roles:
        for shape in geometry.of(link.name, role):
            holder = element(node, role)
            element(holder, "origin", xyz="0 0 0", rpy="0 0 0")
            element(element(holder, "geometry"), "mesh", filename=f"assets/{shape.file}")
            if shape.colour is not None:
                element(holder, "material", name=colours[shape.colour])


def _joint(root: Element, joint: Joint) -> Element:
    limits, dynamics = joint.limits, joint.dynamics
    continuous = joint.type == "revolute" and limits.lower is None and limits.upper is None
    node = element(root, "joint", name=joint.name, type="continuous" if continuous else joint.type)
    _origin(node, joint.parent_from_joint)
    element(node, "parent", link=joint.parent)
    element(node, "child", link=joint.child)
    element(node, "axis", xyz=spaced(joint.axis))
    low, high = _range(joint)
    element(
        node,
        "limit",
        lower=None if continuous else number(low),
        upper=None if continuous else number(high),
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


def _range(joint: Joint) -> tuple[float, float]:
    """Both ends of the range; an open one lies a fixed reach away, beyond zero and the other end."""
    reach = UNSET_REACH[joint.type]
    low, high = joint.limits.lower, joint.limits.upper
    if low is None:
        low = -reach if high is None else min(-reach, high - reach)
    if high is None:
        high = max(reach, low + reach)
    return low, high


def _frames(root: Element, robot: Robot) -> None:
    """Frames, and both sides of every loop, as links without mass on fixed joints."""
    links = {link.name for link in robot.links}
    joints = {joint.name for joint in robot.joints}
    markers = [(frame.name, frame.link, frame.link_from_frame) for frame in robot.frames]
    for loop in robot.loops:
        markers.append((f"{loop.name}_a", loop.link_a, loop.a_from_frame))
        markers.append((f"{loop.name}_b", loop.link_b, loop.b_from_frame))
    for wanted, parent, pose in markers:
        name = free(wanted, links)
        links.add(name)
        element(root, "link", name=name)
        joint = free(f"{name}_fixed", joints)
        joints.add(joint)
        node = element(root, "joint", name=joint, type="fixed")
        _origin(node, pose)
        element(node, "parent", link=parent)
        element(node, "child", link=name)


def _tell(robot: Robot, diagnostics: list[Diagnostic]) -> None:
    if robot.loops:
        diagnostics.append(
            Diagnostic(
                "I-URDF-LOOP",
                "URDF has no loops: "
                + _listed([loop.name for loop in robot.loops])
                + " stay(s) open there, with a frame on either side (<name>_a, <name>_b)",
                f"{robot.name}.urdf",
                "the MJCF closes them; robot.json lists them under loops",
            )
        )
    lacking = {joint.name: unset(joint) for joint in robot.joints if unset(joint)}
    if lacking:
        diagnostics.append(
            Diagnostic(
                "I-URDF-UNSET",
                "URDF demands numbers that nobody gave, and got stand-ins (effort 100, velocity 10, "
                "±1 m, ±2π rad): "
                + "; ".join(f"{name}: {', '.join(keys)}" for name, keys in lacking.items()),
                f"{robot.name}.urdf",
                'set them: joints: {"*": {effort: ..., velocity: ...}}',
            )
        )


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names)
