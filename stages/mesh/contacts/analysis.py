"""Which pairs of links do not collide: those next to each other, those that touch in every pose, and those
that the user names; and which others touch at `home`."""

import hashlib
import importlib.metadata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, Any

import orjson

from stages.mesh.contacts.chosen import chosen_pairs
from stages.mesh.contacts.findings import findings
from stages.robot import codec
from stages.robot.adjacency import Pair, adjacent_pairs
from stages.robot.errors import Diagnostic
from stages.robot.geometry import Exclude, ExcludeReason, Shape
from stages.robot.model import Configuration, Dof, Robot

if TYPE_CHECKING:
    from stages.mesh import Memo
    from stages.mesh.contacts.colliders import Colliders
    from stages.mesh.keys import ContactKeys

POSES = 128
"""In how many poses a pair must touch to count as touching in every one."""


@dataclass(frozen=True, slots=True)
class Contacts:
    """Whether the links collide with each other, the pairs that do not, and what was found about others."""

    on: bool
    excludes: tuple[Exclude, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()


def self_contacts(
    robot: Robot, shapes: Sequence[Shape], files: Mapping[str, bytes], keys: "ContactKeys", memo: "Memo"
) -> Contacts:
    """The contact of the robot with itself, by its colliders among `shapes`. MeshError where a glob of
    `contact.exclude` matches no link. Diagnostics: I-ALWAYS-CONTACT, W-SELF-CONTACT.

    The work is done through `memo`, by the content of the colliders and by how the links move.
    """
    chosen = chosen_pairs([link.name for link in robot.links], keys.exclude)
    if keys.self_ == "none":
        return Contacts(False)
    colliders = [shape for shape in shapes if shape.role == "collision"]
    adjacent: tuple[Pair, ...] = ()
    if keys.self_ == "auto":
        adjacent = adjacent_pairs(robot, {shape.link for shape in colliders})
    given: dict[Pair, ExcludeReason] = {
        **dict.fromkeys(chosen, "User"),
        **dict.fromkeys(adjacent, "Adjacent"),
    }
    search = keys.self_ == "auto"

    def make() -> bytes:
        return orjson.dumps(_depths(robot, colliders, files, given, search))

    key = {
        "colliders": [_content(shape, files) for shape in colliders],
        "motion": _motion(robot),
        "given": sorted([*pair, reason] for pair, reason in given.items()),
        "search": search,
        "poses": POSES,
        "mujoco": importlib.metadata.version("mujoco"),
    }
    found = orjson.loads(memo("mesh.contacts", key, make))
    depths = {(one, other): depth for one, other, depth in found["home"]}
    always = {(one, other) for one, other in found["always"]}
    reasons: dict[Pair, ExcludeReason] = {**dict.fromkeys(always, "Always"), **given}
    place = {link.name: index for index, link in enumerate(robot.links)}
    excludes = [
        Exclude(*pair, reason, depths.get(pair, 0.0))
        for pair, reason in sorted(reasons.items(), key=lambda item: [place[link] for link in item[0]])
    ]
    free = {pair: depth for pair, depth in depths.items() if pair not in reasons}
    problems = findings({pair: depths[pair] for pair in depths if pair in always}, free, POSES)
    return Contacts(True, tuple(excludes), tuple(problems))


def _depths(
    robot: Robot,
    shapes: Sequence[Shape],
    files: Mapping[str, bytes],
    given: Mapping[Pair, ExcludeReason],
    search: bool,
) -> dict[str, Any]:
    """`home`: the pairs that touch there, with the depth [m]; `always`: those of them that are not given and
    touch in every sampled pose too. Without a `search`, of the given ones alone."""
    from stages.mesh.contacts.colliders import Colliders
    from stages.robot.kinematics import link_poses
    from stages.robot.start_pose import home

    colliders = Colliders(shapes, files)
    start = home(robot)
    poses = link_poses(robot, start)
    for link in colliders.links:
        colliders.place(link, poses[link])
    order = [link.name for link in robot.links if link.name in colliders.links]
    pairs = [pair for pair in combinations(order, 2) if search or pair in given]
    depths = colliders.depths(pairs)
    always = _always(robot, colliders, [pair for pair in depths if pair not in given], start)
    # Below a micrometre the digits differ between machines.
    return {"home": [[*pair, round(depth, 6)] for pair, depth in depths.items()], "always": always}


def _always(robot: Robot, colliders: "Colliders", pairs: Sequence[Pair], start: Configuration) -> list[Pair]:
    """The pairs that touch in every sampled pose; none without such a pose."""
    if not pairs:
        return []
    from stages.robot.pose_batch import count_of, many_link_poses
    from stages.robot.pose_samples import sampled_poses

    values = sampled_poses(robot, POSES, colliders.span(), start)
    poses = many_link_poses(robot, values)

    def touch(pair: Pair, row: int) -> bool:
        for link in pair:
            colliders.place(link, poses[link][row])
        return colliders.touch(pair)

    rows = range(count_of(values))
    return [pair for pair in pairs if rows and all(touch(pair, row) for row in rows)]


def _content(shape: Shape, files: Mapping[str, bytes]) -> list[Any]:
    """A collider as plain data, whatever its file is called."""
    if shape.file is not None:
        return [shape.link, hashlib.sha256(files[shape.file]).hexdigest()]
    return [shape.link, codec.plain(shape.primitive)]


def _motion(robot: Robot) -> str:
    """A digest of all that decides where links are: not of masses, dynamics or the origins in CAD."""

    def dofs(every: Sequence[Dof]) -> list[Any]:
        return [[dof.name, dof.kind, dof.axis, dof.origin, dof.limits, dof.saved] for dof in every]

    told = [
        [link.name for link in robot.links],
        robot.base.fixed,
        [[one.type, one.parent, one.child, one.parent_from_joint, dofs(one.dofs)] for one in robot.joints],
        [
            [one.name, one.type, one.link_a, one.link_b, one.a_from_frame, one.b_from_frame, dofs(one.dofs)]
            for one in robot.loops
        ],
        [[one.follower, one.driver, one.multiplier, one.offset] for one in robot.relations],
    ]
    return hashlib.sha256(codec.dump(told)).hexdigest()
