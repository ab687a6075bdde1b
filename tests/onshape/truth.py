"""What a document knows about itself: bodies, poses, masses, dynamics, by its own means.

Nothing here reads a reply or a mate frame back: poses follow from the joints' values, and dynamics
from the geometric Jacobians of every single part.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from tests.onshape.kinematics import Path, Tree

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
    """The oracle. `q` is {joint name or key: value}; joints not named are at their saved value.

    `root`: the occurrence path that stays at its saved pose (default: what is fixed, else the
    first part). Vectors and matrices follow the order of `tree_joints`.
    """

    def __init__(self, document, cut=None):
        self.document, self.tree = document, Tree(document, cut)
        self.places, self.leaves = self.tree.places, self.tree.leaves
        self.joints, self.tree_joints = self.tree.joints, self.tree.tree_joints
        self.closings, self.relations = self.tree.closings, self.tree.relations
        self.poses, self.joint, self.values = self.tree.poses, self.tree.joint, self.tree.values
        self.bodies = self._bodies()

    @property
    def saved(self):
        """{joint name: saved value}, closing joints included."""
        poses = self.poses()
        closing = {edge.name: self.tree.value_at(edge, poses) for edge in self.closings if edge.moves}
        return {**self.values(), **closing}

    def cut_at(self, names):
        """The same document with loops cut at the mates `names` instead of where the author did."""
        return Truth(self.document, (self.saved, frozenset(names)))

    def body_of(self, path):
        """The body that an occurrence of a part belongs to."""
        return next(body for body in self.bodies if path in body.parts)

    def total_mass(self):
        """The mass [kg] of all parts."""
        return sum(self._part(path)[0] for path in self.leaves)

    def inertial(self, paths, q=None, root=None):
        """The `Inertial` of some parts together, in world axes."""
        poses = self.poses(q, root)
        pieces = [(self._part(path), poses[path]) for path in sorted(paths)]
        mass = sum(piece[0] for piece, _ in pieces)
        if mass == 0:
            return Inertial(0.0, np.zeros(3), np.zeros((3, 3)))
        coms = [pose[:3, :3] @ com + pose[:3, 3] for (_, com, _), pose in pieces]
        com = sum(piece[0] * at for (piece, _), at in zip(pieces, coms, strict=True)) / mass
        inertia = np.zeros((3, 3))
        for ((m, _, own), pose), at in zip(pieces, coms, strict=True):
            d = at - com
            inertia += pose[:3, :3] @ own @ pose[:3, :3].T + m * (d @ d * np.eye(3) - np.outer(d, d))
        return Inertial(mass, com, inertia)

    def jacobians(self, q=None, root=None):
        """{part path: (linear (3, n) of its centre of mass, angular (3, n))} in world axes."""
        poses = {(): np.eye(4), **self.poses(q, root)}
        steps = [step for _, steps in self.tree.components(root) for step in steps]
        column = {joint.name: index for index, joint in enumerate(self.tree_joints)}
        chains: dict[Path, list] = {}
        for step in steps:
            chain = chains.get(step.parent, [])
            if step.edge.moves:
                at = poses[step.edge.second] @ step.edge.second_frame
                axis = at[:3, 2] * (1.0 if step.forward else -1.0)
                chain = [*chain, (column[step.edge.name], step.edge.type, axis, at[:3, 3])]
            chains[step.child] = chain
        jacobians = {}
        for path in self.leaves:
            linear, angular = np.zeros((3, len(column))), np.zeros((3, len(column)))
            pose = poses[path]
            com = pose[:3, :3] @ self._part(path)[1] + pose[:3, 3]
            for index, kind, axis, at in chains.get(path, []):
                if kind == "REVOLUTE":
                    linear[:, index], angular[:, index] = np.cross(axis, com - at), axis
                else:
                    linear[:, index] = axis
            jacobians[path] = linear, angular
        return jacobians

    def mass_matrix(self, q=None, root=None):
        """M (n, n) with the root held: Σ Jᵀ I J over all parts; relations and loops are not applied."""
        poses, jacobians = self.poses(q, root), self.jacobians(q, root)
        total = np.zeros((len(self.tree_joints),) * 2)
        for path in self.leaves:
            mass, _, inertia = self._part(path)
            linear, angular = jacobians[path]
            R = poses[path][:3, :3]
            total += mass * linear.T @ linear + angular.T @ R @ inertia @ R.T @ angular
        return total

    def gravity_torque(self, q=None, gravity=GRAVITY, root=None):
        """∂U/∂q (n,) [N m or N]: what actuators must supply to hold still (−Σ m Jᵀ g)."""
        jacobians = self.jacobians(q, root)
        torque = np.zeros(len(self.tree_joints))
        for path in self.leaves:
            torque -= self._part(path)[0] * jacobians[path][0].T @ np.asarray(gravity, float)
        return torque

    def loop_errors(self, q=None):
        """{closing mate: (6,) rad and m by which it is not met} at `q`."""
        poses = self.poses(q)
        return {edge.name: self.tree.error(edge, poses) for edge in self.closings}

    def close(self, q=None, held=(), steps=10):
        """Values that close all loops and keep all gears, with the joints in `held` as in `q`.

        They are followed from the saved pose in `steps` steps, so that a linkage keeps its branch.
        """
        target, values = self.values(q), self.values()
        keep = {self.joint(key).name for key in held}
        free = [name for name in values if name not in keep]
        start = dict(values)
        for step in range(1, steps + 1):
            share = step / steps
            for name in values:
                moved = start[name] + share * (target[name] - start[name])
                values[name] = moved if name in keep else values[name]
            values.update(self._closed(values, free))
        return values

    def _closed(self, values, free):
        def misfit(x):
            trial = {**values, **dict(zip(free, x, strict=True))}
            poses = self.poses(trial)
            trial |= {edge.name: self.tree.value_at(edge, poses) for edge in self.closings if edge.moves}
            loops = [self.tree.error(edge, poses) for edge in self.closings]
            gears = [trial[r.follower] - r.multiplier * trial[r.driver] for r in self.relations]
            return np.concatenate([*loops, np.array(gears), 1e-9 * (x - here)])

        here = np.array([values[name] for name in free])
        found = least_squares(misfit, here, xtol=1e-15, ftol=1e-15, gtol=1e-15)
        return {name: float(x) for name, x in zip(free, found.x, strict=True)}

    def frame_on(self, occurrence, world_from_frame):
        """A world frame at the saved pose, in an occurrence's own frame (for closing mates)."""
        pose = self.poses()[occurrence.path]
        return np.linalg.solve(pose, world_from_frame)

    def check(self):
        """ValueError unless the saved pose closes all loops (1e-9) and keeps all gears (1e-9)."""
        saved = self.saved
        for name, error in self.loop_errors().items():
            if np.abs(error).max() > 1e-9:
                msg = f"{name!r} is open at the saved pose by {np.abs(error).max():.3g}"
                raise ValueError(msg)
        for relation in self.relations:
            off = saved[relation.follower] - relation.multiplier * saved[relation.driver]
            if abs(off) > 1e-9:
                msg = f"{relation.name!r} is off by {off:.3g} at the saved pose"
                raise ValueError(msg)

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
