"""The tree behind a document: every occurrence's pose follows from the joints' values alone."""

from dataclasses import dataclass, replace

import numpy as np

from tests.onshape.document import Document
from tests.onshape.elements import Gear, Group, Instance, Mate
from tests.onshape.frames import inverse, motion, product, rotation_vector

Path = tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Place:
    """An occurrence: its path, its words ("Arm <1>/Hand <1>") and its last instance."""

    path: Path
    name: str
    instance: Instance


@dataclass(frozen=True, eq=False)
class Edge:
    """Two occurrences held together: first @ first_frame == second @ second_frame @ motion(q)."""

    name: str
    owner: Path
    feature: str
    type: str
    first: Path
    second: Path
    first_frame: np.ndarray
    second_frame: np.ndarray
    value: float = 0.0
    limits: tuple = (None, None)
    closing: bool = False

    @property
    def key(self):
        """(owner occurrence path, feature id)."""
        return self.owner, self.feature

    @property
    def moves(self):
        return self.type in ("REVOLUTE", "SLIDER")


@dataclass(frozen=True, eq=False)
class GearRelation:
    """`follower` = multiplier · `driver`, both names of joints."""

    name: str
    driver: str
    follower: str
    multiplier: float


@dataclass(frozen=True, eq=False)
class Step:
    """One occurrence hung on another by an edge; `forward`: the edge's first entity is the child."""

    parent: Path
    child: Path
    edge: Edge
    forward: bool


class Tree:
    """Occurrences, edges and relations of a document, and its poses.

    `cut`: (saved values, names of mates) makes exactly those mates the closing ones.
    ValueError where a loop has no mate with `closing=True`.
    """

    def __init__(self, document: Document, cut=None):
        self.document = document
        self.places: dict[Path, Place] = {}
        self.edges: list[Edge] = []
        self.relations: list[GearRelation] = []
        self._flatten(document.root, (), "")
        if cut is not None:
            saved, names = cut
            self.edges = [
                replace(edge, closing=edge.name in names, value=saved.get(edge.name, 0.0))
                for edge in self.edges
            ]
        self.leaves = [place.path for place in self.places.values() if place.instance.is_part]
        self.joints = [edge for edge in self.edges if edge.moves]
        self.tree_joints = [edge for edge in self.joints if not edge.closing]
        self.closings = [edge for edge in self.edges if edge.closing]
        self._by_name = {joint.name: joint for joint in self.joints}
        self._by_key = {joint.key: joint for joint in self.joints}
        self._components: dict[Path | None, list[tuple[Path, list[Step]]]] = {}
        self._check_tree()
        self.saved_poses = self.poses()

    def joint(self, name_or_key):
        """The joint with this name, or (owner path, feature id)."""
        return self._by_key.get(name_or_key) or self._by_name[name_or_key]

    def values(self, q=None):
        """{joint name: value} of all joints of the tree: `q` (by name or key) over the saved ones."""
        values = {joint.name: joint.value for joint in self.tree_joints}
        for key, value in (q or {}).items():
            values[self.joint(key).name] = float(value)
        return values

    def poses(self, q=None, root=None):
        """{occurrence path: (4, 4) world pose} at joint values `q`.

        `root`: the occurrence that stays at its saved pose (default: the origin if something is
        fixed to it, else the first part).
        """
        values = self.values(q)
        poses = {}
        for head, steps in self.components(root):
            if head:
                poses[head] = self._head_pose(head, poses) if root is None else self.saved_poses[head]
            else:
                poses[head] = np.eye(4)
            for step in steps:
                edge = step.edge
                turned = motion(edge.type, values.get(edge.name, 0.0))
                moved = product(edge.second_frame, turned, inverse(edge.first_frame))
                poses[step.child] = product(poses[step.parent], moved if step.forward else inverse(moved))
        poses.pop((), None)
        return poses

    def components(self, root=None):
        """[(head, steps)]: each connected part of the tree; a parent is hung before its children."""
        if root not in self._components:
            around: dict[Path, list[tuple[Path, Edge, bool]]] = {path: [] for path in [(), *self.places]}
            for edge in self.edges:
                if not edge.closing:
                    around[edge.first].append((edge.second, edge, False))
                    around[edge.second].append((edge.first, edge, True))
            order = [*([root] if root is not None else []), (), *self.leaves, *self.places]
            made, seen = [], set()
            for head in order:
                if head in seen:
                    continue
                seen.add(head)
                queue, steps = [head], []
                for path in queue:
                    for other, edge, forward in around[path]:
                        if other not in seen:
                            seen.add(other)
                            queue.append(other)
                            steps.append(Step(path, other, edge, forward))
                made.append((head, steps))
            self._components[root] = made
        return self._components[root]

    def welds(self):
        """Sets of paths (parts, sub-assemblies, () for the world) that move as one."""
        leader = {path: path for path in [(), *self.places]}

        def find(path):
            while leader[path] != path:
                path = leader[path]
            return path

        for edge in self.edges:
            if not edge.moves:
                leader[find(edge.first)] = find(edge.second)
        sets: dict[Path, set[Path]] = {}
        for path in leader:
            sets.setdefault(find(path), set()).add(path)
        return list(sets.values())

    def error(self, edge, poses):
        """How far an edge is from met: (3,) rad and (3,) m, without its own freedom."""
        there = {(): np.eye(4), **poses}
        apart = inverse(there[edge.second] @ edge.second_frame) @ there[edge.first] @ edge.first_frame
        turned, moved = rotation_vector(apart[:3, :3]), apart[:3, 3].copy()
        if edge.type == "REVOLUTE":
            turned = np.array([apart[0, 2], apart[1, 2], 0.0])
        if edge.type == "SLIDER":
            moved[2] = 0.0
        return np.concatenate([turned, moved])

    def value_at(self, edge, poses):
        """The value [rad or m] that the poses give a joint."""
        there = {(): np.eye(4), **poses}
        apart = inverse(there[edge.second] @ edge.second_frame) @ there[edge.first] @ edge.first_frame
        return float(np.arctan2(apart[1, 0], apart[0, 0]) if edge.type == "REVOLUTE" else apart[2, 3])

    def _flatten(self, assembly, owner, words):
        carrier = assembly.carrier
        if owner and carrier is not None:
            occurrence, pose = carrier
            self._weld(f"{words} frame", owner, owner + occurrence.path, owner, np.eye(4), pose)
        for instance in assembly.instances:
            if instance.suppressed:
                continue
            path, name = (*owner, instance.id), f"{words}/{instance.name}".lstrip("/")
            self.places[path] = Place(path, name, instance)
            if instance.fixed:
                self._weld(f"{name} fixed", owner, path, (), np.eye(4), instance.pose)
            if not instance.is_part:
                self._flatten(instance.source, path, name)
        for feature in assembly.features:
            name = f"{words}/{feature.name}".lstrip("/")
            if isinstance(feature, Mate) and not feature.suppressed:
                (first, first_frame), (second, second_frame) = feature.entities
                value = self.document.values.get((owner, feature.id), feature.value)
                ends = owner + first.path, owner + second.path, first_frame, second_frame
                held = feature.type, *ends, value, feature.limits, feature.closing
                self.edges.append(Edge(name, owner, feature.id, *held))
            elif isinstance(feature, Group):
                (lead, lead_pose), *others = feature.members
                for member, pose in others:
                    self._weld(
                        name,
                        owner,
                        owner + member.path,
                        owner + lead.path,
                        np.eye(4),
                        product(inverse(lead_pose), pose),
                    )
            elif isinstance(feature, Gear):
                driver, follower = (_joint_name(words, at, mate) for at, mate in feature.mates)
                sign = 1.0 if feature.reverse else -1.0
                self.relations.append(GearRelation(name, driver, follower, sign * feature.ratio))

    def _weld(self, name, owner, first, second, first_frame, second_frame):
        self.edges.append(Edge(name, owner, "", "FASTENED", first, second, first_frame, second_frame))

    def _head_pose(self, head, poses):
        return product(poses.get(head[:-1], np.eye(4)), self.places[head].instance.pose)

    def _check_tree(self):
        leader: dict[Path, Path] = {path: path for path in [(), *self.places]}

        def find(path):
            while leader[path] != path:
                path = leader[path]
            return path

        for edge in self.edges:
            if edge.closing:
                continue
            one, two = find(edge.first), find(edge.second)
            if one == two:
                msg = f"{edge.name!r} closes a loop: give it closing=True"
                raise ValueError(msg)
            leader[one] = two


def _joint_name(words, owner, mate):
    return "/".join([*([words] if words else []), *(i.name for i in owner.instances), mate.name])
