"""MJCF: the robot alone, as `<name>.xml` (the scene around it is another file).

Element and attribute rules are those of MuJoCo's XML reference. Every body has CAD's own
`inertial`; geoms weigh nothing. Orientation is always `quat`.
"""

from collections.abc import Mapping

import numpy as np

from stages.export.keys import ExportKeys
from stages.export.pose import home
from stages.robot.geometry import Colour, Geometry
from stages.robot.kinematics import saved_configuration
from stages.robot.model import Array, Joint, Link, Loop, Robot
from stages.robot.names import free
from stages.robot.numbers import number, spaced
from stages.robot.poses import from_parts, motion, quat_from_rotation, rotation_from_rpy
from stages.robot.xml import Element, element, to_bytes

OPEN = "1e6"
"""Stands for the open side of a one-sided limit: MuJoCo has no such thing as half a range."""

TYPES = {"revolute": "hinge", "prismatic": "slide"}


def write_mjcf(robot: Robot, geometry: Geometry, keys: ExportKeys, start: Mapping[str, float]) -> bytes:
    """The model, whose qpos0 is `start` (joint values in rad or m)."""
    root = element(None, "mujoco", model=robot.name)
    element(root, "compiler", angle="radian", meshdir="assets", autolimits="true")
    element(root, "option", timestep=number(keys.scene.option.timestep), integrator="implicitfast")
    top = free(robot.name, {"main", "visual", "collision"})
    _defaults(root, top)
    colours = _assets(root, geometry)
    sites = _Sites(robot)
    world = element(root, "worldbody")
    _bodies(world, robot, geometry, keys, start, colours, sites)
    for body in world:
        body.set("childclass", top)
    _equalities(root, robot, start, sites)
    _keyframes(root, robot, keys)
    return to_bytes(root)


def placement(pose: Array) -> dict[str, str]:
    """`pos` and `quat` of a (4, 4) pose; what is identity is left out."""
    out = {}
    position = spaced(pose[:3, 3])
    if position != "0 0 0":
        out["pos"] = position
    quat = spaced(quat_from_rotation(pose[:3, :3]))
    if quat != "1 0 0 0":
        out["quat"] = quat
    return out


def scene_pose(keys: ExportKeys) -> Array:
    """world_from_root (4, 4): where the scene puts the robot."""
    return from_parts(rotation_from_rpy(keys.scene.pose.rpy), np.array(keys.scene.pose.xyz))


def _defaults(root: Element, top: str) -> None:
    """Visual and collision classes. Bits: the robot meets the world (1), but not itself (1 & 2 = 0)."""
    robot = element(element(root, "default"), "default", class_=top)
    visual = element(robot, "default", class_="visual")
    element(visual, "geom", type="mesh", group="2", contype="0", conaffinity="0", density="0")
    collision = element(robot, "default", class_="collision")
    element(collision, "geom", type="mesh", group="3", contype="1", conaffinity="2", density="0")


def _assets(root: Element, geometry: Geometry) -> dict[Colour, str]:
    """Materials and meshes; the names of the materials by colour."""
    asset = element(root, "asset")
    colours = sorted({shape.colour for shape in geometry.shapes if shape.colour is not None})
    names = {colour: f"colour_{count}" for count, colour in enumerate(colours)}
    for colour, name in names.items():
        element(asset, "material", name=name, rgba=spaced(colour))
    for shape in geometry.shapes:
        # Geoms weigh nothing here, so the volume of a mesh never matters; "shell" accepts open ones.
        element(asset, "mesh", file=shape.file, inertia="shell" if shape.role == "visual" else None)
    return names


class _Sites:
    """Names of the sites that close loops: unique beside the frames."""

    def __init__(self, robot: Robot) -> None:
        taken = {frame.name for frame in robot.frames}
        self.by_loop: dict[str, tuple[str, str, str, str]] = {}
        for loop in robot.loops:
            names = []
            for suffix in ("a", "b", "a_axis", "b_axis"):
                names.append(free(f"{loop.name}_{suffix}", taken))
                taken.add(names[-1])
            self.by_loop[loop.name] = (names[0], names[1], names[2], names[3])


def _bodies(
    world: Element,
    robot: Robot,
    geometry: Geometry,
    keys: ExportKeys,
    start: Mapping[str, float],
    colours: Mapping[Colour, str],
    sites: _Sites,
) -> None:
    elements: dict[str, Element] = {}
    joint_of = {joint.child: joint for joint in robot.joints}
    for link in robot.links:
        joint = joint_of.get(link.name)
        if joint is None:
            body = element(world, "body", name=link.name, **placement(scene_pose(keys)))
            if not robot.base.fixed:
                element(body, "freejoint", name=free_joint_name(robot))
        else:
            pose = joint.parent_from_joint @ motion(joint.type, joint.axis, start[joint.name])
            body = element(elements[joint.parent], "body", name=link.name, **placement(pose))
            _joint(body, joint, start[joint.name])
        elements[link.name] = body
        _inertial(body, link)
        _geoms(body, link, geometry, colours)
        _sites(body, link, robot, sites)


def free_joint_name(robot: Robot) -> str:
    """The name of the free joint of a floating base."""
    return free(f"{robot.root.name}_free", {joint.name for joint in robot.joints})


def _joint(body: Element, joint: Joint, reference: float) -> None:
    limits, dynamics = joint.limits, joint.dynamics
    limited = limits.lower is not None or limits.upper is not None
    low = f"-{OPEN}" if limits.lower is None else number(limits.lower)
    high = OPEN if limits.upper is None else number(limits.upper)
    effort = dynamics.effort
    element(
        body,
        "joint",
        name=joint.name,
        type=TYPES[joint.type],
        axis=spaced(joint.axis),
        range=f"{low} {high}" if limited else None,
        ref=None if reference == 0.0 else number(reference),
        damping=None if dynamics.damping is None else number(dynamics.damping),
        frictionloss=None if dynamics.friction is None else number(dynamics.friction),
        armature=None if dynamics.armature is None else number(dynamics.armature),
        actuatorfrcrange=None if effort is None else f"{number(-effort)} {number(effort)}",
    )


def _inertial(body: Element, link: Link) -> None:
    """CAD's own mass properties; fullinertia is M11 M22 M33 M12 M13 M23."""
    if link.inertial.mass == 0.0:
        return
    i = link.inertial.inertia
    full = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]
    element(
        body,
        "inertial",
        pos=spaced(link.inertial.com),
        mass=number(link.inertial.mass),
        fullinertia=spaced(full),
    )


def _geoms(body: Element, link: Link, geometry: Geometry, colours: Mapping[Colour, str]) -> None:
    for shape in geometry.of(link.name, "visual"):
        colour = None if shape.colour is None else colours[shape.colour]
        element(body, "geom", class_="visual", mesh=stem(shape.file), material=colour)
    collisions = geometry.of(link.name, "collision")
    for count, shape in enumerate(collisions):
        suffix = f"_{count}" if len(collisions) > 1 else ""
        element(
            body, "geom", name=f"{link.name}_collision{suffix}", class_="collision", mesh=stem(shape.file)
        )


def stem(file: str) -> str:
    """A mesh's name in MuJoCo: its file's, without the extension."""
    return file.rsplit(".", 1)[0]


def _sites(body: Element, link: Link, robot: Robot, sites: _Sites) -> None:
    for frame in robot.frames:
        if frame.link == link.name:
            element(body, "site", name=frame.name, **placement(frame.link_from_frame))
    for loop in robot.loops:
        a, b, a_axis, b_axis = sites.by_loop[loop.name]
        for owner, pose, near, far in (
            (loop.link_a, loop.a_from_frame, a, a_axis),
            (loop.link_b, loop.b_from_frame, b, b_axis),
        ):
            if owner == link.name:
                element(body, "site", name=near, **placement(pose))
                element(body, "site", name=far, **placement(_along_axis(pose, loop)))


def _along_axis(pose: Array, loop: Loop) -> Array:
    shifted = np.array(pose)
    shifted[:3, 3] += pose[:3, 2] * loop.lever
    return shifted


def _equalities(root: Element, robot: Robot, start: Mapping[str, float], sites: _Sites) -> None:
    """Loops as two points on the axis that must meet; relations as joint equalities.

    Two `connect`s hold a hinge exactly and need no made-up body: a body of next to no mass would
    make MuJoCo scale the constraint by its inverse inertia, and so leave it slack. A joint
    equality counts from qpos0: y − y₀ = a₀ + a₁ (x − x₀).
    """
    if not robot.loops and not robot.relations:
        return
    equality = element(root, "equality")
    taken = {loop.name for loop in robot.loops} | {relation.name for relation in robot.relations}
    for loop in robot.loops:
        a, b, a_axis, b_axis = sites.by_loop[loop.name]
        solref = spaced(loop.solref)
        element(equality, "connect", name=loop.name, site1=a, site2=b, solref=solref)
        axis = free(f"{loop.name}_axis", taken)
        taken.add(axis)
        element(equality, "connect", name=axis, site1=a_axis, site2=b_axis, solref=solref)
    for relation in robot.relations:
        constant = relation.multiplier * start[relation.driver] + relation.offset - start[relation.follower]
        # Where qpos0 satisfies the relation the constant is rounding noise on the joints' own scale.
        scale = max(1.0, abs(start[relation.follower]))
        coefficients = f"{number(constant, scale)} {number(relation.multiplier)} 0 0 0"
        element(
            equality,
            "joint",
            name=relation.name,
            joint1=relation.follower,
            joint2=relation.driver,
            polycoef=coefficients,
        )


def _keyframes(root: Element, robot: Robot, keys: ExportKeys) -> None:
    """`cad`: the pose the document was saved in; `home`: the same, clipped to the limits."""
    base = []
    if not robot.base.fixed:
        pose = scene_pose(keys)
        base = [spaced(pose[:3, 3]), spaced(quat_from_rotation(pose[:3, :3]))]
    if not base and not robot.joints:
        return
    keyframe = element(root, "keyframe")
    for name, q in (("home", home(robot)), ("cad", saved_configuration(robot))):
        values = [number(q[joint.name], max(1.0, abs(q[joint.name]))) for joint in robot.joints]
        element(keyframe, "key", name=name, qpos=" ".join(base + values))
