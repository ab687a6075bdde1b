"""Computes the motions that a mate allows, as a subspace of twists.

The motions of a mate are a subgroup of the rigid motions (except a PIN_SLOT's), so the common motions of
several mates between the same two bodies are a subgroup too, and its Lie algebra is the intersection of
theirs: an intersection of twists at the saved pose holds at every pose (Hervé, "Analyse structurelle des
mécanismes par groupe des déplacements", 1978).

Twists (6,) are a turn [rad] and a shift in the world: the shift of the point `centre`, divided by `size` [m].
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from linkwright.stages.graph.dofs import residual
from linkwright.stages.graph.onshape.assembly import Assembly, Mate, Path
from linkwright.stages.graph.onshape.mates.joints import dofs_of, right_handed
from linkwright.stages.robot.model.poses import inverse, motion
from linkwright.stages.robot.model.robot import Array, Dof, Value

ANGLE_TOLERANCE = 1e-7
"""Smallest angle [rad] between different directions or twists: CAD's frames are exact."""

MIN_EXTENT = 1e-3
"""Smallest `size` [m]: with `ANGLE_TOLERANCE`, points nearer than 1e-10 m count as the same."""


@dataclass(frozen=True, slots=True, eq=False)
class MateView:
    """A mate at the saved pose."""

    mate: Mate
    bodies: tuple[int, int]
    """The bodies of its first and second entity."""
    first: Array
    """World frame of the first entity (4, 4, right-handed)."""
    second: Array
    """World frame of the second entity (4, 4, right-handed)."""
    mirrored: bool
    """Whether both frames are mirrored in CAD."""
    dofs: tuple[Dof, ...]
    """Dofs from the second entity to the first; their names are only the suffixes."""

    @property
    def saved(self) -> tuple[Value, ...]:
        """The values of the dofs at the saved pose."""
        return tuple(dof.saved for dof in self.dofs)

    @property
    def residual(self) -> float:
        """The error of the dofs at the saved pose [m or rad]."""
        return residual(inverse(self.second) @ self.first, chain(self.dofs, self.saved))


def view(mate: Mate, assembly: Assembly, body_of: Mapping[Path, int]) -> MateView:
    """Returns the view of a mate of a known type."""
    first_entity, second_entity = mate.entities
    first, second, mirrored = right_handed(
        assembly.world_from(first_entity), assembly.world_from(second_entity)
    )
    dofs = dofs_of("", mate.ref.type, mate.limits or {}, inverse(second) @ first, mirrored)
    return MateView(
        mate, (body_of[first_entity.path], body_of[second_entity.path]), first, second, mirrored, dofs
    )


def chain(dofs: Sequence[Dof], values: Sequence[Value]) -> Array:
    """Returns second_from_first (4, 4) at these values of a mate's dofs."""
    pose = np.eye(4)
    for dof, value in zip(dofs, values, strict=True):
        pose = pose @ motion(dof.kind, dof.axis, value)
    return pose


def extent(views: Iterable[MateView]) -> tuple[Array, float]:
    """Returns the middle [m] (3,) of the origins of some mates, and how far [m] they reach from it."""
    origins = np.array([frame[:3, 3] for mate_view in views for frame in (mate_view.first, mate_view.second)])
    centre = origins.mean(axis=0)
    return centre, max(float(np.linalg.norm(origins - centre, axis=1).max()), MIN_EXTENT)


def twist_columns(mate_view: MateView, centre: Array, size: float) -> Array:
    """Returns the twists (6, n) of a mate's dofs, three for a ball."""
    twists = []
    for dof in mate_view.dofs:
        axis = mate_view.second[:3, :3] @ dof.axis
        if dof.kind == "slide":
            twists.append(np.concatenate([np.zeros(3), axis]))
            continue
        for turn in (axis,) if dof.kind == "turn" else np.eye(3):
            shift = np.cross(turn, centre - mate_view.first[:3, 3]) / size
            twists.append(np.concatenate([turn, shift]))
    return np.array(twists).reshape(-1, 6).T


def span(twists: Array) -> Array:
    """Returns an orthonormal basis (6, m) of the span of twists (6, n)."""
    directions, sizes, _ = np.linalg.svd(twists)
    return np.asarray(directions[:, : int((sizes > ANGLE_TOLERANCE).sum())])


def intersection(spaces: Sequence[Array]) -> Array:
    """Returns an orthonormal basis (6, m) of the intersection of subspaces, each given by a basis (6, n); a
    basis of all twists if there are no subspaces."""
    if not spaces:
        return np.eye(6)
    # A twist is in every subspace if all projections onto their complements take it to zero.
    complements = np.concatenate([np.eye(6) - space @ space.T for space in spaces])
    _, sizes, directions = np.linalg.svd(complements)
    return np.asarray(directions[int((sizes > ANGLE_TOLERANCE).sum()) :].T)


def is_within(inner: Array, outer: Array) -> bool:
    """Tells whether the subspace `inner` (6, n) is in `outer` (6, m), both as orthonormal bases."""
    remainder = inner - outer @ (outer.T @ inner)
    return bool(np.linalg.norm(remainder, axis=0).max(initial=0.0) < 10 * ANGLE_TOLERANCE)
