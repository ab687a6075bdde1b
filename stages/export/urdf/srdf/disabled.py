"""The pairs of links that MoveIt does not check for collisions."""

from collections.abc import Collection
from dataclasses import dataclass, replace

from linkwright.stages.export.urdf.srdf.convex import bodies_of
from linkwright.stages.export.urdf.srdf.distant_links import apart
from linkwright.stages.formats.urdf.contacts import Reason, known_pairs
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.dynamics.fusing import members
from linkwright.stages.robot.motion.adjacency import Pair
from linkwright.stages.robot.motion.start_pose import home

MOST_LINKS = 128
"""Of a robot with more links that collide no pair is worked out: their number grows with its square, as would
the SRDF."""


@dataclass(frozen=True, slots=True)
class Disabled:
    """`pairs`: by links of the URDF, in their order. `partly`: those of them of which only some colliders do
    not collide. `worked_out`: whether all that never meet are among the pairs, as far as poses show."""

    pairs: tuple[tuple[Pair, Reason], ...]
    partly: tuple[Pair, ...]
    worked_out: bool = True


def disabled_pairs(written: Written) -> Disabled:
    """The pairs of the URDF; those that never meet are worked out where they are not known already."""
    found, partly = known_pairs(written)
    if not written.shapes.self_contact:
        return Disabled(tuple(found.items()), partly)
    known = written.srdf_form
    never: Collection[Pair] | None = _apart(written, found) if known is None else known.never
    found |= dict.fromkeys(never or (), "Never")
    place = {link.name: number for number, link in enumerate(written.robot.links)}
    pairs = sorted(found, key=lambda pair: (place[pair[0]], place[pair[1]]))
    return Disabled(tuple((pair, found[pair]) for pair in pairs), partly, never is not None)


def _apart(written: Written, known: Collection[Pair]) -> tuple[Pair, ...] | None:
    """The pairs that never meet, none of them `known`; None where too many links collide."""
    robot, described = written.robot, written.as_urdf.robot
    bodies = bodies_of(written.shapes, members(robot, written.as_urdf.held))
    if len(bodies) > MOST_LINKS:
        return None
    if {loop.name for loop in robot.loops} == set(written.urdf_form.closed):
        # The relations of the URDF alone close them, which is quicker worked out.
        described = replace(described, loops=())
    return apart(described, home(robot), bodies, known)
