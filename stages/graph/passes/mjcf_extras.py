"""Places the extras of an MJCF on the robot's links and joints."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from linkwright.stages.graph.mechanism import Mechanism
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.mjcf_extras import MjcfAttributes, MjcfBodyFrame, MjcfMounted
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array, Dof, Robot, frozen
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration

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
    if root is not None:
        bodies, mounted = _with_root(root, bodies, mounted)
    return replace(robot, mjcf=replace(extras, bodies=bodies, mounted=mounted))


def with_mjcf(robot: Robot, mechanism: Mechanism, keys: GraphSections, log: Diagnostics) -> Robot:
    """Returns the robot whose extras lack the attributes of missing links, and of values that the
    configuration sets. Reports W-MJCF-LEFT for joints that follow other joints than in the source."""
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
            robot.mjcf, attributes=tuple(attribute_set for attribute_set in attributes if attribute_set)
        ),
    )


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
    """Returns the attributes without those whose values the configuration sets; None if none remains.
    `loops`: the loops whose solref the configuration sets."""
    if attributes.kind in ("body", "freejoint"):
        return attributes if attributes.name in links else None
    if attributes.kind == "equality" and attributes.name in loops:
        return None
    if attributes.kind != "joint" or attributes.name not in dofs:
        return attributes
    prefixes = tuple(
        _ATTRIBUTE_PREFIXES[name] for name in dofs[attributes.name].given if name in _ATTRIBUTE_PREFIXES
    )
    remaining = tuple(
        pair for pair in attributes.attributes if not (prefixes and pair[0].startswith(prefixes))
    )
    return replace(attributes, attributes=remaining) if remaining else None
