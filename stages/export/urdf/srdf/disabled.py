"""The pairs of links that MoveIt does not check for collisions."""

from dataclasses import dataclass, replace
from itertools import combinations

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


@dataclass(frozen=True, slots=True)
class Disabled:
    """`pairs`: by links of the URDF, in their order. `partly`: those of them of which only some colliders do
    not collide."""

    pairs: tuple[tuple[Pair, Reason], ...]
    partly: tuple[Pair, ...]


def disabled_pairs(robot: Robot, geometry: Geometry, form: UrdfForm) -> Disabled:
    """The pairs of a URDF of this form."""
    found, partly = known_pairs(robot, geometry, form)
    if not geometry.self_contact:
        return Disabled(tuple(found.items()), partly)
    written = as_written(robot, form)
    bodies = bodies_of(geometry, members(robot, holders(robot, form)))
    order = [link.name for link in robot.links if link.name in bodies]
    if {loop.name for loop in robot.loops} == set(form.closed):
        # The relations of the URDF alone close them, which is quicker worked out.
        written = replace(written, loops=())
    found |= dict.fromkeys(apart(written, home(robot), bodies, found), "Never")
    pairs = [(pair, found[pair]) for pair in combinations(order, 2) if pair in found]
    return Disabled(tuple(pairs), partly)
