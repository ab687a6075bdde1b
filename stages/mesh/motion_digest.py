"""What decides where the links of a robot are, as a digest."""

import hashlib
from collections.abc import Sequence
from typing import Any

from linkwright.stages.robot import codec
from linkwright.stages.robot.model.robot import Dof, Robot
from linkwright.stages.robot.motion.start_pose import HOME


def motion_digest(robot: Robot) -> str:
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
        [one.given for one in robot.keyframes if one.name == HOME],
    ]
    return hashlib.sha256(codec.dump(told)).hexdigest()
