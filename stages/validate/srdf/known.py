"""An SRDF that was read, and the robot that it must be of."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from linkwright.stages.formats.urdf.chains import UrdfChains, UrdfStep, chains_of
from linkwright.stages.formats.written import Written
from linkwright.stages.formats.xml import Element
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.validate.findings import named


@dataclass(frozen=True, slots=True, eq=False)
class ReadSrdf:
    """`root`: the file's; `written`: the robot that it must be of. `chains`: those of the URDF. `links` and
    `joints`: every name that the URDF has, also of what the user's own XML adds, of which nothing else is
    known. `groups`: by name, of two with the same name the first; `moving`: the joints that groups have,
    which are all that move, but for free ones; `own`: the names of the groups that every SRDF of the robot
    has: to a frame or link, of a gripper, of all joints, and those of its source; `source_groups`: the latter
    with their joints."""

    root: Element
    written: Written
    chains: UrdfChains = field(init=False)
    links: frozenset[str] = field(init=False)
    joints: frozenset[str] = field(init=False)
    groups: dict[str, Element] = field(init=False)
    moving: frozenset[str] = field(init=False)
    own: frozenset[str] = field(init=False)
    source_groups: dict[str, frozenset[str]] = field(init=False)

    def __post_init__(self) -> None:
        chains = chains_of(self.written.as_urdf.robot)
        changes = self.written.amendments.of(f"{self.robot.name}.urdf")
        groups: dict[str, Element] = {}
        for node in self.root.findall("group"):
            groups.setdefault(node.get("name", ""), node)
        of_hands = (one.get("group", "") for one in self.root.findall("end_effector"))
        turns = self.written.urdf_names.turns
        source = {
            group.name: frozenset(name for dof in group.joints for name in turns.get(dof, (dof,)))
            for group in self.robot.semantics.groups
        }
        added = [one.partition(" ") for change in changes for one in change.adds]
        for key, value in (
            ("chains", chains),
            ("links", frozenset({*chains.links, *(name for tag, _, name in added if tag == "link")})),
            ("joints", frozenset({*chains.joints, *(name for tag, _, name in added if tag == "joint")})),
            ("groups", groups),
            ("moving", frozenset(name for name, one in chains.joints.items() if one.moves)),
            ("own", frozenset({*chains.links, *of_hands, ALL, *source})),
            ("source_groups", source),
        ):
            object.__setattr__(self, key, value)

    @property
    def robot(self) -> Robot:
        return self.written.robot

    def moved_by(self, group: str) -> frozenset[str]:
        """The joints of a group that move: those that it names, above the links that it names, of its chains
        and of the groups in it."""
        return frozenset(step.name for step in self._steps(group, frozenset()) if step.moves)

    def _steps(self, group: str, seen: frozenset[str]) -> Iterator[UrdfStep]:
        node = self.groups.get(group)
        if node is None or group in seen:
            return
        for one in node.findall("joint"):
            yield from filter(None, [self.chains.joints.get(one.get("name", ""))])
        for one in node.findall("link"):
            yield from filter(None, [self.chains.above.get(one.get("name", ""))])
        for one in node.findall("chain"):
            yield from self.chains.between(one.get("base_link", ""), one.get("tip_link", "")) or ()
        for one in node.findall("group"):
            yield from self._steps(one.get("name", ""), seen | {group})

    def is_own(self, group: str) -> bool:
        """Whether a group is one that every SRDF of the robot has: to a frame or link, of a gripper, or of
        all joints. Others are the user's."""
        return group in self.own

    def rigid(self, link: str) -> set[str]:
        """The links that no joint moves against one, and itself."""
        found = {link}
        for step in self.chains.up(link):
            if step.dof is not None:
                break
            found.add(step.parent)
        for step in self.chains.joints.values():  # parents come first, but for frames, which carry nothing
            if step.dof is None and step.parent in found:
                found.add(step.child)
        return found

    def joints_beyond(self, link: str) -> frozenset[str]:
        """The joints of groups that what is rigid with a link carries, without those beyond a free joint."""
        body, base = self.rigid(link), self.chains.base_of(link)
        return frozenset(
            name
            for name in self.moving
            if self.chains.base_of(self.chains.joints[name].child) == base
            and body & {step.parent for step in self.chains.up(self.chains.joints[name].child)}
        )

    def joints_to(self, link: str) -> frozenset[str]:
        """The joints of groups from where its chain begins to a link."""
        steps = self.chains.between(self.chains.base_of(link), link) or ()
        return frozenset(step.name for step in steps if step.moves)


ALL = "all"
"""The group of all joints."""


def state(node: Element) -> str:
    """What a finding calls a pose of a group."""
    return f"{named('group_state', node.get('name', ''))} of {named('group', node.get('group', ''))}"


def pair(node: Element) -> str:
    """What a finding calls an element that is of two links."""
    return named(str(node.tag), f'{node.get("link1", "")}" "{node.get("link2", "")}')
