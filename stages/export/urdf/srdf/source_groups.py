"""Finds the groups and end effectors of the source's SRDF in the robot's URDF."""

from collections.abc import Iterator

from linkwright.stages.export.urdf.srdf.groups import Gripper, Group, Groups
from linkwright.stages.formats.urdf.chains import UrdfChains, chains_of
from linkwright.stages.formats.written import Written


def source_groups(written: Written) -> Groups:
    """Returns the groups of the source. A chain stays a chain if its links are in the URDF."""
    robot, holders = written.robot, written.as_urdf.held
    names, chains = written.urdf_names, chains_of(written.as_urdf.robot)

    def link(name: str) -> str:
        """Returns the link of the URDF that a link or a frame of the robot is, or is part of."""
        return holders[name][0] if name in holders else names.frames[name]

    def groups() -> Iterator[Group]:
        """Yields the groups with their joints in the URDF."""
        for group in robot.semantics.groups:
            joints = tuple(joint for dof in group.joints for joint in names.turns.get(dof, (dof,)))
            base, tip = (link(group.base), link(group.tip)) if group.tip else ("", "")
            is_chain = group.tip and _moving_joints(chains, base, tip) == joints
            yield Group(group.name, joints, base, tip) if is_chain else Group(group.name, joints)

    effectors = (
        Gripper(effector.name, effector.group, link(effector.parent_link), effector.parent_group)
        for effector in robot.semantics.end_effectors
    )
    return Groups(tuple(groups()), tuple(effectors))


def _moving_joints(chains: UrdfChains, base: str, tip: str) -> tuple[str, ...]:
    """Returns the joints that move between a link and another link below it; nothing if there is no chain
    between them."""
    return tuple(step.name for step in chains.between(base, tip) or () if step.moves)
