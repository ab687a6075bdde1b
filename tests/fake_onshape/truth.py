"""What a document knows about itself: bodies, poses, masses, dynamics, by its own means.

Nothing here reads a reply or a mate frame back: poses follow from the joints' values, and dynamics
from the geometric Jacobians of every single part.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tests.fake_onshape.copies import copied_poses
from tests.fake_onshape.edges import Path
from tests.fake_onshape.elements import together
from tests.fake_onshape.frames import product
from tests.fake_onshape.kinematics import Tree

GRAVITY = (0.0, 0.0, -9.81)


@dataclass(frozen=True, eq=False)
class Body:
    """Parts that move as one: their paths; `fixed`: held by the world; `name`: the first part's."""

    name: str
    parts: frozenset[Path]
    fixed: bool


@dataclass(frozen=True, eq=False)
class Inertial:
    """Mass [kg], centre of mass [m] (3,) and inertia about it [kg m²] (3, 3), in world axes."""

    mass: float
    com: np.ndarray
    inertia: np.ndarray


class Truth:
    """The oracle. `q` is {name of a dof: value}, or by a mate's name or key its whole value; what is not
    named is at its saved value.

    A mate's only dof has the mate's name, others have suffixes (`mates`). A ball's value is a quaternion
    (w, x, y, z); its three columns of a Jacobian are the angular velocity of the body that it moves,
    relative to the other one, along the axes of the moved body's own mate frame.

    `root`: the occurrence path that stays at its saved pose (default: what is fixed, else the
    first part). Vectors and matrices follow the order of `dofs`; `columns` has the slice of each.
    """

    def __init__(self, document, cut=None):
        self.document, self.tree = document, Tree(document, cut)
        self.places, self.leaves = self.tree.places, self.tree.leaves
        self.joints, self.tree_joints = self.tree.joints, self.tree.tree_joints
        self.closings, self.redundant = self.tree.closings, self.tree.redundant
        self.relations, self.dofs = self.tree.relations, self.tree.dofs
        self.poses, self.joint, self.values = self.tree.poses, self.tree.joint, self.tree.values
        ends = np.cumsum([0, *(dof.width for dof in self.dofs)]).tolist()
        self.columns = {
            dof.name: slice(low, high) for dof, (low, high) in zip(self.dofs, pairwise(ends), strict=True)
        }
        self.width = ends[-1]
        self.bodies = self._bodies()

    @property
    def saved(self):
        """{name of dof: saved value}, those of closing and redundant mates included."""
        return {**self.values(), **self._left_out(self.poses())}

    def _left_out(self, poses):
        """{name of dof: value} of the mates that the tree leaves out."""
        left_out = {}
        for edge in (*self.closings, *self.redundant):
            left_out |= self.tree.by_dof(edge, edge.value_at(poses))
        return left_out

    def indices(self, names):
        """The columns of some dofs, three for a ball."""
        return [index for name in names for index in range(*self.columns[name].indices(self.width))]

    def cut_at(self, names, redundant=None):
        """The same document with loops cut at the mates `names` instead of where the author did.

        `redundant`: names of the mates to take for the redundant ones, if not the author's.
        """
        left = None if redundant is None else frozenset(redundant)
        return Truth(self.document, (self.saved, frozenset(names), left))

    def total_mass(self):
        """The mass [kg] of all parts."""
        return sum(self._part(path)[0] for path in self.leaves)

    def inertial(self, paths, q=None, root=None):
        """The `Inertial` of some parts together, in world axes."""
        poses, pieces = self.poses(q, root), []
        for path in sorted(paths):
            mass, com, inertia = self._part(path)
            R, xyz = poses[path][:3, :3], poses[path][:3, 3]
            pieces.append((mass, R @ com + xyz, R @ inertia @ R.T))
        return Inertial(*together(pieces))

    def jacobians(self, q=None, root=None):
        """{part path: (linear (3, n) of its centre of mass, angular (3, n))} in world axes."""
        poses = self.tree.all_poses(q, root)
        steps = [step for _, steps in self.tree.components(root) for step in steps]
        chains = {}
        for step in steps:
            chains[step.child] = [*chains.get(step.parent, []), *self._twists(step, poses)]
        jacobians = {}
        for path in self.leaves:
            linear, angular = np.zeros((3, self.width)), np.zeros((3, self.width))
            pose = poses[path]
            com = pose[:3, :3] @ self._part(path)[1] + pose[:3, 3]
            for index, kind, axis, at in chains.get(path, []):
                if kind == "slide":
                    linear[:, index] = axis
                else:
                    linear[:, index], angular[:, index] = np.cross(axis, com - at), axis
            jacobians[path] = linear, angular
        return jacobians

    def _twists(self, step, poses):
        """(column, kind, axis, point) of each motion that a step's child has against its parent."""
        edge = step.edge
        first, second = poses[edge.first] @ edge.first_frame, poses[edge.second] @ edge.second_frame
        sign, moved = (1.0, first) if step.forward else (-1.0, second)
        for dof in edge.dofs:
            column = self.columns[dof.name].start
            if dof.kind == "ball":
                for k in range(3):
                    yield column + k, "turn", moved[:3, k], first[:3, 3]
            else:
                yield column, dof.kind, sign * second[:3, :3] @ dof.axis, first[:3, 3]

    def mass_matrix(self, q=None, root=None):
        """M (n, n) with the root held: Σ Jᵀ I J over all parts; relations and loops are not applied."""
        poses, jacobians = self.poses(q, root), self.jacobians(q, root)
        total = np.zeros((self.width, self.width))
        for path in self.leaves:
            mass, _, inertia = self._part(path)
            linear, angular = jacobians[path]
            R = poses[path][:3, :3]
            total += mass * linear.T @ linear + angular.T @ R @ inertia @ R.T @ angular
        return total

    def gravity_torque(self, q=None, gravity=GRAVITY, root=None):
        """∂U/∂q (n,) [N m or N]: what actuators must supply to hold still (−Σ m Jᵀ g)."""
        jacobians = self.jacobians(q, root)
        torque = np.zeros(self.width)
        for path in self.leaves:
            torque -= self._part(path)[0] * jacobians[path][0].T @ np.asarray(gravity, float)
        return torque

    def frame_on(self, occurrence, world_from_frame):
        """A world frame at the saved pose, in an occurrence's own frame (for closing mates)."""
        pose = self.poses()[occurrence.path]
        return np.linalg.solve(pose, world_from_frame)

    def check(self):
        """ValueError unless the saved pose meets all mates, keeps all relations and has each copy where
        its pattern puts it (1e-9)."""
        saved, poses = self.saved, self.poses()
        for edge in (*self.closings, *self.redundant):
            _near(edge.error(poses), f"{edge.name!r} is open")
        for relation in self.relations:
            off = saved[relation.follower] - relation.multiplier * saved[relation.driver] - relation.offset
            _near(off, f"{relation.name!r} is off")
        for owner, pattern in self.tree.patterns:
            for path, pose in copied_poses(self.tree, owner, pattern).items():
                there = product(poses[owner], pose) if owner else pose
                _near(poses[path] - there, f"the copy {self.places[path].name!r} is off")

    def _part(self, path):
        return self.places[path].instance.source.inertial()

    def _bodies(self):
        leaves = set(self.leaves)
        bodies = []
        for weld in self.tree.welds():
            parts = frozenset(weld & leaves)
            if parts:
                first = next(path for path in self.leaves if path in parts)
                bodies.append(Body(self.places[first].name, parts, () in weld))
        return bodies


def _near(off, title):
    most = float(np.abs(off).max())
    if most > 1e-9:
        msg = f"{title} at the saved pose by {most:.3g}"
        raise ValueError(msg)
