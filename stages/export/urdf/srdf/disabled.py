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
class Disabled:
    """The pairs of links that MoveIt does not check."""

    pairs: tuple[tuple[Pair, Reason], ...]
    """The pairs and their reasons, in the order of the URDF's links."""

    partly: tuple[Pair, ...]
    """The pairs of which only some colliders do not collide."""

    worked_out: bool = True
    """Whether the pairs include all that never meet, as far as sampled poses show."""


def disabled_pairs(written: Written) -> Disabled:
    """Returns the pairs of the URDF. Those that never meet are computed unless they are recorded."""
    reasons, partly = excluded_pairs(written)
    if not written.shapes.self_contact:
        return Disabled(tuple(reasons.items()), partly)
    recorded = written.srdf_form
    distant_pairs: Collection[Pair] | None = (
        _never_meeting(written, reasons) if recorded is None else recorded.never
    )
    reasons |= dict.fromkeys(distant_pairs or (), "Never")
    order = {link.name: number for number, link in enumerate(written.robot.links)}
    pairs = sorted(reasons, key=lambda pair: (order[pair[0]], order[pair[1]]))
    return Disabled(tuple((pair, reasons[pair]) for pair in pairs), partly, distant_pairs is not None)


def _never_meeting(written: Written, excluded: Collection[Pair]) -> tuple[Pair, ...] | None:
    """Returns the pairs that never meet, without those `excluded`; None if too many links collide."""
    robot, urdf_robot = written.robot, written.as_urdf.robot
    bodies = bodies_of(written.shapes, members(robot, written.as_urdf.held))
    if len(bodies) > MAX_LINKS:
        return None
    if {loop.name for loop in robot.loops} == set(written.urdf_form.closed):
        # The relations of the URDF alone close them, which is quicker worked out.
        urdf_robot = replace(urdf_robot, loops=())
    return never_meeting(urdf_robot, home(robot), bodies, excluded)
