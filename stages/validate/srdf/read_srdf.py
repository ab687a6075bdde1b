"""Reads an SRDF, and finds its groups and joints in the robot that it describes."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from linkwright.stages.formats.urdf.chains import UrdfChains, UrdfStep, chains_of
from linkwright.stages.formats.written import Written
from linkwright.stages.formats.xml import Element
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.validate.findings import named


@dataclass(frozen=True, slots=True, eq=False)
class ReadSrdf:
    """An SRDF, and the robot that it describes."""

    root: Element
    """The root of the file."""

    written: Written
    """The robot."""

    chains: UrdfChains = field(init=False)
    """The chains of the URDF."""

    links: frozenset[str] = field(init=False)
    """All links of the URDF, also those that the user's own XML adds, about which nothing else is known."""

    joints: frozenset[str] = field(init=False)
    """All joints of the URDF, also those that the user's own XML adds."""

    groups: dict[str, Element] = field(init=False)
    """Name → group; of groups with the same name, the first."""

    moving_joints: frozenset[str] = field(init=False)
    """The joints that groups may have: all moving joints except free joints."""

    robot_groups: frozenset[str] = field(init=False)
    """The names of the groups that are made from the robot: those to a frame or link, of an end effector, of
    all joints, and of the source. Other groups are the user's."""

    source_groups: dict[str, frozenset[str]] = field(init=False)
    """The groups of the source, with their joints."""

    def __post_init__(self) -> None:
        chains = chains_of(self.written.as_urdf.robot)
        changes = self.written.amendments.changes_of(f"{self.robot.name}.urdf")
        groups: dict[str, Element] = {}
        for node in self.root.findall("group"):
            groups.setdefault(node.get("name", ""), node)
        groups_of_effectors = (effector.get("group", "") for effector in self.root.findall("end_effector"))
        turns = self.written.urdf_names.turns
        source_groups = {
            group.name: frozenset(name for dof in group.joints for name in turns.get(dof, (dof,)))
            for group in self.robot.semantics.groups
        }
        # Each is a tag and a name, such as "link camera".
        added = [add.partition(" ") for change in changes for add in change.adds]
        # The dataclass is frozen, so that its fields cannot be set otherwise.
        for key, value in (
            ("chains", chains),
            ("links", frozenset({*chains.links, *(name for tag, _, name in added if tag == "link")})),
            ("joints", frozenset({*chains.joints, *(name for tag, _, name in added if tag == "joint")})),
            ("groups", groups),
            ("moving_joints", frozenset(name for name, step in chains.joints.items() if step.moves)),
            (
                "robot_groups",
                frozenset({*chains.links, *groups_of_effectors, GROUP_OF_ALL, *source_groups}),
            ),
            ("source_groups", source_groups),
        ):
            object.__setattr__(self, key, value)

    @property
    def robot(self) -> Robot:
        return self.written.robot

    def link_of(self, name: str) -> str:
        """Returns the link of the URDF that a link or a frame of the robot is, or is part of."""
        holders = self.written.as_urdf.held
        return holders[name][0] if name in holders else self.written.urdf_names.frames[name]

    def moved_by(self, group: str) -> frozenset[str]:
        """Returns the moving joints of a group: the joints that it names, the joints above the links that it
        names, and the joints of its chains and of its groups."""
        return frozenset(step.name for step in self._steps(group, set()) if step.moves)

    def _steps(self, group: str, visited_groups: set[str]) -> Iterator[UrdfStep]:
        """Yields the steps of a group's joints. Each group is visited once, since groups may be in several
        groups, and in a circle."""
        node = self.groups.get(group)
        if node is None or group in visited_groups:
            return
        visited_groups.add(group)
        for joint in node.findall("joint"):
            yield from filter(None, [self.chains.joints.get(joint.get("name", ""))])
        for link in node.findall("link"):
            yield from filter(None, [self.chains.above.get(link.get("name", ""))])
        for chain in node.findall("chain"):
            yield from self.chains.between(chain.get("base_link", ""), chain.get("tip_link", "")) or ()
        for inner in node.findall("group"):
            yield from self._steps(inner.get("name", ""), visited_groups)

    def rigid_with(self, link: str) -> set[str]:
        """Returns `link` and the links that no joint moves relative to it."""
        links = {link}
        for step in self.chains.up(link):
            if step.dof is not None:
                break
            links.add(step.parent)
        for step in self.chains.joints.values():  # parents come first, except frames, which carry nothing
            if step.dof is None and step.parent in links:
                links.add(step.child)
        return links

    def joints_beyond(self, link: str) -> frozenset[str]:
        """Returns the joints of groups that the links rigid with `link` carry, except those beyond a free
        joint."""
        rigid_links, base = self.rigid_with(link), self.chains.base_of(link)
        return frozenset(
            name
            for name in self.moving_joints
            if self.chains.base_of(self.chains.joints[name].child) == base
            and rigid_links & {step.parent for step in self.chains.up(self.chains.joints[name].child)}
        )

    def joints_to(self, link: str) -> frozenset[str]:
        """Returns the joints of groups between `link` and the root of its chain."""
        steps = self.chains.between(self.chains.base_of(link), link) or ()
        return frozenset(step.name for step in steps if step.moves)


GROUP_OF_ALL = "all"
"""Name of the group of all joints."""


def title_of_state(node: Element) -> str:
    """Returns the title of a group's pose in findings."""
    return f"{named('group_state', node.get('name', ''))} of {named('group', node.get('group', ''))}"


def title_of_pair(node: Element) -> str:
    """Returns the title, in findings, of an element with two links."""
    return named(str(node.tag), f'{node.get("link1", "")}" "{node.get("link2", "")}')
