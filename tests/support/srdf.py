"""An SRDF as readers have it: by rules of srdfdom and MoveIt, and by Pinocchio. Nothing of the product is
used."""

import math
from itertools import combinations

import numpy as np
from lxml import etree

from tests.support.pinocchio import pin

REASONS = {"Adjacent", "Always", "Default", "Never", "User"}
"""Those of MoveIt's assistant for a pair that it disables."""

ATTRIBUTES = {
    "virtual_joint": {"name", "type", "parent_frame", "child_link"},
    "group": {"name"},
    "group_state": {"name", "group"},
    "end_effector": {"name", "parent_link", "group", "parent_group"},
    "passive_joint": {"name"},
    "disable_collisions": {"link1", "link2", "reason"},
}
"""What our elements must have, all of it."""


UNREAD = "JointModelRevoluteUnboundedUnaligned"


class Srdf:
    """An SRDF beside its URDF."""

    def __init__(self, srdf, urdf):
        self.root, self.urdf = etree.fromstring(srdf), etree.fromstring(urdf)
        self.links = [link.get("name") for link in self.urdf.findall("link")]
        self.joints = {joint.get("name"): joint for joint in self.urdf.findall("joint")}
        self.above = {joint.find("child").get("link"): joint for joint in self.joints.values()}

    def chain(self, base, tip):
        """The joints from the tip up to the base; None where that is not above it."""
        names = []
        while tip != base:
            if tip not in self.above:
                return None
            names.append(self.above[tip].get("name"))
            tip = self.above[tip].find("parent").get("link")
        return names

    def moves(self, joint):
        types = ("revolute", "continuous", "prismatic")
        return joint in self.joints and self.joints[joint].get("type") in types

    @property
    def groups(self):
        """The moving joints of each group."""
        members = {}
        for group in self.root.findall("group"):
            names = [joint.get("name") for joint in group.findall("joint")]
            for chain in group.findall("chain"):
                names += self.chain(chain.get("base_link"), chain.get("tip_link")) or []
            members[group.get("name")] = {name for name in names if self.moves(name)}
        return members

    @property
    def disabled(self):
        """The reasons by pair of links."""
        every = self.root.findall("disable_collisions")
        return {(element.get("link1"), element.get("link2")): element.get("reason") for element in every}

    def states(self, group):
        """The poses of a group."""
        return {
            state.get("name"): {element.get("name"): float(element.get("value")) for element in state}
            for state in self.root.findall("group_state")
            if state.get("group") == group
        }

    def problems(self):
        """What MoveIt would not take, or would report."""
        return [*self._elements(), *self._groups(), *self._states(), *self._others(), *self._pairs()]

    def _elements(self):
        if self.root.tag != "robot" or self.root.get("name") != self.urdf.get("name"):
            yield "the robot has another name"
        for node in self.root.iterchildren(tag=etree.Element):
            if set(node.attrib) != ATTRIBUTES.get(node.tag):
                yield f"<{node.tag}> has {sorted(node.attrib)}"
        for tag in ("group", "end_effector", "virtual_joint", "passive_joint"):
            names = [element.get("name") for element in self.root.findall(tag)]
            if len(set(names)) < len(names) or "" in names:
                yield f"names of {tag} twice: {names}"

    def _groups(self):
        for group in self.root.findall("group"):
            name = group.get("name")
            for joint in group.findall("joint"):
                if joint.get("name") not in self.joints:
                    yield f"{name}: no joint {joint.get('name')}"
                    return
            for chain in group.findall("chain"):
                ends = chain.get("base_link"), chain.get("tip_link")
                if not set(ends) <= set(self.links) or not self.chain(*ends):
                    yield f"{name}: no chain from {ends[0]} to {ends[1]}"
                    return
        yield from (f"{name} is empty" for name, joints in self.groups.items() if not joints)

    def _states(self):
        seen = set()
        for state in self.root.findall("group_state"):
            key = state.get("name"), state.get("group")
            if key in seen or key[1] not in self.groups:
                yield f"state {key} twice, or of no group"
                continue
            seen.add(key)
            names = [element.get("name") for element in state.findall("joint")]
            if sorted(names) != sorted(self.groups[key[1]]):
                yield f"state {key} is not of the joints of its group"
            for joint in state.findall("joint"):
                low, high = self.range(joint.get("name"))
                if not low - 1e-9 <= float(joint.get("value")) <= high + 1e-9:
                    yield f"state {key}: {joint.get('name')} is outside its limits"

    def range(self, joint):
        node = self.joints.get(joint)
        limit = None if node is None else node.find("limit")
        if limit is None or limit.get("lower") is None:
            return -math.inf, math.inf
        return float(limit.get("lower")), float(limit.get("upper"))

    def _others(self):
        roots = set(self.links) - set(self.above)
        for node in self.root.findall("virtual_joint"):
            if node.get("type") not in ("fixed", "floating", "planar") or node.get("name") in self.joints:
                yield "the virtual joint has a wrong type or a name that is taken"
            if {node.get("child_link")} != roots or node.get("parent_frame") in self.links:
                yield "the virtual joint does not hold the root in a frame beyond the robot"
        for node in self.root.findall("passive_joint"):
            if node.get("name") not in self.joints or self.joints[node.get("name")].get("type") == "fixed":
                yield f"no passive joint {node.get('name')}"
        for node in self.root.findall("end_effector"):
            group, arm = node.get("group"), node.get("parent_group")
            if group not in self.groups or arm not in self.groups:
                yield f"the end effector {node.get('name')} has no group"
            elif self.groups[group] & self.groups[arm]:
                yield f"the end effector {node.get('name')} shares joints with its arm"
            else:
                held = {self.joints[joint].find("child").get("link") for joint in self._all_joints(arm)}
                if node.get("parent_link") not in held:
                    yield f"{node.get('parent_link')} is not a link of {arm}"

    def _all_joints(self, group):
        (node,) = [element for element in self.root.findall("group") if element.get("name") == group]
        names = [joint.get("name") for joint in node.findall("joint")]
        for chain in node.findall("chain"):
            names += self.chain(chain.get("base_link"), chain.get("tip_link")) or []
        return names

    def _pairs(self):
        solid = {link.get("name") for link in self.urdf.findall("link") if link.find("collision") is not None}
        seen = set()
        for node in self.root.findall("disable_collisions"):
            pair = node.get("link1"), node.get("link2")
            if frozenset(pair) in seen or pair[0] == pair[1]:
                yield f"{pair} twice, or one link"
            seen.add(frozenset(pair))
            if not set(pair) <= solid:
                yield f"{pair} are not links that collide"
            if node.get("reason") not in REASONS:
                yield f"{pair}: {node.get('reason')}"


class InPinocchio:
    """A URDF and its SRDF as files, read by Pinocchio with its colliders."""

    def __init__(self, folder):
        (path,) = folder.glob("*.urdf")
        urdf, self._srdf = str(path), str(path.with_suffix(".srdf"))
        self.model = pin.buildModelFromUrdf(urdf)
        self._geometry = pin.buildGeomFromUrdf(
            self.model, urdf, pin.GeometryType.COLLISION, package_dirs=[str(folder)]
        )
        self._nodes = {joint.get("name"): joint for joint in etree.parse(urdf).getroot().findall("joint")}

    def states(self):
        """Pose → the values of its joints, except continuous joints about an axis along none of x, y and z,
        whose values Pinocchio does not read (up to 4.1 at least)."""
        pin.loadReferenceConfigurations(self.model, self._srdf)
        read = self.model.referenceConfigurations
        return {name: self._values(read[name]) for name in [pose.key() for pose in read]}

    def active(self):
        """The pairs of links that are checked once the SRDF is read."""
        self._geometry.addAllCollisionPairs()
        pin.removeCollisionPairs(self.model, self._geometry, self._srdf)
        pairs = [(pair.first, pair.second) for pair in self._geometry.collisionPairs]
        links = {frozenset((self._link(first), self._link(other))) for first, other in pairs}
        return {pair for pair in links if len(pair) == 2}

    def is_rigid(self, first, other):
        """Whether two links are on one joint of Pinocchio's tree."""
        frames = [self.model.frames[self.model.getBodyId(name)] for name in (first, other)]
        return frames[0].parentJoint == frames[1].parentJoint

    def touching(self, pairs, count, seed):
        """Those of the pairs of links that touch at some of so many random values within the limits, with
        each mimic where it follows."""
        self._geometry.removeAllCollisionPairs()
        names = []
        for first, other in combinations(range(self._geometry.ngeoms), 2):
            links = self._link(first), self._link(other)
            for pair in (links, links[::-1]):
                if pair in pairs:
                    self._geometry.addCollisionPair(pin.CollisionPair(first, other))
                    names.append(pair)
        data, held = self.model.createData(), pin.GeometryData(self._geometry)
        random, found = np.random.default_rng(seed), set()
        for _ in range(count):
            q = self._drawn(random)
            pin.computeCollisions(self.model, data, self._geometry, held, q, False)
            found |= {
                pair
                for pair, collision in zip(names, held.collisionResults, strict=True)
                if collision.isCollision()
            }
        return found

    def _link(self, geometry):
        return self.model.frames[self._geometry.geometryObjects[geometry].parentFrame].name

    def _values(self, q):
        by_key = {}
        for name, joint in zip(self.model.names, self.model.joints, strict=True):
            if joint.nv == 1 and name != "universe" and joint.shortname() != UNREAD:
                part = q[joint.idx_q : joint.idx_q + joint.nq]
                by_key[name] = float(part[0]) if joint.nq == 1 else math.atan2(part[1], part[0])
        return by_key

    def _drawn(self, random):
        values = {}
        for name, node in self._nodes.items():
            limit = node.find("limit")
            ends = (-math.pi, math.pi)
            if limit is not None and limit.get("lower") is not None:
                ends = float(limit.get("lower")), float(limit.get("upper"))
            values[name] = random.uniform(*ends)
        for name, node in self._nodes.items():
            mimic = node.find("mimic")
            if mimic is not None:
                driver = values[mimic.get("joint")]
                values[name] = float(mimic.get("multiplier", 1)) * driver + float(mimic.get("offset", 0))
        q = pin.neutral(self.model)
        for name, joint in zip(self.model.names, self.model.joints, strict=True):
            if joint.nv == 1 and name != "universe":
                value = values[name]
                part = [value] if joint.nq == 1 else [math.cos(value), math.sin(value)]
                q[joint.idx_q : joint.idx_q + joint.nq] = part
        return q
