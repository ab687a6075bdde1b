"""Finds the groups of joints that MoveIt plans for: chains to named frames and to ends of the robot,
grippers, and all joints."""

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass

from linkwright.stages.formats.urdf.names import urdf_names
from linkwright.stages.robot.model.robot import Joint, Robot
from linkwright.stages.robot.text.names import free_name

ALL_JOINTS = "all"
"""Name of the group of all joints."""

_FINGER_PATTERN = re.compile(r"finger|thumb|jaw|claw", re.IGNORECASE)
"""Matches the names of joints and links of fingers."""

_GRIPPER_PATTERN = re.compile(r"gripper", re.IGNORECASE)
"""Matches the names of joints of grippers."""


@dataclass(frozen=True, slots=True)
class Group:
    """A group of joints."""

    name: str

    joints: tuple[str, ...]
    """The joints that move, in the order of the URDF."""

    base: str = ""
    """The first link of a chain; "" for a group that is not a chain."""

    tip: str = ""
    """The last link of a chain; "" for a group that is not a chain."""


@dataclass(frozen=True, slots=True)
class Gripper:
    """An end effector."""

    name: str

    group: str
    """The group of its joints."""

    parent_link: str
    """The link that carries the fingers."""

    arm: str
    """The group of the chain to the parent link; "" if no group moves it."""


@dataclass(frozen=True, slots=True)
class Groups:
    """The groups of a robot, chains first and the group of all joints last, and its grippers."""

    groups: tuple[Group, ...]
    grippers: tuple[Gripper, ...]


def groups_of(robot: Robot, passive: Collection[str]) -> Groups:
    """Returns the groups of a robot by the names in its URDF. `passive`: the dofs that nothing drives.

    Chains start at the root, or at the link that floats freely. They go to each named frame, and to each end
    of the robot without a frame, and have the name of the frame or link. A gripper is the part beyond an arm
    if that is clear: two fingers or more that move together, or joints named like fingers.
    """
    tree = _Tree(robot, passive)
    hands = tree.hands()
    fingers = {body for hand in hands for body in tree.below(hand)}
    used_names: set[str] = set()
    chains: list[Group] = []
    for tip, link in tree.tips(fingers, frozenset(hands)):
        joints = tree.moving[link]
        if joints:
            chains.append(Group(_group_name(tip, used_names), joints, tree.base[link], tip))
    names = {chain.tip: chain.name for chain in chains}
    grippers: list[Gripper] = []
    groups: list[Group] = []
    for hand in hands:
        gripper_name = "gripper" if len(hands) == 1 else f"{hand}_gripper"
        group = Group(_group_name(gripper_name, used_names), tree.joints_below(hand))
        groups.append(group)
        grippers.append(Gripper(group.name, group.name, tree.holder(hand), names[tree.tip_of(hand)]))
    all_joints = tuple(name for joint in robot.joints for name in tree.names[joint.name])
    if all_joints and all(len(chain.joints) < len(all_joints) for chain in chains):
        groups.append(Group(_group_name(ALL_JOINTS, used_names), all_joints))
    return Groups((*chains, *groups), tuple(grippers))


def _group_name(proposal: str, used_names: set[str]) -> str:
    """Returns a free name for a group, and adds it to `used_names`."""
    name = free_name(proposal, used_names)
    used_names.add(name)
    return name


class _Tree:
    """The rigid bodies of a robot, each named by its first link, and the joints between them.

    `names`: joint of the robot → its moving joints in the URDF, without free joints, which are in no group;
    `moving`: link → the moving joints on the chain to it; `base`: link → the first link of that chain.
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
        self._index_of_link = {link.name: index for index, link in enumerate(robot.links)}
        self._body, self.base = {root: root}, {root: root}
        self.moving: dict[str, tuple[str, ...]] = {root: ()}
        self._links: dict[str, list[str]] = {root: [root]}
        self._children: dict[str, list[Joint]] = {root: []}
        for joint in robot.joints:
            is_free = joint.type == "free"
            self.base[joint.child] = joint.child if is_free else self.base[joint.parent]
            self.moving[joint.child] = () if is_free else self.moving[joint.parent] + self.names[joint.name]
            body = self._body[joint.parent] if not joint.dofs else joint.child
            self._body[joint.child] = body
            self._links.setdefault(body, []).append(joint.child)
            self._children.setdefault(body, [])
            if joint.dofs and not is_free:
                self._children[self._body[joint.parent]].append(joint)
        self._frames: dict[str, list[tuple[str, str]]] = {body: [] for body in self._links}
        for frame in robot.frames:
            self._frames[self._body[frame.link]].append((names.frames[frame.name], frame.link))
        self._leaves = {link.name for link in robot.links} - {joint.parent for joint in robot.joints}
        self._ends = {body for body in self._links if not self._children[body]} - self._rods(robot)
        self._subtree_of = self._subtrees(robot, frozenset(passive))

    def tips(self, fingers: Collection[str], hands: Collection[str]) -> Iterator[tuple[str, str]]:
        """Yields the ends of chains: the link of the URDF, and the robot's link that carries it."""
        for body in self._links:
            yield from self._frames[body]
            is_end = body in hands or (body in self._ends and body not in fingers)
            if is_end and not self._frames[body]:
                tip = self.tip_of(body)
                yield tip, tip

    def tip_of(self, body: str) -> str:
        """Returns the last link of the first chain to a body: a frame, the only link of the body that carries
        nothing, or the link that its joint moves."""
        if self._frames[body]:
            return self._frames[body][0][0]
        leaves = [link for link in self._links[body] if link in self._leaves]
        return leaves[0] if len(leaves) == 1 else body

    def hands(self) -> list[str]:
        """Returns the bodies beyond which there are only fingers. None of them is beyond another."""
        hands: list[str] = []
        bodies_of_hands: set[str] = set()
        for body in self._links:
            if body not in bodies_of_hands and self.moving[body] and self._carries_fingers(body):
                bodies_of_hands |= {body, *self.below(body)}
                hands.append(body)
        return hands

    def holder(self, body: str) -> str:
        """Returns the link of a hand that carries the first finger."""
        return self._children[body][0].parent

    def joints_below(self, body: str) -> tuple[str, ...]:
        """Returns the moving joints beyond a body, in the order of the robot."""
        inside = {body, *self.below(body)}
        joints = [joint for inner in inside for joint in self._children[inner]]
        joints.sort(key=lambda joint: self._index_of_link[joint.child])
        return tuple(name for joint in joints for name in self.names[joint.name])

    def below(self, body: str) -> list[str]:
        """Returns the bodies beyond a body."""
        bodies: list[str] = []
        stack = [body]
        while stack:
            children = [joint.child for joint in self._children[stack.pop()]]
            bodies += children
            stack += children
        return bodies

    def _carries_fingers(self, body: str) -> bool:
        """Tells whether all parts beyond a body are fingers: by their names, or since a single dof drives
        several ends."""
        children, subtree = self._children[body], self._subtree_of[body]
        if not children:
            return False
        if subtree.has_finger_names:
            return True
        are_last = all(not self._children[joint.child] for joint in children)
        if are_last and all(_GRIPPER_PATTERN.search(joint.name) for joint in children):
            return True
        # A dof elsewhere that drives all joints makes no gripper.
        is_driven_within = subtree.driver is not None and subtree.driver in subtree.inner_driver
        return is_driven_within and sum(self._subtree_of[joint.child].has_end for joint in children) > 1

    def _subtrees(self, robot: Robot, passive: frozenset[str]) -> dict[str, "_Subtree"]:
        """Returns body → the part of the robot beyond it, from the ends of the robot to its root."""
        drivers = {relation.follower: relation.driver for relation in robot.relations}
        subtrees: dict[str, _Subtree] = {}
        for body in reversed(self._links):
            below = [subtrees[joint.child] for joint in self._children[body]]
            has_finger_names = all(part.has_finger_names for part in below)
            drivers_below = {name for part in below for name in part.drivers}
            for joint in self._children[body]:
                has_finger_names &= bool(
                    _FINGER_PATTERN.search(joint.name) or _FINGER_PATTERN.search(joint.child)
                )
                drivers_below |= {drivers.get(dof.name, dof.name) for dof in joint.dofs} - passive
            inner_driver: set[str] = set()
            if len(drivers_below) == 1:
                dofs = {dof.name for joint in self._children[body] for dof in joint.dofs}
                inner_driver = drivers_below & dofs.union(*(part.inner_driver for part in below))
            has_end = body in self._ends or any(part.has_end for part in below)
            # It only matters whether there is no driver, one, or several, so two are enough.
            first_drivers = tuple(sorted(drivers_below)[:2])
            subtrees[body] = _Subtree(has_finger_names, first_drivers, frozenset(inner_driver), has_end)
        return subtrees

    def _rods(self, robot: Robot) -> set[str]:
        """Returns the bodies that only close loops: the end of the robot that a loop joins, or the lighter of
        two ends."""
        masses: dict[str, float] = dict.fromkeys(self._links, 0.0)
        for link in robot.links:
            masses[self._body[link.name]] += link.inertial.mass
        rods: set[str] = set()
        for loop in robot.loops:
            ends = [self._body[loop.link_a], self._body[loop.link_b]]
            ends = [body for body in ends if not self._children[body]]
            if ends and (len(ends) == 1 or ends[0] != ends[1]):
                rod = ends[0] if len(ends) == 1 else min(ends, key=masses.__getitem__)
                if not self._frames[rod]:
                    rods.add(rod)
        return rods


@dataclass(frozen=True, slots=True)
class _Subtree:
    """The part of the robot beyond a body."""

    has_finger_names: bool
    """Whether all its joints, or the links below them, are named like fingers."""

    drivers: tuple[str, ...]
    """The first two dofs that drive its joints."""

    inner_driver: frozenset[str]
    """The driver, if it is single and a dof of this part; else empty."""

    has_end: bool
    """Whether the part includes an end of the robot."""

    @property
    def driver(self) -> str | None:
        """Returns the single dof that drives all joints of the part, or None."""
        return self.drivers[0] if len(self.drivers) == 1 else None
