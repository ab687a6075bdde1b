"""The tree behind a document: every occurrence's pose follows from the joints' values alone."""

from dataclasses import dataclass, replace

import numpy as np

from tests.fake_onshape.copies import copied_poses, copy_edges, level_of
from tests.fake_onshape.edges import Edge, Path, Place, coupling, find_leader, weld_leaders
from tests.fake_onshape.elements import Group, Mate, Relation
from tests.fake_onshape.frames import inverse, product
from tests.fake_onshape.mates import joined, split


@dataclass(frozen=True, eq=False)
class Step:
    """One occurrence hung on another by an edge; `forward`: the edge's first entity is the child."""

    parent: Path
    child: Path
    edge: Edge
    forward: bool


class Tree:
    """Occurrences, edges and relations of a document, and its poses.

    `redundant`: the mates that say nothing new; `held`: paths of occurrences that are fixed one by one.
    `cut`: (saved values, names of mates, names or None) makes exactly the first mates the closing ones,
    and the last, if given, the redundant ones. ValueError where a loop has no mate with `closing=True`.
    """

    def __init__(self, document, cut=None):
        self.document = document
        self.places = {}
        self.edges = []
        self.redundant = []
        self.relations = []
        self.patterns = []
        self.held = []
        self._placed = {}
        self._flatten(document.root, (), "")
        self._index()
        # What is inside a copied sub-assembly must be there before the copy is; what holds a copied
        # sub-assembly must be there before what it holds inside is copied.
        for owner, pattern in sorted(self.patterns, key=lambda entry: -len(entry[0])):
            self._copy(owner, pattern, owner)
        for owner, pattern in sorted(self.patterns, key=lambda entry: len(entry[0])):
            level = level_of(self, owner, pattern)
            if level != owner:
                self._copy(owner, pattern, level)
        for path in self.held:
            self._hold(path)
        if cut is not None:
            self._cut(*cut)
        self._check_tree()
        self.saved_poses = self.poses()

    def joint(self, name_or_key):
        """The mate's edge with this name, or with this key (see `Edge.key`)."""
        return self._by_key.get(name_or_key) or self._by_name[name_or_key]

    def values(self, q=None):
        """{name of dof: value} of the whole tree: `q` over the saved ones.

        `q`: by names of dofs, or by a mate's name or key, with the mate's whole value.
        """
        values = {dof.name: dof.value for dof in self.dofs}
        for key, value in (q or {}).items():
            edge = None if key in values else self.joint(key)
            coordinates = {key: value} if edge is None else self.by_dof(edge, value)
            for name, number in coordinates.items():
                values[name] = tuple(number) if np.ndim(number) else float(number)
        return values

    @staticmethod
    def by_dof(edge, value):
        """{name of dof: value} of one edge."""
        return {dof.name: number for dof, number in zip(edge.dofs, split(edge.type, value), strict=True)}

    def poses(self, q=None, root=None):
        """{occurrence path: (4, 4) world pose} at joint values `q`.

        `root`: the occurrence that stays at its saved pose (default: the origin if something is
        fixed to it, else the first part).
        """
        poses = self.all_poses(q, root)
        poses.pop((), None)
        return poses

    def all_poses(self, q=None, root=None):
        """As `poses`, with the pose of the assembly's origin, (), among them."""
        values = self.values(q)
        poses = {}
        for head, steps in self.components(root):
            if head:
                poses[head] = self._head_pose(head, poses) if root is None else self.saved_poses[head]
            else:
                poses[head] = np.eye(4)
            for step in steps:
                edge = step.edge
                moved = edge.first_in_second(joined(edge.type, tuple(values[d.name] for d in edge.dofs)))
                poses[step.child] = product(poses[step.parent], moved if step.forward else inverse(moved))
        return poses

    def components(self, root=None):
        """[(head, steps)]: each connected part of the tree; a parent is hung before its children."""
        if root not in self._components:
            around = {path: [] for path in [(), *self.places]}
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
        find = weld_leaders(self.places, [edge for edge in self.edges if not edge.moves])
        sets = {}
        for path in [(), *self.places]:
            sets.setdefault(find(path), set()).add(path)
        return list(sets.values())

    def _flatten(self, assembly, owner, words):
        carrier = assembly.carrier
        mirrored = bool(owner) and self.places[owner].mirrored
        self.patterns += [(owner, pattern) for pattern in assembly.patterns]
        self.held += [owner + occurrence.path for occurrence in assembly.fixes]
        for instance in assembly.instances:
            if instance.suppressed:
                continue
            path, name = (*owner, instance.id), f"{words}/{instance.name}".lstrip("/")
            self.places[path] = Place(path, name, instance, mirrored != instance.mirrored)
            if instance.fixed:
                self._weld(f"{name} fixed", owner, path, (), instance.pose)
            if not instance.is_part:
                self._flatten(instance.source, path, name)
        if owner and carrier is not None:
            occurrence, pose = carrier
            self._weld(f"{words} frame", owner, owner + occurrence.path, owner, pose)
        for feature in assembly.features:
            name = f"{words}/{feature.name}".lstrip("/")
            if isinstance(feature, Mate) and not (feature.suppressed or feature.broken):
                self._mate(name, owner, feature)
            elif isinstance(feature, Group):
                (lead, lead_pose), *rest = feature.members
                for member, pose in rest:
                    ends = owner + member.path, owner + lead.path
                    self._weld(name, owner, *ends, product(inverse(lead_pose), pose), feature.id)
            elif isinstance(feature, Relation):
                self.relations.append(coupling(name, feature, words))

    def _mate(self, name, owner, mate):
        (first, first_frame), (second, second_frame) = mate.entities
        value = self.document.values.get((owner, mate.id), mate.value)
        ends = owner + first.path, owner + second.path, first_frame, second_frame
        held = mate.type, *ends, value, mate.limits, mate.closing
        self._add(Edge(name, owner, mate.id, *held), mate.redundant)

    def _weld(self, name, owner, first, second, pose, feature=""):
        """`first` stands at `pose` in `second`."""
        self._add(Edge(name, owner, feature, "FASTENED", first, second, np.eye(4), pose))

    def _add(self, edge, redundant=False):
        mirrored = (bool(path) and self.places[path].mirrored for path in (edge.first, edge.second))
        (self.redundant if redundant else self.edges).append(edge.proper(*mirrored))

    def _copy(self, owner, pattern, level):
        self._placed |= copied_poses(self, owner, pattern)
        for edge, redundant in copy_edges(self, owner, pattern, level):
            if not edge.moves and not (edge.closing or redundant):
                rigid = [held for held in self.edges if not (held.moves or held.closing)]
                find = weld_leaders(self.places, rigid)
                if find(edge.first) == find(edge.second):
                    continue  # a group's lead: its members hold together without it
            self._add(edge, redundant)
        self._index()

    def _hold(self, path):
        if not any({(), path} <= weld for weld in self.welds()):
            name = f"{self.places[path].name} fixed"
            self._weld(name, (), path, (), self.poses()[path])
            self._index()

    def _cut(self, saved, names, redundant):
        every = [*self.edges, *self.redundant]
        left = {edge.name for edge in self.redundant if redundant is None or not edge.moves}
        left |= redundant or set()
        values = {edge.name: joined(edge.type, tuple(saved[dof.name] for dof in edge.dofs)) for edge in every}
        changed = [replace(edge, closing=edge.name in names, value=values[edge.name]) for edge in every]
        self.edges = [edge for edge in changed if edge.name not in left]
        self.redundant = [edge for edge in changed if edge.name in left]
        self._index()

    def _index(self):
        self.leaves = [place.path for place in self.places.values() if place.instance.is_part]
        self.joints = [edge for edge in self.edges if edge.moves]
        self.tree_joints = [edge for edge in self.joints if not edge.closing]
        self.closings = [edge for edge in self.edges if edge.closing]
        self.dofs = [dof for joint in self.tree_joints for dof in joint.dofs]
        mates = [edge for edge in (*self.edges, *self.redundant) if edge.feature]
        self._by_name = {edge.name: edge for edge in mates}
        self._by_key = {key: edge for edge in mates for key in edge.keys}
        self._components = {}

    def _head_pose(self, head, poses):
        pose = self._placed.get(head)
        pose = self.places[head].instance.pose if pose is None else pose
        return product(poses.get(head[:-1], np.eye(4)), pose)

    def _check_tree(self):
        leader = {path: path for path in [(), *self.places]}
        for edge in (edge for edge in self.edges if not edge.closing):
            first_leader, second_leader = find_leader(leader, edge.first), find_leader(leader, edge.second)
            if first_leader == second_leader:
                msg = f"{edge.name!r} closes a loop: give it closing=True"
                raise ValueError(msg)
            leader[first_leader] = second_leader
