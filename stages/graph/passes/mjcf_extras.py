"""Places the extras of an MJCF on the robot's links and joints."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from linkwright.stages.formats.numbers import exact
from linkwright.stages.graph.mechanism import Mechanism
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.mjcf_extras import (
    MjcfAttributes,
    MjcfBodyFrame,
    MjcfExtras,
    MjcfKeyframe,
    MjcfMounted,
)
from linkwright.stages.robot.model.poses import from_parts, inverse, quat_from_rotation, rotation_from_quat
from linkwright.stages.robot.model.robot import Array, Dof, Robot, frozen
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration
from linkwright.stages.robot.motion.start_pose import keyframes

FRAME_TOLERANCE = 1e-12
"""Largest difference of a pose from the identity that counts as rounding."""

_ATTRIBUTE_PREFIXES = {
    "damping": "damping",
    "friction": "frictionloss",
    "armature": "armature",
    "effort": "actuatorfrc",
}
"""Quantity that the configuration may give a dof → prefix of the MJCF attributes for the same quantity."""


def with_bodies(robot: Robot, mechanism: Mechanism) -> Robot:
    """Adds the mechanism's extras to a robot at the mechanism's own pose: the source's bodies and the
    elements on them. They are placed on the links, whose frames depend on the root."""
    extras = mechanism.mjcf
    if extras is None:
        return robot
    poses = link_poses(robot, saved_configuration(robot))
    world_from_bodies = {body.name: body.world_from_body for body in mechanism.bodies}

    def link_from_body(frame: MjcfBodyFrame) -> Array:
        world_from_link = robot.world_from_root @ poses[frame.link]
        return frozen(inverse(world_from_link) @ world_from_bodies[frame.link] @ frame.link_from_body)

    bodies = tuple(
        replace(frame, link_from_body=link_from_body(frame)) for frame in extras.bodies if frame.link in poses
    )
    mounted = tuple(element for element in extras.mounted if element.link in poses)
    root = next((frame for frame in bodies if frame.link == robot.root.name), None)
    root_bodies = bodies
    if root is not None:
        root_bodies, mounted = _with_root(root, bodies, mounted)
    floating = _floating_link(mechanism)
    link_from_floating = next((frame.link_from_body for frame in bodies if frame.link == floating), np.eye(4))
    return replace(
        robot,
        mjcf=replace(
            extras,
            bodies=root_bodies,
            mounted=mounted,
            keyframes=tuple(_moved_keyframe(keyframe, link_from_floating) for keyframe in extras.keyframes),
        ),
    )


def with_mjcf(robot: Robot, mechanism: Mechanism, keys: GraphSections, log: Diagnostics) -> Robot:
    """Returns the robot whose extras lack the attributes of missing links, and of values that the
    configuration sets, and whose keyframes place the robot's root. Reports W-MJCF-LEFT for joints that follow
    other joints than in the source."""
    if robot.mjcf is None:
        return robot
    links = {link.name for link in robot.links}
    dofs = {dof.name: dof for dof in robot.dofs}
    attributes = (
        _remaining_attributes(attribute_set, dofs, links, _configured_loops(robot, keys))
        for attribute_set in robot.mjcf.attributes
    )
    _report_chains(robot, mechanism, log)
    return replace(
        robot,
        mjcf=replace(
            robot.mjcf,
            attributes=tuple(attribute_set for attribute_set in attributes if attribute_set),
            keyframes=_keyframes_of_root(robot, robot.mjcf, _floating_link(mechanism)),
        ),
    )


def _floating_link(mechanism: Mechanism) -> str:
    """Returns the link that floats in the source, "" without one. The source's keyframes have no place of the
    robot if several links float."""
    return next((body.name for body in mechanism.bodies if body.floating_joint is not None), "")


def _keyframes_of_root(robot: Robot, extras: MjcfExtras, floating: str) -> tuple[MjcfKeyframe, ...]:
    """Returns the keyframes with the place of the robot's root, which the user may choose, instead of that of
    the link `floating`."""
    has_places = any(keyframe.world_from_root for keyframe in extras.keyframes)
    if not has_places or robot.base.fixed or floating == robot.root.name:
        return extras.keyframes
    is_present = any(link.name == floating for link in robot.links)
    if not is_present or any(dof.kind == "free" for dof in robot.dofs):
        # The link is left out, or floats relative to the root: the source does not place the root.
        return tuple(replace(keyframe, world_from_root=()) for keyframe in extras.keyframes)
    values = keyframes(robot)
    return tuple(
        _moved_keyframe(keyframe, link_poses(robot, values[keyframe.name])[floating])
        if keyframe.name in values
        else keyframe
        for keyframe in extras.keyframes
    )


def _moved_keyframe(keyframe: MjcfKeyframe, new_from_old: Array) -> MjcfKeyframe:
    """Returns a keyframe that places another frame, in which the frame placed so far is at `new_from_old`
    (4, 4)."""
    if not keyframe.world_from_root or np.abs(new_from_old - np.eye(4)).max() < FRAME_TOLERANCE:
        return keyframe
    x, y, z, *quat = keyframe.world_from_root
    world_from_old = from_parts(rotation_from_quat(np.array(quat)), np.array([x, y, z]))
    world_from_new = world_from_old @ inverse(new_from_old)
    numbers = (*world_from_new[:3, 3], *quat_from_rotation(world_from_new[:3, :3]))
    return replace(keyframe, world_from_root=tuple(float(number) for number in numbers))


def _configured_loops(robot: Robot, keys: GraphSections) -> set[str]:
    """Returns the loops whose stiffness the configuration gives."""
    return set() if keys.loops.solref is None else {loop.name for loop in robot.loops}


def _report_chains(robot: Robot, mechanism: Mechanism, log: Diagnostics) -> None:
    """Reports W-MJCF-LEFT for a joint that follows a follower: it is written as following that follower's
    driver."""
    pairs = {relation.name: tuple(relation.connections) for relation in mechanism.relations}
    for relation in robot.relations:
        pair = (relation.driver, relation.follower)
        if relation.name in pairs and pairs[relation.name] != pair:
            driver, follower = pairs[relation.name]
            text = (
                f"the equality of {follower} and {driver} is written as one of {relation.follower} and "
                f"{relation.driver}: the positions are the same, but under load it may yield differently"
            )
            hint = "let each follower follow the joint that is driven"
            log.report("W-MJCF-LEFT", text, relation.name, hint)


def _with_root(
    root: MjcfBodyFrame, bodies: tuple[MjcfBodyFrame, ...], mounted: tuple[MjcfMounted, ...]
) -> tuple[tuple[MjcfBodyFrame, ...], tuple[MjcfMounted, ...]]:
    """Returns the bodies and mounted elements with the frame of the root's body at that of its link, which
    the user may choose."""
    pose, axes = root.link_from_body, root.body_from_inertial
    root_at_link = replace(
        root,
        link_from_body=frozen(np.eye(4)),
        body_from_inertial=None if axes is None else frozen(pose[:3, :3] @ axes),
    )
    return (
        tuple(root_at_link if body is root else body for body in bodies),
        tuple(
            replace(element, body_from_element=frozen(pose @ element.body_from_element))
            if element.link == root.link
            else element
            for element in mounted
        ),
    )


def _remaining_attributes(
    attributes: MjcfAttributes, dofs: Mapping[str, Dof], links: set[str], loops: set[str]
) -> MjcfAttributes | None:
    """Returns the attributes without those whose values the configuration sets; None if none remains. If the
    configuration inverts a joint's value, the joint's attributes are inverted too. `loops`: the loops whose
    solref the configuration sets."""
    if attributes.kind in ("body", "freejoint"):
        return attributes if attributes.name in links else None
    if attributes.kind == "equality" and attributes.name in loops:
        return None
    if attributes.kind != "joint" or attributes.name not in dofs:
        return attributes
    dof = dofs[attributes.name]
    prefixes = tuple(_ATTRIBUTE_PREFIXES[name] for name in dof.given if name in _ATTRIBUTE_PREFIXES)
    remaining = tuple(
        (name, _inverted_value(name, text) if dof.mate_value.sign < 0 else text)
        for name, text in attributes.attributes
        if not (prefixes and name.startswith(prefixes))
    )
    return replace(attributes, attributes=remaining) if remaining else None


def _inverted_value(name: str, text: str) -> str:
    """Returns the value of a joint's attribute for the opposite direction."""
    if name == "actuatorfrcrange":
        return exact(-float(end) + 0.0 for end in reversed(text.split()))
    if name == "stiffness":
        # The force k₀ x + k₁ x² + k₂ x³ changes its sign with x if the coefficients of even powers do.
        return exact(float(number) * (-1) ** power + 0.0 for power, number in enumerate(text.split()))
    return text
