"""Primitives and hulls of few vertices that fit a part, or a convex piece of one.

A fit is best where the larger of protrusion and bareness is least, weighted as the tolerance weighs them: it
may stand out of the part, or leave a little of it bare. It depends neither on the order of the vertices and
triangles nor on the axes, but for directions within 0.5° of a coordinate axis, which become that axis.

- balls: A part as a union of spheres.
- capped: Convex hulls of few vertices.
- circles: The smallest ball around points, in two or three dimensions.
- directions: Directions that a part may be made along, and the boxes around it.
- kinds: The best fit of each kind of primitive.
- levels: Where the bulk of a surface lies that faces a way: on a flat face, or around an axis or a point.
- outline: What is fitted: a surface with its hull, prepared for questions of distance.
- refine: Small steps towards a better fit: single sides of a primitive in or out.
- score: The error of a primitive, as the tolerance of colliders sees it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

from linkwright.stages.mesh.fit import balls, capped, kinds
from linkwright.stages.mesh.fit.kinds import best_within, subject_of
from linkwright.stages.mesh.fit.outline import outline_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from linkwright.stages.formats.meshes.surface import Surface
    from linkwright.stages.mesh.fit.kinds import Fitted
    from linkwright.stages.robot.model.robot import Primitive, PrimitiveKind

Engine = Literal["mujoco", "mjx"]

CHEAPEST: dict[Engine, tuple[PrimitiveKind, ...]] = {
    "mujoco": ("sphere", "capsule", "box", "cylinder"),
    "mjx": ("sphere", "capsule", "box"),
}
"""The kinds by what a contact costs, the cheapest first.

MuJoCo has formulas for all pairs of the first three (0.2 to 0.7 µs a pair on one processor), but not for
a cylinder against what is neither a plane nor a sphere: that costs as much as a hull (2.7 to 6 µs). MJX has
no contact of cylinders with meshes.
"""


def fits(
    surface: Surface, kinds: Sequence[PrimitiveKind] = CHEAPEST["mujoco"], within: float = math.inf
) -> Iterator[Fitted]:
    """The best fit of each of the kinds, in their order, whose error is at most `within` [m]; each is made
    when it is asked for. None of what lies in a plane.

    The error [m] is the least tolerance that the fit meets, as some hundred points of its surface tell:
    of a narrow deep hole they may miss the depth.
    """
    subject = subject_of(surface)
    if subject is not None:
        found = (best_within(kind, subject, within) for kind in kinds)
        yield from (fit for fit in found if fit)


def fittest(surface: Surface, target: Engine = "mujoco") -> Primitive | None:
    """Of the best fits of all kinds the one with the least error, of equal ones the cheapest; None of what
    lies in a plane."""
    subject = kinds.subject_of(surface)
    if subject is None:
        return None
    return kinds.least([kinds.best(kind, subject) for kind in CHEAPEST[target]], subject.outline).primitive


def fit_one(
    kind: PrimitiveKind, surface: Surface, size: Sequence[float | None] | None = None
) -> Primitive | None:
    """The best fit of one kind; None of what lies in a plane.

    `size`: lengths as a `Primitive` has them, where the user says them; None among them is free. A box of
    given lengths stands along x, y and z.
    """
    subject = kinds.subject_of(surface)
    if subject is None:
        return None
    return kinds.given(kind, subject, size) if size else kinds.best(kind, subject).primitive


def spheres(surface: Surface, tolerance: float, most: int = 64) -> tuple[Primitive, ...]:
    """At most `most` spheres whose union neither stands out of a part nor leaves it bare by more than
    `tolerance` [m], or by as little more as so many can; none of what lies in a plane."""
    outline = outline_of(surface)
    return balls.spheres(outline, surface.closed(), tolerance, most) if outline else ()


def capped_hull(surface: Surface, max_vertices: int = 64) -> Surface | None:
    """The convex hull with at most `max_vertices` (≥ 4) vertices, of least error; None where it is flat."""
    return capped.capped_hull(surface, max_vertices)
