"""Finds a compiled model's joints and bodies by the robot's names, and sets the robot's values in its `qpos`.

A ball is a quaternion relative to qpos0 in an MJCF, and three turns about x, y and z in a URDF. A free joint
has its pose in the world in both.
"""

import functools
import math
from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.formats.urdf.names import urdf_names
from linkwright.stages.mujoco.names import body_index, joint_index, site_index
from linkwright.stages.robot.model.poses import (
    UNMOVED,
    inverse,
    motion,
    quat_from_rotation,
    turns_from_rotation,
)
from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Joint, Robot, Value
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import largest_error
from linkwright.stages.validate.model.poses import placed

HINGE, SLIDE = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE
BALL, FREE = mujoco.mjtJoint.mjJNT_BALL, mujoco.mjtJoint.mjJNT_FREE
KINDS = {"turn": HINGE, "slide": SLIDE, "ball": BALL, "free": FREE}
"""Kind of dof → type of MuJoCo's joint."""

DOFS_OF_TYPE = {HINGE: 1, SLIDE: 1, BALL: 3, FREE: 6}
"""Degrees of freedom by the type of joint."""

BY_EQUALITY = ("fixed", "revolute", "ball")
"""Types of loops that an equality alone closes. For other types the model also has the loop's dofs, on a
carrier body."""

CAD_ERROR = 1e-6
"""Tolerance of poses [m, rad]: CAD's own solver leaves a smaller error."""

ENGINE_TOLERANCE = 1e-9
"""Tolerance of values, such as poses [m, rad], that two engines compute from the same numbers."""


def joints_of(robot: Robot, urdf: bool) -> Iterator[tuple[str, Any, Dof]]:
    """Yields (name, type, dof) of every joint that a model must have, except a floating base."""
    loops_with_carrier = [] if urdf else [loop for loop in robot.loops if loop.type not in BY_EQUALITY]
    turns = urdf_names(robot).turns
    for dof in (*robot.dofs, *(dof for loop in loops_with_carrier for dof in loop.dofs)):
        if urdf and dof.kind == "ball":
            yield from ((name, HINGE, dof) for name in turns[dof.name])
        else:
            yield dof.name, KINDS[dof.kind], dof


def find_missing_names(compiled: CompiledModel) -> list[str]:
    """Returns the links and joints that the model does not have by name, sorted."""
    model, robot = compiled.model, compiled.robot
    links = [link.name for link in robot.links if body_index(model, link.name) < 0]
    joints = [name for name, *_ in joints_of(robot, compiled.urdf) if joint_index(model, name) < 0]
    return sorted({*links, *joints})


ORIENTATIONS = frozenset({"quat", "axisangle", "xyaxes", "zaxis", "euler"})
"""Attributes of an MJCF that give the orientation of a body, site or geom."""


def bodies_of_scene(model: Any, robot: Robot) -> frozenset[int]:
    """Returns the bodies that are not the robot's, such as a ball next to it: all bodies of the world's
    subtrees without links of the robot. Empty if the model has no link at all."""
    bodies = (body_index(model, link.name) for link in robot.links)
    roots = {int(model.body_rootid[body]) for body in bodies if body > 0}
    if not roots:
        return frozenset()
    return frozenset(body for body in range(1, model.nbody) if int(model.body_rootid[body]) not in roots)


def set_values(model: Any, data: Any, robot: Robot, q: Configuration, urdf: bool) -> None:
    """Resets the data, sets the values `q` by the names of dofs and computes poses. `q` has all dofs of the
    robot and of its loops."""
    mujoco.mj_resetData(model, data)
    mujoco.mj_kinematics(model, data)
    numbers: dict[str, list[float]] = {}
    for joint in robot.joints:
        for dof in joint.dofs:
            value = q[dof.name]
            if isinstance(value, tuple):
                numbers |= _qpos_numbers(model, data, robot, joint, dof, value, urdf)
            else:
                numbers[dof.name] = [value]
    for loop in robot.loops:
        numbers |= {dof.name: [value] for dof in loop.dofs if not isinstance(value := q[dof.name], tuple)}
    for name, _, _ in joints_of(robot, urdf):
        joint_numbers = numbers[name]
        qpos_index = int(model.jnt_qposadr[joint_index(model, name)])
        data.qpos[qpos_index : qpos_index + len(joint_numbers)] = joint_numbers
    mujoco.mj_kinematics(model, data)


def _qpos_numbers(
    model: Any, data: Any, robot: Robot, joint: Joint, dof: Dof, value: tuple[float, ...], urdf: bool
) -> dict[str, list[float]]:
    """Maps the model's joints of a ball or a free dof to their numbers in qpos. `data` is at qpos0."""
    # A free joint's value is relative to the root's pose at qpos0.
    world_from_joint = link_pose(model, data, robot, joint.parent) @ joint.parent_from_joint
    pose = motion(dof.kind, dof.axis, value)
    if dof.kind == "free":
        return {dof.name: free_joint_numbers(world_from_joint @ pose)}
    if urdf:
        angles = turns_from_rotation(pose[:3, :3])
        return {name: [angle] for name, angle in zip(urdf_names(robot).turns[dof.name], angles, strict=True)}
    joint_from_child = inverse(world_from_joint) @ link_pose(model, data, robot, joint.child)
    return {dof.name: list(quat_from_rotation(joint_from_child[:3, :3].T @ pose[:3, :3]))}


def free_joint_numbers(pose: Array) -> list[float]:
    """Returns a pose (4, 4) as a free joint's numbers: position, then quaternion (w, x, y, z)."""
    return [*map(float, pose[:3, 3]), *map(float, quat_from_rotation(pose[:3, :3]))]


def saved_values(robot: Robot) -> dict[str, Value]:
    """Returns the saved values of all dofs, those of the loops included."""
    dofs = (*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs))
    return {dof.name: dof.saved for dof in dofs}


def spread_values(robot: Robot, sample_index: int) -> dict[str, Value]:
    """Returns evenly spread values, the same in every run: scalars within ±1.5, quaternions of any angle."""
    dofs = (*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs))
    widths = [{"ball": 4, "free": 7}.get(dof.kind, 1) for dof in dofs]
    values: dict[str, Value] = {}
    count = sample_index * sum(widths)
    for dof, width in zip(dofs, widths, strict=True):
        # An irrational step spreads the values evenly.
        numbers = [3 * math.modf((count + i + 1) * math.e)[0] - 1.5 for i in range(width)]
        count += width
        length = math.hypot(*numbers[-4:])
        values[dof.name] = numbers[0] if width == 1 else (*numbers[:-4], *(x / length for x in numbers[-4:]))
    return values


def body_from_link(robot: Robot, link: str) -> Array:
    """Returns body_from_link (4, 4): the identity, unless an MJCF source has the body elsewhere."""
    return _bodies_from_links(robot).get(link, UNMOVED)


@functools.lru_cache(maxsize=4)  # called for each link of the same robot
def _bodies_from_links(robot: Robot) -> Mapping[str, Array]:
    bodies = () if robot.mjcf is None else robot.mjcf.bodies
    return {body.link: inverse(body.link_from_body) for body in bodies}


def root_pose(model: Any, data: Any, robot: Robot) -> Array:
    """Returns world_from_root (4, 4). A root called `world` is the world itself, or the site of that name."""
    site = site_index(model, robot.root.name)
    if robot.root.name == "world" and site >= 0:
        return site_pose(model, data, site)
    return pose_of(data, body_index(model, robot.root.name))


def link_pose(model: Any, data: Any, robot: Robot, link: str) -> Array:
    """Returns world_from_link (4, 4), from the link's body, or from its site if it has no body."""
    if link == robot.root.name:
        return root_pose(model, data, robot)
    body = body_index(model, link)
    if body < 0:
        return site_pose(model, data, site_index(model, link))
    return pose_of(data, body) @ body_from_link(robot, link)


def frame_pose(model: Any, data: Any, name: str, urdf: bool) -> Array:
    """Returns world_from_frame (4, 4) of a frame, which is a site, or a body in a URDF; NaN if the frame is
    missing."""
    index = (body_index if urdf else site_index)(model, name)
    if index < 0:
        return np.full((4, 4), np.nan)
    return pose_of(data, index) if urdf else site_pose(model, data, index)


def pose_of(data: Any, body: int) -> Array:
    """Returns world_from_body (4, 4)."""
    pose = np.eye(4)
    pose[:3, :3] = data.xmat[body].reshape(3, 3)
    pose[:3, 3] = data.xpos[body]
    return pose


def site_pose(model: Any, data: Any, site: int) -> Array:
    """Returns world_from_site (4, 4), computed from the site's place on its body, since MuJoCo's kinematics
    merges frames that differ by up to 1e-6."""
    on_body = placed(model.site_quat[site], model.site_pos[site])
    return pose_of(data, int(model.site_bodyid[site])) @ on_body


def placed_by_site(model: Any, link: str) -> Array:
    """Returns world_from_link (4, 4) of a link whose body is the world: the pose of the site with the link's
    name, or the identity without such a site."""
    site = site_index(model, link)
    return UNMOVED if site < 0 else placed(model.site_quat[site], model.site_pos[site])


def distance(actual: Array, expected: Array, *, unresolved: float = 0.0) -> float:
    """Returns the larger of the offset [m] and the angle [rad, for small angles] between two poses (4, 4);
    infinity if a pose has a NaN. The angle is reduced by `unresolved`."""
    difference = actual - expected
    offset = math.hypot(*difference[:3, 3])
    # For a turn by a small angle, the norm of the difference is √2 times the angle.
    angle = float(np.linalg.norm(difference[:3, :3])) / math.sqrt(2)
    return largest_error((offset, angle - unresolved))
