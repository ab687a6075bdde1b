"""Finds the fixed bodies, the floating bodies and the root of an MJCF."""

from collections.abc import Sequence

import numpy as np

from linkwright.stages.formats.mjcf.model import Mjcf, MjcfBody
from linkwright.stages.graph.mjcf.equalities import ClosureJoint

FRAME_TOLERANCE = 1e-12
"""Largest difference of two transforms' entries that counts as rounding."""


def _world_children(mjcf: Mjcf) -> list[int]:
    """Returns the numbers of the bodies directly below the world (0)."""
    return [number for number, body in enumerate(mjcf.bodies) if number and body.parent == 0]


def floats(body: MjcfBody) -> bool:
    """Tells whether a body has a free joint."""
    return any(joint.type == "free" for joint in body.joints)


def base_of(mjcf: Mjcf) -> int | None:
    """Returns the base: the only child of the world that does not float, if it has no joint; else None."""
    not_floating = [number for number in _world_children(mjcf) if not floats(mjcf.bodies[number])]
    return not_floating[0] if len(not_floating) == 1 and not mjcf.bodies[not_floating[0]].joints else None


def link_bodies_of(mjcf: Mjcf, closure_joints: Sequence[ClosureJoint], free: bool) -> list[int]:
    """Returns the numbers of the bodies that become links. The world (0) is one of them if another body is
    fixed to it or moves relative to it.

    If a single body is fixed, and its frame is the world's, that body is the base and the world is no link.
    If the base is to float (`free`), and no other body is below the world, that holds for any frame of the
    body.
    """
    world_children = _world_children(mjcf)
    all_bodies = list(range(len(mjcf.bodies)))
    base = base_of(mjcf)
    if base is not None:
        in_world_frame = bool(np.abs(mjcf.bodies[base].parent_from_body - np.eye(4)).max() < FRAME_TOLERANCE)
        return all_bodies[1:] if in_world_frame or (free and len(world_children) == 1) else all_bodies
    not_floating = any(not floats(mjcf.bodies[number]) for number in world_children)
    closed_to_world = any(0 in joint.closure.bodies for joint in closure_joints)
    return all_bodies if not_floating or closed_to_world else all_bodies[1:]


def tree_closure_joints(mjcf: Mjcf, closure_joints: Sequence[ClosureJoint]) -> list[ClosureJoint]:
    """Returns the closures that connect otherwise separate trees: each becomes a joint of the tree."""
    world_child = _world_child_above(mjcf)
    not_floating = {number for number in _world_children(mjcf) if not floats(mjcf.bodies[number])} | {0}
    tree_roots = (
        {0 if world_child[body] in not_floating else world_child[body] for body in joint.closure.bodies}
        for joint in closure_joints
    )
    return [
        joint
        for joint, roots_of_ends in zip(closure_joints, tree_roots, strict=True)
        if len(roots_of_ends) > 1
    ]


def _world_child_above(mjcf: Mjcf) -> dict[int, int]:
    """Maps each body to its ancestor directly below the world, and the world to itself."""
    world_child: dict[int, int] = {}
    for number, body in enumerate(mjcf.bodies):
        world_child[number] = world_child[body.parent] if body.parent else number
    return world_child


def root_of(mjcf: Mjcf, link_bodies: Sequence[int]) -> int:
    """Returns the root: the world if it is a link, else the base, else the floating body with the most bodies
    below it (the first of equals). `link_bodies`: the bodies that become links."""
    if link_bodies[0] == 0:
        return 0
    base = base_of(mjcf)
    if base is not None:
        return base
    ancestors = list(_world_child_above(mjcf).values())
    return min(_world_children(mjcf), key=lambda number: (-ancestors.count(number), number))
