"""The motions that a mate allows, as a subspace of twists.

The motions of a mate are a subgroup of the rigid motions (except a PIN_SLOT's), so the common motions of
several mates between the same two bodies are a subgroup too, and its Lie algebra is the intersection of
theirs: what holds for twists at the saved pose holds at every pose (Hervé, "Analyse structurelle des
mécanismes par groupe des déplacements", 1978).

Twists are (turn, shift) (6,) in the world: the shift of a `centre`, over a length `size` [m].
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from linkwright.stages.graph.dofs import residual
from linkwright.stages.graph.onshape.assembly import Assembly, Mate, Path
from linkwright.stages.graph.onshape.mates.joints import dofs_of, right_handed
from linkwright.stages.robot.model.poses import inverse, motion
from linkwright.stages.robot.model.robot import Array, Dof, Value

ALIKE = 1e-7
"""Directions, and twists, at a smaller angle [rad] than this are the same: CAD's frames are exact."""

SMALLEST = 1e-3
"""The least length [m] that twists are measured on: nearer than 1e-10 m is the same place."""


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A mate at the saved pose: the bodies and world frames (4, 4, right-handed) of its first and second
    entity, whether CAD has them `mirrored`, and its dofs from the second to the first, named by their
    suffixes alone."""

    mate: Mate
    bodies: tuple[int, int]
    first: Array
    second: Array
    mirrored: bool
    dofs: tuple[Dof, ...]

    @property
    def saved(self) -> tuple[Value, ...]:
        return tuple(dof.saved for dof in self.dofs)

    @property
    def residual(self) -> float:
        """The error of the dofs at the saved pose [m or rad]."""
        return residual(inverse(self.second) @ self.first, chain(self.dofs, self.saved))


def view(mate: Mate, assembly: Assembly, body_of: Mapping[Path, int]) -> View:
    """The view of a mate of a known type."""
    one, other = mate.entities
    first, second, mirrored = right_handed(assembly.world_from(one), assembly.world_from(other))
    dofs = dofs_of("", mate.ref.type, mate.limits or {}, inverse(second) @ first, mirrored)
    return View(mate, (body_of[one.path], body_of[other.path]), first, second, mirrored, dofs)


def chain(dofs: Sequence[Dof], values: Sequence[Value]) -> Array:
    """second_from_first (4, 4) at these values of a mate's dofs."""
    pose = np.eye(4)
    for dof, value in zip(dofs, values, strict=True):
        pose = pose @ motion(dof.kind, dof.axis, value)
    return pose


def extent(views: Iterable[View]) -> tuple[Array, float]:
    """The middle [m] (3,) of the origins of some mates, and how far [m] they reach from it."""
    origins = np.array([frame[:3, 3] for one in views for frame in (one.first, one.second)])
    centre = origins.mean(axis=0)
    return centre, max(float(np.linalg.norm(origins - centre, axis=1).max()), SMALLEST)


def columns(one: View, centre: Array, size: float) -> Array:
    """The twists (6, n) of the mate's dofs, three for a ball."""
    made = []
    for dof in one.dofs:
        axis = one.second[:3, :3] @ dof.axis
        if dof.kind == "slide":
            made.append(np.concatenate([np.zeros(3), axis]))
            continue
        for turn in (axis,) if dof.kind == "turn" else np.eye(3):
            shift = np.cross(turn, centre - one.first[:3, 3]) / size
            made.append(np.concatenate([turn, shift]))
    return np.array(made).reshape(-1, 6).T


def span(twists: Array) -> Array:
    """An orthonormal basis (6, m) of what twists (6, n) span."""
    directions, sizes, _ = np.linalg.svd(twists)
    return np.asarray(directions[:, : int((sizes > ALIKE).sum())])


def common(spaces: Sequence[Array]) -> Array:
    """The intersection of subspaces, each an orthonormal basis (6, n), as one; all twists if none."""
    if not spaces:
        return np.eye(6)
    barred = np.concatenate([np.eye(6) - space @ space.T for space in spaces])
    _, sizes, directions = np.linalg.svd(barred)
    return np.asarray(directions[int((sizes > ALIKE).sum()) :].T)


def within(inner: Array, outer: Array) -> bool:
    """Whether a subspace (6, n) lies in another, both as orthonormal bases."""
    outside = inner - outer @ (outer.T @ inner)
    return bool(np.linalg.norm(outside, axis=0).max(initial=0.0) < 10 * ALIKE)
