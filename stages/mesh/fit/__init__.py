"""Fits primitives, and hulls of few vertices, to a part or to a convex piece of a part.

The best fit has the smallest error: the larger of its protrusion and its bareness, weighted as the tolerance
weighs them. It may stand out of the part, or leave a little of it bare. It depends neither on the order of
the vertices and triangles nor on the axes, except that directions within 0.5° of a coordinate axis become
that axis.

- balls: Approximates a part by a union of spheres.
- capped: Makes convex hulls with few vertices.
- circles: Finds the smallest ball around points, in two or three dimensions.
- directions: Finds directions along which a part may be made, and the smallest boxes around it.
- kinds: Finds the best fit of each kind of primitive.
- levels: Finds where most of a surface lies: the height of a flat face, or the radius about an axis or a
  point.
- outline: Prepares a surface and its hull for fits: distances from the surface are found by samples in a
  tree.
- refine: Improves a fit in small steps, which move single sides of a primitive in or out.
- score: Computes the error of a primitive as a collider: the smallest tolerance that it meets.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from linkwright.stages.mesh.fit import balls, capped
from linkwright.stages.mesh.fit.kinds import (
    best_fit,
    best_fit_within,
    first_of_best_fits,
    fit_with_size,
    subject_of,
)
from linkwright.stages.mesh.fit.outline import outline_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from linkwright.stages.formats.meshes.surface import Surface
    from linkwright.stages.mesh.fit.kinds import PrimitiveFit
    from linkwright.stages.robot.model.robot import Primitive, PrimitiveKind
    from linkwright.stages.targets.engines import ShapeLimits

CHEAPEST: tuple[PrimitiveKind, ...] = ("sphere", "capsule", "box", "cylinder")
"""The kinds of primitives by the cost of a contact, the cheapest first.

MuJoCo has formulas for all pairs of the first three (0.2 to 0.7 µs a pair on one processor). A cylinder has
formulas only against planes and spheres, and otherwise costs as much as a hull (2.7 to 6 µs).
"""


def allowed_kinds(limits: ShapeLimits) -> tuple[PrimitiveKind, ...]:
    """Returns the kinds of primitives that the limits allow, the cheapest first."""
    return tuple(kind for kind in CHEAPEST if kind not in limits.excluded_kinds)


def fits(
    surface: Surface, kinds: Sequence[PrimitiveKind] = CHEAPEST, max_error: float = math.inf
) -> Iterator[PrimitiveFit]:
    """Yields the best fit of each kind, in the given order, if its error is at most `max_error` [m]. A flat
    part has no fits.

    The error [m] is the smallest tolerance that the fit meets, judged by some hundred points of its surface,
    which may miss the depth of a narrow deep hole.
    """
    subject = subject_of(surface)
    if subject is not None:
        all_fits = (best_fit_within(kind, subject, max_error) for kind in kinds)
        yield from (fit for fit in all_fits if fit)


def best_primitive(surface: Surface, kinds: Sequence[PrimitiveKind] = CHEAPEST) -> Primitive | None:
    """Returns the primitive with the smallest error among these kinds; among equal errors, that of the first
    kind. None for a flat part."""
    subject = subject_of(surface)
    if subject is None:
        return None
    return first_of_best_fits([best_fit(kind, subject) for kind in kinds], subject.outline).primitive


def fit_kind(
    kind: PrimitiveKind, surface: Surface, size: Sequence[float | None] | None = None
) -> Primitive | None:
    """Returns the best fit of a kind; None for a flat part.

    `size`: lengths that the user chose, as in `Primitive.size`; None for a length that is fitted. With
    `size`, a box is aligned with x, y and z.
    """
    subject = subject_of(surface)
    if subject is None:
        return None
    return fit_with_size(kind, subject, size) if size else best_fit(kind, subject).primitive


def spheres(surface: Surface, tolerance: float, max_spheres: int = 64) -> tuple[Primitive, ...]:
    """Returns at most `max_spheres` spheres whose union neither stands out of a part nor leaves it bare by
    more than `tolerance` [m], or by as little more as possible; no spheres for a flat part."""
    outline = outline_of(surface)
    return balls.spheres(outline, surface.is_closed(), tolerance, max_spheres) if outline else ()


def capped_hull(surface: Surface, max_vertices: int = 64) -> Surface | None:
    """Returns the hull with the least error and at most `max_vertices` (≥ 4) vertices; None if it is flat."""
    return capped.capped_hull(surface, max_vertices)
