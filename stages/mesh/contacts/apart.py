"""The pairs of links that colliders by contact need not keep apart."""

from collections.abc import Collection
from typing import TYPE_CHECKING

from linkwright.stages.mesh.contacts.by_source import excluded
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.motion.adjacency import Pair, adjacent_pairs

if TYPE_CHECKING:
    from linkwright.stages.mesh.section import ContactSection


def apart(
    robot: Robot, solid: Collection[str], keys: "ContactSection", chosen: Collection[Pair]
) -> set[Pair] | None:
    """The pairs of `solid` links that do not collide: those next to each other, those that the configuration
    (`chosen`) or the source excludes. None where no two links collide."""
    if keys.self_ == "none":
        return None
    found = {*chosen, *adjacent_pairs(robot, solid)}
    if keys.self_ == "auto":
        found |= {(one.link_a, one.link_b) for one in robot.semantics.disabled if one.touches}
        found |= {(one, other) for one, other in map(sorted, excluded(robot))}
    return found
