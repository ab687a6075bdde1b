"""Where a file's kinematics leaves the robot's: the first elements of the tree that are not as they must be.

Each link is looked at from its parent alone, so that what is wrong above it does not count for it.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import mujoco
import numpy as np

from stages.formats.urdf.names import urdf_names
from stages.robot.check import Finding
from stages.robot.kinematics import link_poses, rest_configuration
from stages.robot.model import Array, Configuration, Dof, Joint, Robot
from stages.robot.poses import inverse
from stages.robot.start_pose import starting_point
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import (
    SAME,
    body_index,
    distance,
    frame_pose,
    joint_index,
    link_pose,
    set_values,
    site_index,
    spread,
)
from stages.validate.findings import apart, differs, few, link, named, place_differs


def culprits(compiled: CompiledModel) -> tuple[Finding, ...]:
    """Findings on links and frames whose pose on what carries them is not the robot's, parents first."""
    robot, model = compiled.robot, compiled.model
    data = mujoco.MjData(model)
    poses = []
    for q in (rest_configuration(robot), *(spread(robot, turn) for turn in range(3))):
        loops = {dof.name: dof.saved for loop in robot.loops for dof in loop.dofs}
        q = {**loops, **q}
        set_values(model, data, robot, q, compiled.urdf)
        found = {one.name: link_pose(model, data, robot, one.name) for one in robot.links}
        frames = {one.name: _frame(compiled, data, one.name) for one in robot.frames}
        poses.append((q, found, link_poses(robot, q), frames))
    return few([*_joints(compiled, poses), *_frames(compiled, poses)])


_Poses = Sequence[tuple[Configuration, dict[str, Array], dict[str, Array], dict[str, Array]]]
"""Values, the file's link poses, the robot's, and the file's poses of frames: at rest first."""


def _joints(compiled: CompiledModel, poses: _Poses) -> Iterator[Finding]:
    starts = {} if compiled.urdf else starting_point(compiled.robot)
    for joint in compiled.robot.joints:
        pairs = [
            tuple(inverse(one[joint.parent]) @ one[joint.child] for one in (found, expected))
            for _, found, expected, _ in poses
        ]
        if all(distance(*pair) <= SAME for pair in pairs):
            continue
        parent = _parent(compiled, joint.child)
        if parent != joint.parent:
            element = named("joint", joint.name) if compiled.urdf else link(joint.child, False)
            yield differs(element, "parent", parent or "none of the robot's links", joint.parent)
            continue
        yield from _of_joint(compiled, joint, pairs, starts)


def _of_joint(
    compiled: CompiledModel, joint: Joint, pairs: list[tuple[Array, ...]], starts: Configuration
) -> Iterator[Finding]:
    """What is wrong with a joint: its axis or place where the child moves otherwise than from where it
    stands, else where the child stands."""
    model, urdf = compiled.model, compiled.urdf
    (rest, wanted), *others = pairs
    moved = [(inverse(rest) @ found, inverse(wanted) @ expected) for found, expected in others]
    off = [apart(*pair) for pair in moved]
    scalars = [dof for dof in joint.dofs if dof.kind in ("turn", "slide")]
    if joint.dofs and max(value for both in off for value in both) > SAME:
        dof = next((one for one in scalars if not _same_axis(compiled, joint, one)), joint.dofs[0])
        element = named("joint", dof.name)
        turned = max(angle for _, angle in off) > SAME
        if dof.kind == "slide" or (dof.kind == "turn" and turned):
            own = np.array(model.jnt_axis[joint_index(model, dof.name)])
            yield differs(element, "axis xyz" if urdf else "axis", own, dof.axis)
        elif turned:
            yield Finding(element, "origin rpy" if urdf else "type", "turns otherwise than the robot's")
        else:
            yield Finding(element, "origin xyz" if urdf else "pos", "is not where the robot's axis is")
        return
    for dof in () if urdf else scalars:
        zero, start = float(model.qpos0[model.jnt_qposadr[joint_index(model, dof.name)]]), starts[dof.name]
        if not isinstance(start, tuple) and not abs(zero - start) <= SAME * max(1.0, abs(start)):
            yield differs(named("joint", dof.name), "ref", zero, start)
            return
    first = joint.dofs[0].name if joint.dofs else joint.name
    if urdf and joint.dofs and joint.dofs[0].kind == "ball":
        first = urdf_names(compiled.robot).turns[first][0]
    element = named("joint", first) if urdf else link(joint.child, False)
    attributes = ("origin xyz", "origin rpy") if urdf else ("pos", "quat")
    yield from place_differs(element, rest, wanted, attributes, SAME)


def _same_axis(compiled: CompiledModel, joint: Joint, dof: Dof) -> bool:
    """Whether the file's axis is that of the dof: of the joints of one body only the last is sure to be in
    the axes of its child, and so is the only one."""
    own = np.array(compiled.model.jnt_axis[joint_index(compiled.model, dof.name)])
    return len(joint.dofs) > 1 or float(np.abs(own - dof.axis).max()) <= SAME


def _parent(compiled: CompiledModel, child: str) -> str:
    """The link that carries another in the file; "" where the way up meets none of the robot's."""
    model = compiled.model
    own = {one.name for one in compiled.robot.links}
    body = body_index(model, child)
    if body < 0:
        site = site_index(model, child)
        holder = int(model.site_bodyid[site]) if site >= 0 else 0
    else:
        holder = int(model.body_parentid[body])
    while holder > 0 and model.body(holder).name not in own:
        holder = int(model.body_parentid[holder])
    name = str(model.body(holder).name)
    return name if name in own else ""


def _frames(compiled: CompiledModel, poses: _Poses) -> Iterator[Finding]:
    _, found, _, frames = poses[0]
    urdf = compiled.urdf
    names = urdf_names(compiled.robot) if urdf else None
    for frame in compiled.robot.frames:
        own = inverse(found[frame.link]) @ frames[frame.name]
        name = names.frames[frame.name] if names else frame.name
        element = named("joint", names.holders[name]) if names else named("site", name)
        if np.isnan(own).any():
            yield Finding(link(name, True) if names else element, "name", "there is none of this name")
        elif not distance(own, frame.link_from_frame) <= SAME:
            attributes = ("origin xyz", "origin rpy") if urdf else ("pos", "quat")
            yield from place_differs(element, own, frame.link_from_frame, attributes, SAME)


def _frame(compiled: CompiledModel, data: Any, name: str) -> Array:
    robot: Robot = compiled.robot
    own = urdf_names(robot).frames[name] if compiled.urdf else name
    return frame_pose(compiled.model, data, own, compiled.urdf)
