"""Adds links and frames that CAD does not have: a payload, a foot under the base, a tool's tip."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeVar

import numpy as np

from linkwright.stages.graph.added_section import AddedFrameSection, AddedJointSection, AddedLinkSection
from linkwright.stages.graph.globs import names_in, why_unusable
from linkwright.stages.graph.mechanism import WORLD_LINK
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.inertia import ZERO, primitive_inertial, tensor
from linkwright.stages.robot.model.poses import from_parts, inverse, rotation_from_rpy
from linkwright.stages.robot.model.robot import (
    Array,
    Dof,
    Dynamics,
    Frame,
    Inertial,
    Joint,
    JointType,
    Limits,
    Link,
    Primitive,
    Robot,
    frozen,
)
from linkwright.stages.robot.text.globs import no_match_hint
from linkwright.stages.robot.text.names import free_name

TYPES: Mapping[str, JointType] = {
    "fixed": "fixed",
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
}

SectionT = TypeVar("SectionT")


def with_added_links(robot: Robot, sections: Mapping[str, AddedLinkSection], log: Diagnostics) -> Robot:
    """Returns the robot with the links of `sections` after its own links, sorted by name, but each after its
    parent.
    A link above the root becomes the root, with the root's base. Reports E-LINK for a parent or a child that
    does not exist, E-NAME for a name that is not free.
    """
    section_names = {*sections, *(keys.joint.name for keys in sections.values() if keys.joint.name)}

    def has_parent(robot: Robot, keys: AddedLinkSection) -> bool:
        if keys.child is not None:
            return keys.child == robot.root.name != WORLD_LINK
        return _parent_pose(robot, keys.parent or "") is not None

    def add(robot: Robot, name: str, keys: AddedLinkSection) -> Robot:
        taken_names = names_in(robot)
        joint = keys.joint.name or free_name(f"{name}_joint", taken_names | section_names)
        reasons = [why_unusable(name, taken_names), why_unusable(joint, {*taken_names, name})]
        for reason in filter(None, reasons):
            log.report("E-NAME", reason, f"links.{name}", "links, joints and frames share their names")
        return robot if any(reasons) else _with_link(robot, name, joint, keys)

    def report_missing_parent(robot: Robot, name: str, keys: AddedLinkSection) -> None:
        if keys.child is None:
            text, hint = (
                f"its parent {keys.parent!r} is not a link or frame",
                _parents_hint(robot, keys.parent or ""),
            )
        elif robot.root.name == WORLD_LINK:
            text, hint = "the root is the assembly's origin, which cannot have a parent", "give it a parent"
        else:
            text, hint = f"{keys.child!r} is not the root", f"the root is {robot.root.name!r}"
        log.report("E-LINK", text, f"links.{name}", hint)

    return _add_in_order(robot, sections, has_parent, add, report_missing_parent)


def with_added_frames(robot: Robot, sections: Mapping[str, AddedFrameSection], log: Diagnostics) -> Robot:
    """Returns the robot with the frames of `sections`, all frames sorted by name; the parent of a frame may
    be another frame.

    Reports E-FRAME for a link or frame that does not exist, E-NAME for a name that is not free.
    """

    def has_parent(robot: Robot, keys: AddedFrameSection) -> bool:
        return _parent_pose(robot, keys.link) is not None

    def add(robot: Robot, name: str, keys: AddedFrameSection) -> Robot:
        reason = why_unusable(name, names_in(robot))
        if reason:
            hint = "links, joints and frames share their names"
            log.report("E-NAME", reason, f"frames.add.{name}", hint)
            return robot
        link, link_from_parent = _parent_pose(robot, keys.link) or (keys.link, np.eye(4))
        frame = Frame(name, link, frozen(link_from_parent @ _pose(keys)), "")
        return replace(robot, frames=tuple(sorted((*robot.frames, frame), key=lambda added: added.name)))

    def report_missing_parent(robot: Robot, name: str, keys: AddedFrameSection) -> None:
        text = f"its link {keys.link!r} is not a link or frame"
        log.report("E-FRAME", text, f"frames.add.{name}", _parents_hint(robot, keys.link))

    return _add_in_order(robot, sections, has_parent, add, report_missing_parent)


def _add_in_order(
    robot: Robot,
    sections: Mapping[str, SectionT],
    has_parent: Callable[[Robot, SectionT], bool],
    add: Callable[[Robot, str, SectionT], Robot],
    report_missing_parent: Callable[[Robot, str, SectionT], None],
) -> Robot:
    """Adds each section's item once its parent exists; `report_missing_parent` reports the others."""
    waiting = dict(sorted(sections.items()))
    while ready := [name for name, keys in waiting.items() if has_parent(robot, keys)]:
        robot = add(robot, ready[0], waiting.pop(ready[0]))
    for name, keys in waiting.items():
        report_missing_parent(robot, name, keys)
    return robot


def _with_link(robot: Robot, name: str, joint: str, keys: AddedLinkSection) -> Robot:
    link = _link(name, keys)
    if keys.child is not None:
        new_joint = _joint(joint, keys.joint, name, keys.child, _pose(keys))
        # A floating link floats relative to the root, so the new root becomes its parent.
        children = (
            _floating_from(name, new_joint, below_root) if below_root.type == "free" else below_root
            for below_root in robot.joints
        )
        return replace(
            robot,
            links=(link, *robot.links),
            joints=(new_joint, *children),
            world_from_root=frozen(robot.world_from_root @ inverse(new_joint.parent_from_joint)),
        )
    parent, link_from_place = _parent_pose(robot, keys.parent or "") or ("", np.eye(4))
    new_joint = _joint(joint, keys.joint, parent, name, link_from_place @ _pose(keys))
    return replace(robot, links=(*robot.links, link), joints=(*robot.joints, new_joint))


def _floating_from(root: str, root_from_old: Joint, joint: Joint) -> Joint:
    place = root_from_old.parent_from_joint @ joint.parent_from_joint
    return replace(joint, parent=root, parent_from_joint=frozen(place))


def _joint(name: str, keys: AddedJointSection, parent: str, child: str, parent_from_joint: Array) -> Joint:
    axis = np.array(keys.axis)
    dof = Dof(
        name=name,
        kind="slide" if keys.type == "prismatic" else "turn",
        axis=frozen(axis / np.linalg.norm(axis)),
        origin=frozen(np.eye(4)),
        limits=Limits(*(None if end is None else float(end) for end in keys.limits or ())),
        dynamics=Dynamics(),
        saved=0.0,
        given=("limits",) if keys.limits else (),
    )
    dofs = () if keys.type == "fixed" else (dof,)
    return Joint(name, TYPES[keys.type], parent, child, frozen(parent_from_joint), dofs, False, None)


def _link(name: str, keys: AddedLinkSection) -> Link:
    inertial = _inertial(keys)
    shapes: tuple[Primitive, ...] = ()
    if keys.geometry is not None:
        kind, size = keys.geometry.shape()
        shapes = (Primitive(kind, size, frozen(np.eye(4))),)
    return Link(name, inertial or ZERO, (), (), inertial, shapes)


def _inertial(keys: AddedLinkSection) -> Inertial | None:
    if keys.mass is None:
        return None
    if keys.inertia is not None:
        inertia = tensor(keys.inertia)
    else:
        assert keys.geometry is not None
        inertia = primitive_inertial(*keys.geometry.shape(), keys.mass).inertia
    return Inertial(keys.mass, frozen(keys.com or (0.0, 0.0, 0.0)), inertia)


def _parent_pose(robot: Robot, name: str) -> tuple[str, Array] | None:
    """Returns the link of a name, which is that of a link or of a frame, with the pose (4, 4) of the named
    link or frame in it; None for an unknown name."""
    if any(link.name == name for link in robot.links):
        return name, np.eye(4)
    return next(((f.link, f.link_from_frame) for f in robot.frames if f.name == name), None)


def _parents_hint(robot: Robot, name: str) -> str:
    frames = {"frames": [frame.name for frame in robot.frames]} if robot.frames else {}
    return no_match_hint(name, {"links": [link.name for link in robot.links], **frames})


def _pose(keys: AddedLinkSection | AddedFrameSection) -> Array:
    return from_parts(rotation_from_rpy(keys.rpy), np.array(keys.xyz))
