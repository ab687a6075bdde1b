"""The pairs of links that MoveIt does not check for collisions."""

from collections.abc import Collection
from dataclasses import dataclass, replace

from stages.export.urdf.srdf.apart import apart
from stages.export.urdf.srdf.convex import bodies_of
from stages.formats.urdf.as_written import as_written, holders
from stages.formats.urdf.contacts import Reason, known_pairs
from stages.formats.urdf.form import UrdfForm
from stages.robot.adjacency import Pair
from stages.robot.fusing import members
from stages.robot.geometry import Geometry
from stages.robot.model import Robot
from stages.robot.start_pose import home

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


def disabled_pairs(
    robot: Robot, geometry: Geometry, form: UrdfForm, never: Collection[Pair] | None = None
) -> Disabled:
    """The pairs of a URDF of this form. `never`: those that never meet, where that is known already."""
    found, partly = known_pairs(robot, geometry, form)
    if not geometry.self_contact:
        return Disabled(tuple(found.items()), partly)
    never = _apart(robot, geometry, form, found) if never is None else never
    found |= dict.fromkeys(never or (), "Never")
    place = {link.name: number for number, link in enumerate(robot.links)}
    pairs = sorted(found, key=lambda pair: (place[pair[0]], place[pair[1]]))
    return Disabled(tuple((pair, found[pair]) for pair in pairs), partly, never is not None)


def _apart(
    robot: Robot, geometry: Geometry, form: UrdfForm, known: Collection[Pair]
) -> tuple[Pair, ...] | None:
    """The pairs that never meet, none of them `known`; None where too many links collide."""
    written = as_written(robot, form)
    bodies = bodies_of(geometry, members(robot, holders(robot, form)))
    if len(bodies) > MOST_LINKS:
        return None
    if {loop.name for loop in robot.loops} == set(form.closed):
        # The relations of the URDF alone close them, which is quicker worked out.
        written = replace(written, loops=())
    return apart(written, home(robot), bodies, known)
