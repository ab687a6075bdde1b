"""What only an MJCF has, on the robot's present links and joints."""

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

_GIVEN = {
    "damping": "damping",
    "friction": "frictionloss",
    "armature": "armature",
    "effort": "actuatorfrc",
}
"""What the configuration may give a dof, and how the attributes begin that say the same."""


def with_bodies(robot: Robot, mechanism: Mechanism) -> Robot:
    """The robot, as it is placed at the mechanism's own pose, with the mechanism's extras: where the source's
    bodies are on the links, whose frames depend on the root, and what is on them."""
    extras = mechanism.mjcf
    if extras is None:
        return robot
    poses = link_poses(robot, saved_configuration(robot))
    read = {body.name: body.world_from_body for body in mechanism.bodies}

    def placed(one: MjcfBodyFrame) -> Array:
        world_from_link = robot.world_from_root @ poses[one.link]
        return frozen(inverse(world_from_link) @ read[one.link] @ one.link_from_body)

    bodies = tuple(replace(one, link_from_body=placed(one)) for one in extras.bodies if one.link in poses)
    mounted = tuple(one for one in extras.mounted if one.link in poses)
    root = next((one for one in bodies if one.link == robot.root.name), None)
    if root is not None:
        bodies, mounted = _with_root(root, bodies, mounted)
    return replace(robot, mjcf=replace(extras, bodies=bodies, mounted=mounted))


def with_mjcf(robot: Robot, mechanism: Mechanism, keys: GraphSections, log: Diagnostics) -> Robot:
    """The robot's extras without attributes of links that are not there, and of values that the configuration
    gives. W-MJCF-LEFT for joints that follow others than in the source."""
    if robot.mjcf is None:
        return robot
    links = {link.name for link in robot.links}
    dofs = {dof.name: dof for dof in robot.dofs}
    attributes = (_kept(one, dofs, links, _loops(robot, keys)) for one in robot.mjcf.attributes)
    _report_chains(robot, mechanism, log)
    return replace(robot, mjcf=replace(robot.mjcf, attributes=tuple(one for one in attributes if one)))


def _loops(robot: Robot, keys: GraphSections) -> set[str]:
    """The loops that are as stiff as the configuration says."""
    return set() if keys.loops.solref is None else {loop.name for loop in robot.loops}


def _report_chains(robot: Robot, mechanism: Mechanism, log: Diagnostics) -> None:
    """A joint that follows one which follows another is written as following that."""
    pairs = {one.name: tuple(one.connections) for one in mechanism.relations}
    for relation in robot.relations:
        written = (relation.driver, relation.follower)
        if relation.name in pairs and pairs[relation.name] != written:
            driver, follower = pairs[relation.name]
            text = (
                f"the equality of {follower} and {driver} is written as one of {relation.follower} and "
                f"{relation.driver}: the same positions, but it may yield otherwise under load"
            )
            hint = "let each follower follow the joint that is driven"
            log.report("W-MJCF-LEFT", text, relation.name, hint)


def _with_root(
    root: MjcfBodyFrame, bodies: tuple[MjcfBodyFrame, ...], mounted: tuple[MjcfMounted, ...]
) -> tuple[tuple[MjcfBodyFrame, ...], tuple[MjcfMounted, ...]]:
    """The same with the root's body in the frame of its link, which the user may choose."""
    pose, axes = root.link_from_body, root.body_from_inertial
    moved = replace(
        root,
        link_from_body=frozen(np.eye(4)),
        body_from_inertial=None if axes is None else frozen(pose[:3, :3] @ axes),
    )
    return (
        tuple(moved if one is root else one for one in bodies),
        tuple(
            replace(one, body_from_element=frozen(pose @ one.body_from_element))
            if one.link == root.link
            else one
            for one in mounted
        ),
    )


def _kept(
    one: MjcfAttributes, dofs: Mapping[str, Dof], links: set[str], loops: set[str]
) -> MjcfAttributes | None:
    """Attributes without those that the configuration gives; `loops`: the loops whose solref it gives."""
    if one.kind in ("body", "freejoint"):
        return one if one.name in links else None
    if one.kind == "equality" and one.name in loops:
        return None
    if one.kind != "joint" or one.name not in dofs:
        return one
    given = tuple(_GIVEN[name] for name in dofs[one.name].given if name in _GIVEN)
    left = tuple(pair for pair in one.attributes if not (given and pair[0].startswith(given)))
    return replace(one, attributes=left) if left else None
