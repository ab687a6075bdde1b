"""Computes a digest of everything on which the poses of a robot's links depend."""

import hashlib
from collections.abc import Sequence
from typing import Any

from linkwright.stages.robot import codec
from linkwright.stages.robot.model.robot import Dof, Robot
from linkwright.stages.robot.motion.start_pose import HOME


def motion_digest(robot: Robot) -> str:
    """Returns a digest of all on which the links' poses depend; masses, dynamics and CAD origins are left
    out."""

    def plain_dofs(group: Sequence[Dof]) -> list[Any]:
        return [[dof.name, dof.kind, dof.axis, dof.origin, dof.limits, dof.saved] for dof in group]

    motion = [
        [link.name for link in robot.links],
        robot.base.fixed,
        [
            [joint.type, joint.parent, joint.child, joint.parent_from_joint, plain_dofs(joint.dofs)]
            for joint in robot.joints
        ],
        [
            [
                loop.name,
                loop.type,
                loop.link_a,
                loop.link_b,
                loop.a_from_frame,
                loop.b_from_frame,
                plain_dofs(loop.dofs),
            ]
            for loop in robot.loops
        ],
        [
            [relation.follower, relation.driver, relation.multiplier, relation.offset]
            for relation in robot.relations
        ],
        [keyframe.given for keyframe in robot.keyframes if keyframe.name == HOME],
    ]
    return hashlib.sha256(codec.dump(motion)).hexdigest()
