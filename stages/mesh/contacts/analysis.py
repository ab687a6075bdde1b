"""Finds the pairs of links that do not collide, and the other pairs that touch at `home`.

Neighbouring links do not collide, nor do pairs that the user names, nor those colliders of two links that
touch in every pose."""

import hashlib
import importlib.metadata
from collections.abc import Collection, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import orjson

from linkwright.stages.mesh.contacts.by_source import source_excludes
from linkwright.stages.mesh.contacts.narrow import Mask, excluded_shape_pairs
from linkwright.stages.mesh.motion_digest import motion_digest
from linkwright.stages.robot import codec
from linkwright.stages.robot.contact.exclude_names import ColliderNames, excluded_colliders
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.geometry import ColliderFigures, Exclude, ExcludeReason, Shape, Touch
from linkwright.stages.robot.model.robot import Array, Configuration, Robot
from linkwright.stages.robot.motion.adjacency import Pair, adjacent_pairs
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.pose_batch import count_of, many_link_poses
from linkwright.stages.robot.motion.pose_samples import sampled_poses
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.robot.text.globs import name_list, yaml_key
from linkwright.stages.robot.text.plural import count

if TYPE_CHECKING:
    from linkwright.stages.mesh import Memo
    from linkwright.stages.mesh.contacts.colliders import Colliders
    from linkwright.stages.mesh.section import ContactSection

POSES = 128
"""Number of poses in which a pair must touch to count as touching in every pose."""


@dataclass(frozen=True, slots=True)
class Contacts:
    """The contact of the robot with itself."""

    on: bool
    """Whether links collide with each other."""
    excludes: tuple[Exclude, ...] = ()
    """Pairs of links, or of their colliders, that do not collide."""
    touching: tuple[Touch, ...] = ()
    """Other pairs that touch at `home`."""
    diagnostics: tuple[Diagnostic, ...] = ()
    by_source: bool = False
    """Whether an MJCF source decides what collides."""


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
    """Analyses the contact of the robot with itself, by its colliders among `shapes`, whose parts `figures`
    name. Reports I-ALWAYS-CONTACT and W-SELF-CONTACT.

    `chosen`: the pairs that the configuration excludes; `declared`: whether the colliders are those that an
    MJCF source declares, so that it also says which neighbours collide. The result is cached in `memo` by the
    content of the colliders and the motion of the links.
    """
    if keys.self_ == "none":
        return Contacts(False)
    colliders = [shape for shape in shapes if shape.role == "collision"]
    by_source = keys.self_ == "auto" and robot.mjcf is not None
    searches = keys.self_ == "auto" and not by_source
    source_pairs = source_excludes(robot, colliders) if by_source else []
    if source_pairs is None:
        return Contacts(False, by_source=True)
    solid = {shape.link for shape in colliders}
    disabled = [(pair.link_a, pair.link_b) for pair in robot.semantics.disabled if pair.touches and searches]
    adjacent = adjacent_pairs(robot, solid) if searches or (by_source and not declared) else ()
    whole_pairs = [_pair_of(exclude) for exclude in source_pairs if not exclude.geoms]
    reasons: dict[Pair, ExcludeReason] = {
        **dict.fromkeys((*whole_pairs, *(pair for pair in disabled if solid.issuperset(pair))), "Source"),
        **dict.fromkeys(chosen, "User"),
        **dict.fromkeys(adjacent, "Adjacent"),
    }
    partial_excludes = [
        exclude for exclude in source_pairs if exclude.geoms and _pair_of(exclude) not in reasons
    ]

    def make() -> bytes:
        return orjson.dumps(_analysed(robot, colliders, files, reasons, searches))

    key = {
        "colliders": [_key_of_shape(shape, files) for shape in colliders],
        "motion": motion_digest(robot),
        "given": sorted([*pair, reason] for pair, reason in reasons.items()),
        "search": searches,
        "poses": POSES,
        "mujoco": importlib.metadata.version("mujoco"),
    }
    analysis = orjson.loads(memo("mesh.contacts", key, make))
    depth_of = {(first, second): depth for first, second, depth in analysis["held"]}
    always = [codec.typed(Exclude, exclude) for exclude in analysis["always"]]
    touching = tuple(codec.typed(Touch, touch) for touch in analysis["free"])
    position = {link.name: index for index, link in enumerate(robot.links)}
    excludes = [*always, *partial_excludes]
    excludes += [Exclude(*pair, reason, depth_of.get(pair, 0.0)) for pair, reason in reasons.items()]
    excludes.sort(key=lambda exclude: (position[exclude.link_a], position[exclude.link_b]))
    named_excludes = [(exclude, excluded_colliders(exclude, shapes, figures)) for exclude in always]
    problems = contact_reports(named_excludes, touching if searches else (), POSES)
    return Contacts(True, tuple(excludes), touching, tuple(problems), by_source)


def _pair_of(exclude: Exclude) -> Pair:
    return exclude.link_a, exclude.link_b


def _analysed(
    robot: Robot,
    shapes: Sequence[Shape],
    files: Mapping[str, bytes],
    reasons: Mapping[Pair, ExcludeReason],
    searches: bool,
) -> dict[str, Any]:
    """Returns the contacts as plain data. `held`: the pairs with `reasons` that touch at `home`, with the
    depth [m]; `always`: the excludes of other pairs that touch at `home` and in every sampled pose;
    `other_depths`: the remaining pairs that touch at `home`. `searches`: whether `always` is searched, else
    it is empty."""
    # Late: contacts from the cache need no MuJoCo.
    from linkwright.stages.mesh.contacts.colliders import Colliders

    colliders = Colliders(shapes, files)
    start = home(robot)
    poses = link_poses(robot, start)
    for link in colliders.links:
        colliders.place(link, poses[link])
    order = [link.name for link in robot.links if link.name in colliders.links]
    depths = colliders.depths(colliders.meeting(order))
    other_depths = {pair: depth for pair, depth in depths.items() if pair not in reasons}
    always: list[Exclude] = []
    if searches:
        for pair, masked in _touching_always(robot, shapes, colliders, other_depths, start):
            geoms = () if masked.all() else tuple((int(a), int(b)) for a, b in np.argwhere(masked))
            always.append(Exclude(*pair, "Always", _deepest(other_depths[pair][masked]), geoms))
            other_depths[pair] = np.where(masked, -np.inf, other_depths[pair])
    return {
        "held": [[*pair, _deepest(depth)] for pair, depth in depths.items() if pair in reasons],
        "always": [codec.plain_data(exclude) for exclude in always],
        "free": [
            codec.plain_data(Touch(*pair, _deepest(depth)))
            for pair, depth in other_depths.items()
            if (depth >= 0).any()
        ],
    }


def _deepest(depths: Array) -> float:
    # Below a micrometre the digits differ between machines.
    return round(float(depths.max(initial=0.0)), 6)


def _touching_always(
    robot: Robot,
    shapes: Sequence[Shape],
    colliders: "Colliders",
    depths: Mapping[Pair, Array],
    start: Configuration,
) -> Iterator[tuple[Pair, Mask]]:
    """Yields the pairs that touch in every sampled pose, each with the mask of its shapes that must not
    collide; yields nothing if no pose can be sampled. `depths`: the depths at `start` of the pairs that touch
    there."""
    if not depths:
        return
    values = sampled_poses(robot, POSES, colliders.span(), start)
    poses = many_link_poses(robot, values)
    labels: dict[str, list[Hashable]] = {}
    for index, shape in enumerate(shapes):
        labels.setdefault(shape.link, []).append(("own", index) if shape.collider is None else shape.collider)
    for pair, depth in depths.items():
        touching = [depth >= 0]
        for row in range(count_of(values)):
            for link in pair:
                colliders.place(link, poses[link][row])
            touching.append(colliders.touching(pair))
            if not touching[-1].any():
                break
        else:
            if count_of(values):
                yield pair, excluded_shape_pairs(np.stack(touching), labels[pair[0]], labels[pair[1]])


def _key_of_shape(shape: Shape, files: Mapping[str, bytes]) -> list[Any]:
    """Returns a collider as plain data, without the name of its file."""
    if shape.ellipsoid is not None:
        # MuJoCo collides it, and not the mesh in its file.
        return [shape.link, shape.collider, codec.plain_data(shape.ellipsoid)]
    if shape.file is not None:
        return [shape.link, shape.collider, hashlib.sha256(files[shape.file]).hexdigest()]
    return [shape.link, shape.collider, codec.plain_data(shape.primitive)]


_WHERE = "contact"


def contact_reports(
    always: Sequence[tuple[Exclude, tuple[ColliderNames, ColliderNames] | None]],
    free: Sequence[Touch],
    poses: int,
) -> Iterator[Diagnostic]:
    """Yields I-ALWAYS-CONTACT with the pairs that touch in each of the `poses`, and the names of the
    colliders that are left out if these are not all; and W-SELF-CONTACT with the pairs that touch at `home`,
    but not in every pose. Each pair is listed with its depth at `home`."""
    if always:
        pairs = "; ".join(_described_pair(exclude) + _left_out_names(names) for exclude, names in always)
        text = f"{_pairs(len(always))} in every one of {poses} poses, so they do not collide: {pairs}"
        yield Diagnostic("I-ALWAYS-CONTACT", text, _WHERE, "contact.self=all lets them collide")
    if free:
        text = f"{_pairs(len(free))} at home, but not in every pose: {', '.join(map(_described_pair, free))}"
        lines = ", ".join(f"[{yaml_key(touch.link_a)}, {yaml_key(touch.link_b)}]" for touch in free)
        hint = (
            f"to let them pass through each other: `contact: {{exclude: [{lines}]}}`; "
            "otherwise change the pose or the shapes"
        )
        yield Diagnostic("W-SELF-CONTACT", text, _WHERE, hint)


def _pairs(number: int) -> str:
    return f"{count(number, 'pair')} of links {'touches' if number == 1 else 'touch'}"


def _described_pair(pair: Exclude | Touch) -> str:
    """Returns the names of a pair, with its depth in mm."""
    return f"{pair.link_a} and {pair.link_b} ({1e3 * pair.depth:.2f} mm deep)"


def _left_out_names(names: tuple[ColliderNames, ColliderNames] | None) -> str:
    """Returns in words the parts of a pair that do not collide; "" if it is all of them."""
    if names is None:
        return ""
    return f", but only {name_list(names[0])} against {name_list(names[1])}"
