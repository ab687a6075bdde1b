"""Joints and loops: mates as frames, axes, values and limits.

With W₀, W₁ the world frames of a mate's first and second entity, M = W₁⁻¹ W₀ is the pose of the
first relative to the second: q is its turn about, or its slide along, z. Where the first entity is
the parent the chain runs backwards, M⁻¹(q) = M(−q), so the axis is negated and q keeps its meaning.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stages.graph.assembly import Assembly, Mate
from stages.graph.bodies import Bodies
from stages.graph.naming import Names
from stages.graph.tree import Tree
from stages.robot.errors import Diagnostic
from stages.robot.model import Array, Dynamics, Joint, JointType, Limits, Loop, frozen
from stages.robot.poses import inverse

KINDS: Mapping[str, JointType] = {"REVOLUTE": "revolute", "SLIDER": "prismatic"}
LIMIT_KEYS: Mapping[JointType, tuple[str, str]] = {
    "revolute": ("limitAxialZMin", "limitAxialZMax"),
    "prismatic": ("limitZMin", "limitZMax"),
}
POSE_TOLERANCE = 1e-6
"""How far [m, rad] the saved pose may be from what a mate allows before we say so."""

Z = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """Joints in tree order, loops, and world_from_link (4, 4) of every body at the saved pose."""

    joints: tuple[Joint, ...]
    loops: tuple[Loop, ...]
    world_from_link: Mapping[int, Array]


def place(
    assembly: Assembly,
    bodies: Bodies,
    tree: Tree,
    names: Names,
    solref: tuple[float, float],
    found: list[Diagnostic],
) -> Placed:
    """Frames and values of every joint and loop. Findings go to `found`."""
    world_from_link: dict[int, Array] = {tree.root: np.eye(4)}
    joints = []
    for edge in tree.edges:
        frames = [assembly.world_from(entity) for entity in edge.mate.entities]
        first_is_child = bodies.of[edge.mate.entities[0].path] == edge.child
        child, parent = frames if first_is_child else reversed(frames)
        world_from_link[edge.child] = child
        kind = KINDS[edge.mate.ref.type]
        value, residual = measure(kind, *frames)
        _check_pose(edge.mate, residual, found)
        limits = read_limits(edge.mate, kind)
        name = names.joints[edge.mate.ref.owner, edge.mate.ref.feature]
        joints.append(
            Joint(
                name=name,
                type=kind,
                parent=names.links[edge.parent],
                child=names.links[edge.child],
                parent_from_joint=frozen(inverse(world_from_link[edge.parent]) @ parent),
                axis=frozen(Z if first_is_child else -Z),
                limits=limits,
                dynamics=Dynamics(),
                saved=value,
                mate=edge.mate.ref,
            )
        )
    loops = tuple(
        _loop(mate, assembly, bodies, tree, names, world_from_link, solref, found) for mate in tree.cut
    )
    return Placed(tuple(joints), loops, world_from_link)


def measure(kind: JointType, first: Array, second: Array) -> tuple[float, float]:
    """(q, residual) of a mate whose entities' world frames are `first` and `second` (4, 4).

    `residual` is the larger of the offset [m] and the tilt [rad] that q does not explain.
    """
    relative = inverse(second) @ first
    if kind == "prismatic":
        value = float(relative[2, 3])
        offset = math.hypot(relative[0, 3], relative[1, 3])
        tilt = float(np.linalg.norm(relative[:3, :3] - np.eye(3))) / math.sqrt(2)
    else:
        value = math.atan2(relative[1, 0], relative[0, 0])
        offset = float(np.linalg.norm(relative[:3, 3]))
        tilt = math.hypot(relative[0, 2], relative[1, 2])
    return value, max(offset, tilt)


def _check_pose(mate: Mate, residual: float, found: list[Diagnostic]) -> None:
    if residual > POSE_TOLERANCE:
        found.append(
            Diagnostic(
                "W-MATE-POSE",
                f"the saved pose breaks this {mate.ref.type} mate by {residual:.2g} (m or rad)",
                mate.title,
                "solve the assembly in Onshape: a mate there is in error",
            )
        )


def read_limits(mate: Mate, kind: JointType) -> Limits:
    """The mate's resolved limits [rad or m]; an absent side is open."""
    low, high = LIMIT_KEYS[kind]
    given = mate.limits or {}
    return Limits(given.get(low), given.get(high))


def _loop(
    mate: Mate,
    assembly: Assembly,
    bodies: Bodies,
    tree: Tree,
    names: Names,
    world_from_link: Mapping[int, Array],
    solref: tuple[float, float],
    found: list[Diagnostic],
) -> Loop:
    frames = [assembly.world_from(entity) for entity in mate.entities]
    a, b = (bodies.of[entity.path] for entity in mate.entities)
    kind = KINDS[mate.ref.type]
    value, residual = measure(kind, *frames)
    _check_pose(mate, residual, found)
    return Loop(
        name=names.joints[mate.ref.owner, mate.ref.feature],
        type=kind,
        link_a=names.links[a],
        link_b=names.links[b],
        a_from_frame=frozen(inverse(world_from_link[a]) @ frames[0]),
        b_from_frame=frozen(inverse(world_from_link[b]) @ frames[1]),
        limits=read_limits(mate, kind),
        saved=value,
        lever=_lever(frames[0][:3, 3], _cycle_origins(a, b, tree, world_from_link)),
        solref=solref,
        residual=residual,
        mate=mate.ref,
    )


def _cycle_origins(a: int, b: int, tree: Tree, world_from_link: Mapping[int, Array]) -> list[Array]:
    """Origins of the joints on the two ways from `a` and `b` up to where they meet."""
    parent = {edge.child: edge.parent for edge in tree.edges}
    ways: list[list[int]] = []
    for body in (a, b):
        way = [body]
        while way[-1] in parent:
            way.append(parent[way[-1]])
        ways.append(way)
    on_cycle = set(ways[0]) ^ set(ways[1])
    return [world_from_link[body][:3, 3] for body in sorted(on_cycle)]


def _lever(origin: Array, others: list[Array]) -> float:
    """Half the loop's reach from its closing joint: a length on the mechanism's own scale."""
    reach = max((float(np.linalg.norm(other - origin)) for other in others), default=0.0)
    return reach / 2 if reach > 1e-6 else 0.05
