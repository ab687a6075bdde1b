"""The groups and end effectors that the robot has from its source's SRDF, as its URDF has them."""

from collections.abc import Iterator

from linkwright.stages.export.urdf.srdf.groups import Gripper, Group, Groups
from linkwright.stages.formats.urdf.chains import UrdfChains, chains_of
from linkwright.stages.formats.written import Written


def source_groups(written: Written) -> Groups:
    """A chain stays one where its links are in the URDF."""
    robot, held = written.robot, written.as_urdf.held
    names, chains = written.urdf_names, chains_of(written.as_urdf.robot)

    def link(name: str) -> str:
        """The link of the URDF that a link or a frame of the robot is, or is part of."""
        return held[name][0] if name in held else names.frames[name]

    def groups() -> Iterator[Group]:
        for group in robot.semantics.groups:
            joints = tuple(joint for dof in group.joints for joint in names.turns.get(dof, (dof,)))
            base, tip = (link(group.base), link(group.tip)) if group.tip else ("", "")
            whole = group.tip and _moving(chains, base, tip) == joints
            yield Group(group.name, joints, base, tip) if whole else Group(group.name, joints)

    effectors = (
        Gripper(one.name, one.group, link(one.parent_link), one.parent_group)
        for one in robot.semantics.end_effectors
    )
    return Groups(tuple(groups()), tuple(effectors))


def _moving(chains: UrdfChains, base: str, tip: str) -> tuple[str, ...]:
    """The joints that move from a link to another that hangs on it."""
    return tuple(step.name for step in chains.between(base, tip) or () if step.moves)
