"""Finds the pairs of links that MoveIt does not check for collisions."""

from collections.abc import Collection
from dataclasses import dataclass, replace

from linkwright.stages.export.urdf.srdf.convex import bodies_of
from linkwright.stages.export.urdf.srdf.distant_links import never_meeting
from linkwright.stages.formats.urdf.contacts import Reason, excluded_pairs
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.dynamics.fusing import members
from linkwright.stages.robot.motion.adjacency import Pair
from linkwright.stages.robot.motion.start_pose import home

MAX_LINKS = 128
"""Largest number of colliding links for which pairs that never meet are computed: the work, and the SRDF,
grow with its square."""


@dataclass(frozen=True, slots=True)
class DisabledPairs:
    """The pairs of links that MoveIt does not check."""

    pairs: tuple[tuple[Pair, Reason], ...]
    """The pairs and their reasons, in the order of the URDF's links."""

    partial_pairs: tuple[Pair, ...]
    """The pairs of which only some colliders do not collide."""

    has_distant_pairs: bool = True
    """Whether the pairs that never meet were computed, or are recorded; False if there are too many links."""


def disabled_pairs(written: Written) -> DisabledPairs:
    """Returns the pairs of links of the URDF. Those that never meet are computed, unless `written.srdf_form`
    records them."""
    reasons, partial_pairs = excluded_pairs(written)
    if not written.shapes.self_contact:
        return DisabledPairs(tuple(reasons.items()), partial_pairs)
    recorded = written.srdf_form
    distant_pairs: Collection[Pair] | None = (
        _never_meeting(written, reasons) if recorded is None else recorded.never
    )
    reasons |= dict.fromkeys(distant_pairs or (), "Never")
    order = {link.name: index for index, link in enumerate(written.robot.links)}
    pairs = sorted(reasons, key=lambda pair: (order[pair[0]], order[pair[1]]))
    return DisabledPairs(
        tuple((pair, reasons[pair]) for pair in pairs), partial_pairs, distant_pairs is not None
    )


def _never_meeting(written: Written, excluded: Collection[Pair]) -> tuple[Pair, ...] | None:
    """Returns the pairs that never meet, without those `excluded`; None if too many links collide."""
    robot, urdf_robot = written.robot, written.as_urdf.robot
    bodies = bodies_of(written.shapes, members(robot, written.as_urdf.held))
    if len(bodies) > MAX_LINKS:
        return None
    if {loop.name for loop in robot.loops} == set(written.urdf_form.closed):
        # The relations of the URDF close all loops, so poses need no search for closed loops.
        urdf_robot = replace(urdf_robot, loops=())
    return never_meeting(urdf_robot, home(robot), bodies, excluded)
