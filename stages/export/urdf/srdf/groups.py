"""The groups of joints that MoveIt plans for: chains to named frames and to ends of the robot, grippers, and
all joints."""

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass

from stages.formats.urdf.names import urdf_names
from stages.robot.model import Joint, Robot
from stages.robot.names import free

ALL = "all"
"""The group of all joints."""

_FINGER = re.compile(r"finger|thumb|jaw|claw", re.IGNORECASE)
_GRIPPER = re.compile(r"gripper", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Group:
    """`joints`: those that move, in the order of the URDF; `base` and `tip`: the links of a chain, "" where
    the group is none."""

    name: str
    joints: tuple[str, ...]
    base: str = ""
    tip: str = ""


@dataclass(frozen=True, slots=True)
class Gripper:
    """What is at the end of an arm. `parent_link`: the link that carries its fingers; `arm`: the group of the
    chain to that."""

    name: str
    group: str
    parent_link: str
    arm: str


@dataclass(frozen=True, slots=True)
class Groups:
    """The groups, chains first and that of all joints last, and the grippers among them."""

    groups: tuple[Group, ...]
    grippers: tuple[Gripper, ...]


def groups_of(robot: Robot, passive: Collection[str]) -> Groups:
    """The groups of a robot as its URDF has it, by the names there. `passive`: the dofs that nothing drives.

    A chain goes to each named frame, and to each end of the robot that has no frame, from the root, or from
    the link that flies on its own; it has the name of the frame or link. A gripper is what is beyond an arm,
    where that is clear: two fingers or more that move together, or joints that are called so.
    """
    tree = _Tree(robot, passive)
    hands = list(tree.hands())
    fingers = {link for hand in hands for link in tree.below(hand)}
    taken: set[str] = set()
    chains: list[Group] = []
    for tip, link in tree.tips(fingers, hands):
        joints = tree.moving(link)
        if joints:
            chains.append(Group(_name(tip, taken), joints, tree.base(link), tip))
    grippers: list[Gripper] = []
    groups: list[Group] = []
    for hand in hands:
        own = "gripper" if len(hands) == 1 else f"{hand}_gripper"
        joints = tuple(name for joint in tree.joints_below(hand) for name in tree.names[joint.name])
        group = Group(_name(own, taken), joints)
        arm = next(one for one in chains if one.tip in tree.tips_on(hand))
        groups.append(group)
        grippers.append(Gripper(group.name, group.name, tree.holder(hand), arm.name))
    every = tuple(name for joint in robot.joints for name in tree.names[joint.name])
    if every and not any(set(one.joints) == set(every) for one in chains):
        groups.append(Group(_name(ALL, taken), every))
    return Groups((*chains, *groups), tuple(grippers))


def _name(name: str, taken: set[str]) -> str:
    found = free(name, taken)
    taken.add(found)
    return found


class _Tree:
    """The rigid bodies of a robot, each named by its first link, and the joints between them.

    `names`: by joint of the robot, those of the URDF that move, without free ones, which are in no group.
    """

    def __init__(self, robot: Robot, passive: Collection[str]) -> None:
        self._robot = robot
        self._passive = frozenset(passive) & {dof.name for dof in robot.dofs}
        self._followers = {one.follower: one.driver for one in robot.relations}
        names = urdf_names(robot)
        self._frames = names.frames
        turns = names.turns
        self.names = {
            joint.name: tuple(
                name for dof in joint.dofs if dof.kind != "free" for name in turns.get(dof.name, (dof.name,))
            )
            for joint in robot.joints
        }
        self._above = {joint.child: joint for joint in robot.joints}
        self._body = {robot.root.name: robot.root.name}
        self._links: dict[str, list[str]] = {robot.root.name: [robot.root.name]}
        self._children: dict[str, list[Joint]] = {robot.root.name: []}
        for joint in robot.joints:
            body = self._body[joint.parent] if not joint.dofs else joint.child
            self._body[joint.child] = body
            self._links.setdefault(body, []).append(joint.child)
            self._children.setdefault(body, [])
            if joint.dofs and joint.type != "free":
                self._children[self._body[joint.parent]].append(joint)
        self._leaves = {link.name for link in robot.links} - {joint.parent for joint in robot.joints}
        self._ends = {body for body in self._links if not self._children[body]} - self._rods()

    def moving(self, link: str) -> tuple[str, ...]:
        """The moving joints of the chain to a link, from its base on."""
        found: list[tuple[str, ...]] = []
        while link in self._above and self._above[link].type != "free":
            found.append(self.names[self._above[link].name])
            link = self._above[link].parent
        return tuple(name for names in reversed(found) for name in names)

    def base(self, link: str) -> str:
        """Where a chain begins."""
        while link in self._above and self._above[link].type != "free":
            link = self._above[link].parent
        return link

    def tips(self, fingers: Collection[str], hands: Collection[str]) -> Iterator[tuple[str, str]]:
        """Where chains end: the link of the URDF, and the robot's link on which that is."""
        for body, links in self._links.items():
            frames = self._frames_on(links)
            yield from frames
            if not frames and (body in hands or (body in self._ends and body not in fingers)):
                tip = self._tip(body)
                yield tip, tip

    def tips_on(self, body: str) -> list[str]:
        """The ends of chains that are on a body."""
        frames = [tip for tip, _ in self._frames_on(self._links[body])]
        return frames or [self._tip(body)]

    def hands(self) -> Iterator[str]:
        """The bodies beyond which there are fingers and nothing else."""
        found: set[str] = set()
        for body in self._links:
            if body not in found and self.moving(body) and self._carries_fingers(body):
                found |= {body, *self.below(body)}
                yield body

    def holder(self, body: str) -> str:
        """The link of a hand that carries the first finger."""
        return self._children[body][0].parent

    def joints_below(self, body: str) -> list[Joint]:
        """The joints beyond a body that move, in the order of the robot."""
        inside = {body, *self.below(body)}
        return [one for one in self._robot.joints if one.dofs and one.child in inside - {body}]

    def below(self, body: str) -> list[str]:
        """The bodies beyond one."""
        found: list[str] = []
        waiting = [body]
        while waiting:
            for joint in self._children[waiting.pop()]:
                found.append(joint.child)
                waiting.append(joint.child)
        return found

    def _frames_on(self, links: Collection[str]) -> list[tuple[str, str]]:
        return [(self._frames[one.name], one.link) for one in self._robot.frames if one.link in links]

    def _tip(self, body: str) -> str:
        """The one link of a body that carries nothing, else the one that moves."""
        leaves = [link for link in self._links[body] if link in self._leaves]
        return leaves[0] if len(leaves) == 1 else body

    def _carries_fingers(self, body: str) -> bool:
        beyond = self.joints_below(body)
        if not beyond:
            return False
        if all(_FINGER.search(joint.name) or _FINGER.search(joint.child) for joint in beyond):
            return True
        if len(beyond) == len(self._children[body]) and all(_GRIPPER.search(one.name) for one in beyond):
            return True
        branches = [{one.child, *self.below(one.child)} for one in self._children[body]]
        return sum(bool(branch & self._ends) for branch in branches) > 1 and self._is_one(beyond)

    def _is_one(self, joints: Collection[Joint]) -> bool:
        """Whether the joints move together, by one of them."""
        own = {dof.name for joint in joints for dof in joint.dofs}
        drivers = {self._followers.get(name, name) for name in own} - self._passive
        return len(drivers) == 1 and drivers <= own

    def _rods(self) -> set[str]:
        """The bodies that only hold others in closed loops: of two ends that a loop joins the lighter one."""
        masses: dict[str, float] = dict.fromkeys(self._links, 0.0)
        for link in self._robot.links:
            masses[self._body[link.name]] += link.inertial.mass
        found: set[str] = set()
        for loop in self._robot.loops:
            ends = [self._body[loop.link_a], self._body[loop.link_b]]
            ends = [body for body in ends if not self._children[body]]
            if ends and (len(ends) == 1 or ends[0] != ends[1]):
                one = ends[0] if len(ends) == 1 else min(ends, key=masses.__getitem__)
                if not self._frames_on(self._links[one]):
                    found.add(one)
        return found
