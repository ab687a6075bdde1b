"""Builds a robot from a mechanism and its tree: frames, joints, loops and links.

The dofs of a connection lead from the frame of its second entity to that of its first. If the first entity is
on the parent, the chain runs backwards and every axis is negated, so that a value keeps its meaning. The
frame of a child link is that of its entity.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from linkwright.stages.graph.dofs import reversed_dofs
from linkwright.stages.graph.mechanism import Connection, Mechanism, RigidBody
from linkwright.stages.graph.root import base_of
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.graph.tree import Edge, Tree
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.inertia import merged, moved
from linkwright.stages.robot.model.poses import at_rest, inverse
from linkwright.stages.robot.model.robot import (
    Array,
    Dof,
    Dynamics,
    Frame,
    Joint,
    Limits,
    Link,
    Loop,
    Mobility,
    Robot,
    frozen,
)
from linkwright.stages.robot.motion.tree_paths import paths_up
from linkwright.stages.robot.text.globs import matches_glob, no_match_hint
from linkwright.stages.robot.text.names import free_name

SOLREF = (0.005, 1.0)
"""MuJoCo's solref of a loop without its own: time constant [s] and damping ratio."""

POSE_TOLERANCE = 1e-6
"""Largest error [m, rad] of a mate at the saved pose that is not reported."""


def place(mechanism: Mechanism, tree: Tree, keys: GraphSections, log: Diagnostics) -> Robot:
    """Returns the robot along the tree, at the mechanism's saved pose."""
    world_from_link: dict[int, Array] = {tree.root: tree.world_from_root}
    taken_names = {dof.name for c in mechanism.connections for dof in c.dofs} | {
        c.name for c in mechanism.connections
    }
    taken_names |= {body.name for body in mechanism.bodies}
    joints = []
    for edge in tree.edges:
        if edge.connection is None:
            world_from_link[edge.child] = mechanism.bodies[edge.child].world_from_body
            joints.append(_replacement_joint(edge, mechanism, world_from_link, taken_names))
        else:
            joints.append(_joint(edge, edge.connection, mechanism, world_from_link))
            _check_pose(edge.connection, log)
            _check_floating(joints[-1], mechanism.bodies[tree.root].name, log)
    for connection in tree.cut:
        _check_pose(connection, log)
    parents = {edge.child: edge.parent for edge in tree.edges}
    order = {body: number for number, body in enumerate(tree.order)}
    return Robot(
        name=keys.name,
        links=tuple(_link(mechanism.bodies[body], world_from_link[body]) for body in tree.order),
        joints=tuple(joints),
        loops=tuple(
            _loop(
                connection,
                mechanism,
                paths_up(*connection.bodies, parents, order),
                world_from_link,
                keys.loops.solref or connection.solref or SOLREF,
            )
            for connection in tree.cut
        ),
        relations=(),
        frames=_frames(mechanism, world_from_link, keys.frames.include, log),
        base=base_of(mechanism, tree.root, keys.root, log),
        world_from_root=frozen(tree.world_from_root),
        mobility=Mobility(0, 0, 0, ()),
        provenance=mechanism.provenance,
    )


def _joint(
    edge: Edge, connection: Connection, mechanism: Mechanism, world_from_link: dict[int, Array]
) -> Joint:
    first, second = connection.world_from_frames
    backwards = connection.bodies[0] != edge.child
    parent, child = (first, second) if backwards else (second, first)
    world_from_link[edge.child] = child
    return Joint(
        name=connection.name,
        type=connection.type,
        parent=mechanism.bodies[edge.parent].name,
        child=mechanism.bodies[edge.child].name,
        parent_from_joint=frozen(inverse(world_from_link[edge.parent]) @ parent),
        dofs=reversed_dofs(connection.dofs) if backwards else connection.dofs,
        backwards=backwards,
        mate=connection.ref,
    )


def _replacement_joint(
    edge: Edge, mechanism: Mechanism, world_from_link: Mapping[int, Array], taken_names: set[str]
) -> Joint:
    """Returns the fixed or free joint of a link that no connection joins to the root."""
    body = mechanism.bodies[edge.child]
    child = body.name
    name = (edge.replacement == "free" and body.floating_joint) or free_name(
        f"{child}_{edge.replacement}", taken_names
    )
    taken_names.add(name)
    zero = frozen(np.zeros(3))
    floating = Dof(name, "free", zero, frozen(np.eye(4)), Limits(), Dynamics(), at_rest("free"))
    return Joint(
        name=name,
        type=edge.replacement,
        parent=mechanism.bodies[edge.parent].name,
        child=child,
        parent_from_joint=frozen(inverse(world_from_link[edge.parent]) @ world_from_link[edge.child]),
        dofs=(floating,) if edge.replacement == "free" else (),
        backwards=False,
        mate=None,
    )


def _check_floating(joint: Joint, root: str, log: Diagnostics) -> None:
    """Reports E-FLOATING for a link that floats relative to another link than the root."""
    if joint.type == "free" and joint.parent != root:
        text = f"it floats relative to the moving link {joint.parent!r}; only the root {root!r} is allowed"
        hint = f"make the root its parent, or choose the root: root.select={joint.parent}"
        log.report("E-FLOATING", text, joint.name, hint)


def _check_pose(connection: Connection, log: Diagnostics) -> None:
    if connection.residual > POSE_TOLERANCE:
        text = (
            f"the saved pose breaks this {connection.ref.type} mate by {connection.residual:.2g} (m or rad)"
        )
        log.report("W-MATE-POSE", text, connection.title, "solve the assembly in Onshape: a mate is in error")


def _link(body: RigidBody, world_from_link: Array) -> Link:
    link_from_world = inverse(world_from_link)
    parts = tuple(
        replace(part, link_from_part=frozen(link_from_world @ part.link_from_part)) for part in body.parts
    )
    own_inertial = None if body.own_inertial is None else moved(body.own_inertial, link_from_world)
    sum_of_parts = merged([moved(part.inertial, part.link_from_part) for part in parts])
    shapes = tuple(
        replace(shape, link_from_shape=frozen(link_from_world @ shape.link_from_shape))
        for shape in body.shapes
    )
    return Link(body.name, own_inertial or sum_of_parts, parts, body.path, own_inertial, shapes)


def _loop(
    connection: Connection,
    mechanism: Mechanism,
    paths: tuple[list[int], list[int]],
    world_from_link: Mapping[int, Array],
    solref: tuple[float, float],
) -> Loop:
    """Returns a loop; `paths`: the paths from the first and from the second entity's body up the tree to
    where they meet."""
    first_body, second_body = connection.bodies
    first, second = connection.world_from_frames
    return Loop(
        name=connection.name,
        type=connection.type,
        link_a=mechanism.bodies[first_body].name,
        link_b=mechanism.bodies[second_body].name,
        a_from_frame=frozen(inverse(world_from_link[first_body]) @ first),
        b_from_frame=frozen(inverse(world_from_link[second_body]) @ second),
        dofs=connection.dofs,
        lever=_lever(first[:3, 3], [world_from_link[body][:3, 3] for path in paths for body in path]),
        solref=solref,
        residual=connection.residual,
        mate=connection.ref,
    )


def _lever(origin: Array, origins: list[Array]) -> float:
    """Returns half of the largest distance [m] of the loop's links from its closing joint, 0.05 m if that is
    0: a length on the scale of the mechanism."""
    reach = max((float(np.linalg.norm(other - origin)) for other in origins), default=0.0)
    return reach / 2 if reach > 1e-6 else 0.05


def _frames(
    mechanism: Mechanism, world_from_link: Mapping[int, Array], include: tuple[str, ...], log: Diagnostics
) -> tuple[Frame, ...]:
    """Returns the mate connectors that `frames.include` chooses, on their links; reports E-GLOB for a glob
    that chooses none."""
    for glob in include:
        if not any(matches_glob(marker.name, glob) for marker in mechanism.markers):
            hint = no_match_hint(glob, {"frames": [marker.name for marker in mechanism.markers]})
            log.report_unmatched("E-GLOB", f"no frame matches {glob!r}", "frames.include", hint, glob)
    frames = [
        Frame(
            marker.name,
            mechanism.bodies[marker.body].name,
            frozen(inverse(world_from_link[marker.body]) @ marker.world_from_frame),
            marker.source,
            marker.joint,
        )
        for marker in mechanism.markers
        if marker.body in world_from_link and any(matches_glob(marker.name, glob) for glob in include)
    ]
    return tuple(sorted(frames, key=lambda frame: frame.name))
