"""The groups of joints that MoveIt plans for: chains to named frames and to ends of the robot, grippers, and
all joints."""

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass

from linkwright.stages.formats.urdf.names import urdf_names
from linkwright.stages.robot.model.robot import Joint, Robot
from linkwright.stages.robot.text.names import free

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
    hands = tree.hands()
    fingers = {body for hand in hands for body in tree.below(hand)}
    taken: set[str] = set()
    chains: list[Group] = []
    for tip, link in tree.tips(fingers, frozenset(hands)):
        joints = tree.moving[link]
        if joints:
            chains.append(Group(_name(tip, taken), joints, tree.base[link], tip))
    names = {one.tip: one.name for one in chains}
    grippers: list[Gripper] = []
    groups: list[Group] = []
    for hand in hands:
        own = "gripper" if len(hands) == 1 else f"{hand}_gripper"
        group = Group(_name(own, taken), tree.joints_below(hand))
        groups.append(group)
        grippers.append(Gripper(group.name, group.name, tree.holder(hand), names[tree.tip_of(hand)]))
    every = tuple(name for joint in robot.joints for name in tree.names[joint.name])
    if every and all(len(one.joints) < len(every) for one in chains):
        groups.append(Group(_name(ALL, taken), every))
    return Groups((*chains, *groups), tuple(grippers))


def _name(name: str, taken: set[str]) -> str:
    found = free(name, taken)
    taken.add(found)
    return found


class _Tree:
    """The rigid bodies of a robot, each named by its first link, and the joints between them.

    `names`: by joint of the robot, those of the URDF that move, without free ones, which are in no group.
    `moving`: by link, those on the chain to it; `base`: where that begins.
    """

    def __init__(self, robot: Robot, passive: Collection[str]) -> None:
        names = urdf_names(robot)
        self.names = {
            joint.name: tuple(
                name
                for dof in joint.dofs
                if dof.kind != "free"
                for name in names.turns.get(dof.name, (dof.name,))
            )
            for joint in robot.joints
        }
        root = robot.root.name
        self._place = {link.name: number for number, link in enumerate(robot.links)}
        self._body, self.base = {root: root}, {root: root}
        self.moving: dict[str, tuple[str, ...]] = {root: ()}
        self._links: dict[str, list[str]] = {root: [root]}
        self._children: dict[str, list[Joint]] = {root: []}
        for joint in robot.joints:
            flies = joint.type == "free"
            self.base[joint.child] = joint.child if flies else self.base[joint.parent]
            self.moving[joint.child] = () if flies else self.moving[joint.parent] + self.names[joint.name]
            body = self._body[joint.parent] if not joint.dofs else joint.child
            self._body[joint.child] = body
            self._links.setdefault(body, []).append(joint.child)
            self._children.setdefault(body, [])
            if joint.dofs and not flies:
                self._children[self._body[joint.parent]].append(joint)
        self._frames: dict[str, list[tuple[str, str]]] = {body: [] for body in self._links}
        for frame in robot.frames:
            self._frames[self._body[frame.link]].append((names.frames[frame.name], frame.link))
        self._leaves = {link.name for link in robot.links} - {joint.parent for joint in robot.joints}
        self._ends = {body for body in self._links if not self._children[body]} - self._rods(robot)
        self._beyond = self._all_beyond(robot, frozenset(passive))

    def tips(self, fingers: Collection[str], hands: Collection[str]) -> Iterator[tuple[str, str]]:
        """Where chains end: the link of the URDF, and the robot's link on which that is."""
        for body in self._links:
            yield from self._frames[body]
            alone = body in hands or (body in self._ends and body not in fingers)
            if alone and not self._frames[body]:
                tip = self.tip_of(body)
                yield tip, tip

    def tip_of(self, body: str) -> str:
        """The end of the first chain to a body: a frame, the one link that carries nothing, or the one
        that moves."""
        if self._frames[body]:
            return self._frames[body][0][0]
        leaves = [link for link in self._links[body] if link in self._leaves]
        return leaves[0] if len(leaves) == 1 else body

    def hands(self) -> list[str]:
        """The bodies beyond which there are fingers and nothing else."""
        found: list[str] = []
        within: set[str] = set()
        for body in self._links:
            if body not in within and self.moving[body] and self._carries_fingers(body):
                within |= {body, *self.below(body)}
                found.append(body)
        return found

    def holder(self, body: str) -> str:
        """The link of a hand that carries the first finger."""
        return self._children[body][0].parent

    def joints_below(self, body: str) -> tuple[str, ...]:
        """The joints beyond a body that move, in the order of the robot."""
        inside = {body, *self.below(body)}
        joints = [joint for one in inside for joint in self._children[one]]
        joints.sort(key=lambda joint: self._place[joint.child])
        return tuple(name for joint in joints for name in self.names[joint.name])

    def below(self, body: str) -> list[str]:
        """The bodies beyond one."""
        found: list[str] = []
        waiting = [body]
        while waiting:
            children = [joint.child for joint in self._children[waiting.pop()]]
            found += children
            waiting += children
        return found

    def _carries_fingers(self, body: str) -> bool:
        children, beyond = self._children[body], self._beyond[body]
        if not children:
            return False
        if beyond.fingers:
            return True
        direct = all(not self._children[one.child] for one in children)
        if direct and all(_GRIPPER.search(one.name) for one in children):
            return True
        # What drives it all has to be one of them.
        own = beyond.driver is not None and beyond.driver in beyond.has
        return own and sum(self._beyond[one.child].ends for one in children) > 1

    def _all_beyond(self, robot: Robot, passive: frozenset[str]) -> dict[str, "_Beyond"]:
        drivers = {one.follower: one.driver for one in robot.relations}
        found: dict[str, _Beyond] = {}
        for body in reversed(self._links):
            below = [found[joint.child] for joint in self._children[body]]
            fingers = all(one.fingers for one in below)
            driving = {name for one in below for name in one.drivers}
            for joint in self._children[body]:
                fingers &= bool(_FINGER.search(joint.name) or _FINGER.search(joint.child))
                driving |= {drivers.get(dof.name, dof.name) for dof in joint.dofs} - passive
            has: set[str] = set()
            if len(driving) == 1:
                own = {dof.name for joint in self._children[body] for dof in joint.dofs}
                has = driving & own.union(*(one.has for one in below))
            ends = body in self._ends or any(one.ends for one in below)
            # Two are as many as matter.
            found[body] = _Beyond(fingers, tuple(sorted(driving)[:2]), frozenset(has), ends)
        return found

    def _rods(self, robot: Robot) -> set[str]:
        """The bodies that only hold others in closed loops: of two ends that a loop joins the lighter one."""
        masses: dict[str, float] = dict.fromkeys(self._links, 0.0)
        for link in robot.links:
            masses[self._body[link.name]] += link.inertial.mass
        found: set[str] = set()
        for loop in robot.loops:
            ends = [self._body[loop.link_a], self._body[loop.link_b]]
            ends = [body for body in ends if not self._children[body]]
            if ends and (len(ends) == 1 or ends[0] != ends[1]):
                one = ends[0] if len(ends) == 1 else min(ends, key=masses.__getitem__)
                if not self._frames[one]:
                    found.add(one)
        return found


@dataclass(frozen=True, slots=True)
class _Beyond:
    """What is beyond a body. `fingers`: whether all joints are called so; `drivers`: of the dofs that drive
    the joints there the first two; `has`: those of the drivers that are there themselves, as far as there is
    one driver; `ends`: whether an end of the robot is there, or the body is one."""

    fingers: bool
    drivers: tuple[str, ...]
    has: frozenset[str]
    ends: bool

    @property
    def driver(self) -> str | None:
        """The one dof that drives them all."""
        return self.drivers[0] if len(self.drivers) == 1 else None
