"""Which pairs of links do not collide: those next to each other, those that the user names, and those that
touch in every pose, of which only what does so is left out; and which others touch at `home`."""

import hashlib
import importlib.metadata
from collections.abc import Collection, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import orjson

from linkwright.stages.mesh.contacts.by_source import source_excludes
from linkwright.stages.mesh.contacts.colliders import Colliders
from linkwright.stages.mesh.contacts.narrow import Mask, narrowed
from linkwright.stages.mesh.motion_digest import motion_digest
from linkwright.stages.robot import codec
from linkwright.stages.robot.contact.exclude_names import Names, excluded_colliders
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.geometry import ColliderFigures, Exclude, ExcludeReason, Shape, Touch
from linkwright.stages.robot.model.robot import Array, Configuration, Robot
from linkwright.stages.robot.motion.adjacency import Pair, adjacent_pairs
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.pose_batch import count_of, many_link_poses
from linkwright.stages.robot.motion.pose_samples import sampled_poses
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.robot.text.globs import as_key, listed
from linkwright.stages.robot.text.plural import count

if TYPE_CHECKING:
    from linkwright.stages.mesh import Memo
    from linkwright.stages.mesh.contacts.colliders import Colliders
    from linkwright.stages.mesh.section import ContactSection

POSES = 128
"""In how many poses a pair must touch to count as touching in every one."""


@dataclass(frozen=True, slots=True)
class Contacts:
    """Whether the links collide with each other, the pairs that do not, and those of the others that touch
    at `home`. `by_source`: whether an MJCF source says so."""

    on: bool
    excludes: tuple[Exclude, ...] = ()
    touching: tuple[Touch, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    by_source: bool = False


def self_contacts(
    robot: Robot,
    shapes: Sequence[Shape],
    files: Mapping[str, bytes],
    keys: "ContactSection",
    memo: "Memo",
    chosen: Collection[Pair] = (),
    figures: Sequence[ColliderFigures] = (),
    declared: bool = True,
) -> Contacts:
    """The contact of the robot with itself, by its colliders among `shapes`, whose parts `figures` name.
    `chosen`: the pairs that the configuration excludes; `declared`: whether colliders are those that an MJCF
    source declares, so that it says which of those next to each other collide. Diagnostics: I-ALWAYS-CONTACT,
    W-SELF-CONTACT.

    The work is done through `memo`, by the content of the colliders and by how the links move.
    """
    if keys.self_ == "none":
        return Contacts(False)
    colliders = [shape for shape in shapes if shape.role == "collision"]
    by_source = keys.self_ == "auto" and robot.mjcf is not None
    search = keys.self_ == "auto" and not by_source
    apart = source_excludes(robot, colliders) if by_source else []
    if apart is None:
        return Contacts(False, by_source=True)
    solid = {shape.link for shape in colliders}
    disabled = [(one.link_a, one.link_b) for one in robot.semantics.disabled if one.touches and search]
    adjacent = adjacent_pairs(robot, solid) if search or (by_source and not declared) else ()
    whole = [(one.link_a, one.link_b) for one in apart if not one.geoms]
    given: dict[Pair, ExcludeReason] = {
        **dict.fromkeys((*whole, *(pair for pair in disabled if solid.issuperset(pair))), "Source"),
        **dict.fromkeys(chosen, "User"),
        **dict.fromkeys(adjacent, "Adjacent"),
    }
    some = {
        (one.link_a, one.link_b): one for one in apart if one.geoms and (one.link_a, one.link_b) not in given
    }

    def make() -> bytes:
        return orjson.dumps(_found(robot, colliders, files, given, search))

    key = {
        "colliders": [_content(shape, files) for shape in colliders],
        "motion": motion_digest(robot),
        "given": sorted([*pair, reason] for pair, reason in given.items()),
        "search": search,
        "poses": POSES,
        "mujoco": importlib.metadata.version("mujoco"),
    }
    found = orjson.loads(memo("mesh.contacts", key, make))
    held = {(one, other): depth for one, other, depth in found["held"]}
    always = [codec.typed(Exclude, one) for one in found["always"]]
    touching = tuple(codec.typed(Touch, one) for one in found["free"])
    place = {link.name: index for index, link in enumerate(robot.links)}
    excludes = [*always, *some.values()]
    excludes += [Exclude(*pair, reason, held.get(pair, 0.0)) for pair, reason in given.items()]
    excludes.sort(key=lambda one: (place[one.link_a], place[one.link_b]))
    named = [(one, excluded_colliders(one, shapes, figures)) for one in always]
    problems = findings(named, touching if search else (), POSES)
    return Contacts(True, tuple(excludes), touching, tuple(problems), by_source)


def _found(
    robot: Robot,
    shapes: Sequence[Shape],
    files: Mapping[str, bytes],
    given: Mapping[Pair, ExcludeReason],
    search: bool,
) -> dict[str, Any]:
    """As plain data. `held`: the given pairs that touch at `home`, with the depth [m]; `always`: the excludes
    of those others that touch in every sampled pose too; `free`: the rest of what touches at `home`.
    Without a `search` nothing is excluded that is not given."""
    colliders = Colliders(shapes, files)
    start = home(robot)
    poses = link_poses(robot, start)
    for link in colliders.links:
        colliders.place(link, poses[link])
    order = [link.name for link in robot.links if link.name in colliders.links]
    depths = colliders.depths(colliders.meeting(order))
    free = {pair: found for pair, found in depths.items() if pair not in given}
    always: list[Exclude] = []
    if search:
        for pair, masked in _always(robot, shapes, colliders, free, start):
            geoms = () if masked.all() else tuple((int(a), int(b)) for a, b in np.argwhere(masked))
            always.append(Exclude(*pair, "Always", _deepest(free[pair][masked]), geoms))
            free[pair] = np.where(masked, -np.inf, free[pair])
    return {
        "held": [[*pair, _deepest(found)] for pair, found in depths.items() if pair in given],
        "always": [codec.plain(one) for one in always],
        "free": [
            codec.plain(Touch(*pair, _deepest(found))) for pair, found in free.items() if (found >= 0).any()
        ],
    }


def _deepest(depths: Array) -> float:
    # Below a micrometre the digits differ between machines.
    return round(float(depths.max(initial=0.0)), 6)


def _always(
    robot: Robot,
    shapes: Sequence[Shape],
    colliders: "Colliders",
    depths: Mapping[Pair, Array],
    start: Configuration,
) -> Iterator[tuple[Pair, Mask]]:
    """Of those pairs that touch in every sampled pose, which shapes do not collide; none without such a pose.
    `depths`: of the pairs that touch at `start`, there."""
    if not depths:
        return
    values = sampled_poses(robot, POSES, colliders.span(), start)
    poses = many_link_poses(robot, values)
    labels: dict[str, list[Hashable]] = {}
    for index, shape in enumerate(shapes):
        labels.setdefault(shape.link, []).append(("own", index) if shape.collider is None else shape.collider)
    for pair, found in depths.items():
        touching = [found >= 0]
        for row in range(count_of(values)):
            for link in pair:
                colliders.place(link, poses[link][row])
            touching.append(colliders.touching(pair))
            if not touching[-1].any():
                break
        else:
            if count_of(values):
                yield pair, narrowed(np.stack(touching), labels[pair[0]], labels[pair[1]])


def _content(shape: Shape, files: Mapping[str, bytes]) -> list[Any]:
    """A collider as plain data, whatever its file is called."""
    if shape.file is not None:
        return [shape.link, shape.collider, hashlib.sha256(files[shape.file]).hexdigest()]
    return [shape.link, shape.collider, codec.plain(shape.primitive)]


_WHERE = "contact"


def findings(
    always: Sequence[tuple[Exclude, tuple[Names, Names] | None]], free: Sequence[Touch], poses: int
) -> Iterator[Diagnostic]:
    """I-ALWAYS-CONTACT with the pairs that touch in every one of so many poses, and the names of what does
    not collide where that is not all of them; and W-SELF-CONTACT with those that touch at `home`, but not in
    every pose. Each has its depth there."""
    if always:
        told = "; ".join(_pair(one) + _only(names) for one, names in always)
        text = f"{_pairs(len(always))} in every one of {poses} poses, so they do not collide: {told}"
        yield Diagnostic("I-ALWAYS-CONTACT", text, _WHERE, "contact.self=all lets them collide")
    if free:
        text = f"{_pairs(len(free))} at home, but not in every pose: {', '.join(map(_pair, free))}"
        lines = ", ".join(f"[{as_key(one.link_a)}, {as_key(one.link_b)}]" for one in free)
        hint = (
            f"to let them pass through each other: `contact: {{exclude: [{lines}]}}`; "
            "otherwise change the pose or the shapes"
        )
        yield Diagnostic("W-SELF-CONTACT", text, _WHERE, hint)


def _pairs(number: int) -> str:
    return f"{count(number, 'pair')} of links {'touches' if number == 1 else 'touch'}"


def _pair(one: Exclude | Touch) -> str:
    """The pair with its depth in mm."""
    return f"{one.link_a} and {one.link_b} ({1e3 * one.depth:.2f} mm deep)"


def _only(names: tuple[Names, Names] | None) -> str:
    """What of the pair does not collide."""
    if names is None:
        return ""
    return f", of which only {listed(names[0])} against {listed(names[1])}"
