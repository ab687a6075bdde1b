"""Finds the best fit of each kind of primitive."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.fit import levels
from linkwright.stages.mesh.fit.circles import smallest_ball
from linkwright.stages.mesh.fit.directions import Silhouette, axes_across, frames, silhouettes
from linkwright.stages.mesh.fit.outline import Floats, Outline, outline_of
from linkwright.stages.mesh.fit.refine import max_refined_error, refined
from linkwright.stages.mesh.fit.score import error_lower_bound, primitive_error
from linkwright.stages.robot.model.poses import from_parts
from linkwright.stages.robot.model.robot import Primitive, PrimitiveKind, frozen

_EQUAL_ERROR_SHARE = 1e-3
"""Share by which an error may exceed the smallest error and still count as equal to it:
error ≤ smallest · (1 + share) + share² · size, with the size of the part [m]."""

_MAX_AXES = 3
"""Largest number of axes of cylinders and capsules: those of the smallest cylinders."""

_MAX_FINE_FITS = 3
"""Largest number of fits of a kind that are measured finely, with many sample points."""

_MAX_FINE_ERROR = 4.0
"""If the coarse error of a kind's best fit is at least this many default tolerances, the kind does not suit
the part, and only this fit is measured finely."""

_LENGTH_DECIMALS = 12
"""Decimals of sizes and positions [m], so that they do not depend on how a processor rounds."""

_MIN_CAPSULE_LENGTH = 0.02
"""Smallest length of a capsule without its caps, in radii."""


@dataclass(frozen=True, slots=True, eq=False)
class PrimitiveFit:
    """A primitive that was fitted to a part."""

    primitive: Primitive
    error: float
    """Smallest tolerance [m] that the primitive meets."""


@dataclass(frozen=True, slots=True, eq=False)
class RevolutionCircle:
    """A circle around a part, from which cylinders and capsules are made."""

    axis: Floats
    """Unit vector (3,)."""
    centre: Floats
    """Point of the axis that is nearest to the origin of the part's frame (3,) [m]."""
    radius: float
    """Distance of the farthest vertex from the axis [m]."""
    median_radius: float
    """Area-weighted median radius of the outward-facing surface [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class FitSubject:
    """A part to which primitives are fitted, with candidates that several kinds of primitives share."""

    outline: Outline
    frames: Sequence[Floats]
    """Frames of boxes (3, 3), with their axes as columns."""
    revolution_circles: Sequence[RevolutionCircle]
    """Circles of cylinders and capsules."""


def subject_of(surface: Surface) -> FitSubject | None:
    """Prepares a surface to be fitted; returns None if it is flat."""
    outline = outline_of(surface)
    if outline is None:
        return None
    all_silhouettes = silhouettes(outline)
    circles = tuple(_revolution_circles(outline, all_silhouettes))
    return FitSubject(outline, frames(outline, all_silhouettes), circles)


def best_fit(kind: PrimitiveKind, subject: FitSubject) -> PrimitiveFit:
    """Returns the fit of a kind with the smallest error, refined."""
    return _refine_best(list(_CANDIDATES[kind](subject)), subject.outline)


def best_fit_within(kind: PrimitiveKind, subject: FitSubject, max_error: float) -> PrimitiveFit | None:
    """Returns the best fit of a kind if its error is at most `max_error` [m], else None. Candidates that
    certainly have a larger error are not measured."""
    # Candidates below `max_refined_error` stay, since refining can reduce their error.
    max_lower_bound = max(max_error, max_refined_error(subject.outline))
    candidates = [
        primitive
        for primitive in _CANDIDATES[kind](subject)
        if error_lower_bound(primitive, subject.outline) <= max_lower_bound
    ]
    fit = _refine_best(candidates, subject.outline) if candidates else None
    return fit if fit and fit.error <= max_error else None


def _refine_best(candidates: Sequence[Primitive], outline: Outline) -> PrimitiveFit:
    """Returns the fit of the candidate with the smallest error, refined. `candidates`: at least one. Only
    those with the smallest coarse errors are measured finely."""
    coarse_fits = [
        PrimitiveFit(primitive, primitive_error(primitive, outline, fine=False)) for primitive in candidates
    ]
    coarse_fits.sort(key=lambda fit: fit.error)
    fine_count = _MAX_FINE_FITS if coarse_fits[0].error < _MAX_FINE_ERROR * outline.tolerance else 1
    fine_fits = [
        PrimitiveFit(fit.primitive, primitive_error(fit.primitive, outline))
        for fit in coarse_fits[:fine_count]
    ]
    best = first_of_best_fits(fine_fits, outline)
    return PrimitiveFit(*refined(best.primitive, best.error, outline))


def first_of_best_fits(fits: Sequence[PrimitiveFit], outline: Outline) -> PrimitiveFit:
    """Returns the first of the fits whose error counts as equal to the smallest (`_EQUAL_ERROR_SHARE`)."""
    limit = min(fit.error for fit in fits) * (1 + _EQUAL_ERROR_SHARE) + _EQUAL_ERROR_SHARE**2 * outline.size
    return next(fit for fit in fits if fit.error <= limit)


def fit_with_size(kind: PrimitiveKind, subject: FitSubject, size: Sequence[float | None]) -> Primitive:
    """Returns the best fit of a kind, with its lengths replaced by those of `size` [m], as in
    `Primitive.size`. For None, the length of the fit stays. A box is aligned with the part's frame."""
    primitive = _box(subject.outline, np.eye(3)) if kind == "box" else best_fit(kind, subject).primitive
    lengths = (
        fit_length if length is None else length
        for fit_length, length in zip(primitive.size, size, strict=True)
    )
    return replace(primitive, size=tuple(lengths))


def _boxes(subject: FitSubject) -> Iterator[Primitive]:
    """Yields two boxes for each frame: one around the part, and a smaller box, out of which the part
    stands."""
    for frame in subject.frames:
        yield _box(subject.outline, frame)
        yield _box(subject.outline, frame, balanced=True)


def _box(outline: Outline, frame: Floats, *, balanced: bool = False) -> Primitive:
    """Returns the smallest box around a part with the axes of `frame` (3, 3). `balanced`: the box protrudes
    from the part as far as it leaves the part bare."""
    coordinates = outline.hull_vertices @ frame
    low, high = coordinates.min(axis=0), coordinates.max(axis=0)
    if balanced:
        ends = [_balanced_ends(outline, frame[:, axis], low[axis], high[axis]) for axis in range(3)]
        low, high = np.transpose(ends)
    return _primitive("box", high - low, frame, frame @ np.array([low, high]).mean(axis=0))


def _balanced_ends(outline: Outline, axis: Floats, low: float, high: float) -> tuple[float, float]:
    """Returns the two ends along `axis` [m] of a primitive that protrudes from the part as far as it leaves
    the part bare. Each end is half-way between the outermost point (`low`, `high`) and the median height of
    the faces on that side."""
    depth = high - low
    # The lower end is the upper end along the opposite axis.
    opposite_end = (levels.face_height(outline, -axis, -low, depth) - low) / 2
    upper_end = (levels.face_height(outline, axis, high, depth) + high) / 2
    return -opposite_end, upper_end


class _EnclosingCylinder(NamedTuple):
    """The smallest cylinder around a part along an axis."""

    silhouette: Silhouette
    """Silhouette of the part along the axis."""
    centre: Floats
    """Centre of the silhouette's smallest circle, along its `u` and `v` (2,) [m]."""
    radius: float

    @property
    def volume_over_pi(self) -> float:
        """Volume divided by π [m³]."""
        return self.radius * self.radius * (self.silhouette.high - self.silhouette.low)


def _revolution_circles(
    outline: Outline, all_silhouettes: Sequence[Silhouette]
) -> Iterator[RevolutionCircle]:
    """Yields two circles for each axis of the smallest cylinders: the smallest circle around the part, and
    the circle around the centre of its normals, if they have a common centre."""
    cylinders = [
        _EnclosingCylinder(silhouette, *smallest_ball(silhouette.ring)) for silhouette in all_silhouettes
    ]
    cylinders.sort(key=lambda cylinder: cylinder.volume_over_pi)
    for silhouette, (u, v), radius in cylinders[:_MAX_AXES]:
        circle_centre = u * silhouette.u + v * silhouette.v
        median_radius = levels.median_radius(outline, circle_centre, silhouette.axis, radius)
        yield RevolutionCircle(silhouette.axis, circle_centre, radius, median_radius)
        normal_circle = _circle_by_normals(outline, silhouette, circle_centre, radius)
        if normal_circle is not None:
            yield normal_circle


def _circle_by_normals(
    outline: Outline, silhouette: Silhouette, circle_centre: Floats, radius: float
) -> RevolutionCircle | None:
    """Returns the circle around the point on which the lines of the surface's normals meet; None if they do
    not meet. `circle_centre` (3,), `radius` [m]: the smallest circle around the part."""
    axis = silhouette.axis
    normal_centre = levels.revolution_centre(outline, axis, circle_centre, radius)
    if normal_centre is None:
        return None
    # The normals do not determine the height along the axis, which is set to 0.
    normal_centre = normal_centre - axis * float(normal_centre @ axis)
    u_offsets = silhouette.ring[:, 0] - normal_centre @ silhouette.u
    v_offsets = silhouette.ring[:, 1] - normal_centre @ silhouette.v
    radius = float(np.hypot(u_offsets, v_offsets).max())
    return RevolutionCircle(
        axis, normal_centre, radius, levels.median_radius(outline, normal_centre, axis, radius)
    )


def _cylinders(subject: FitSubject) -> Iterator[Primitive]:
    """Yields two cylinders for each circle: one around the part, and a smaller cylinder."""
    for circle in subject.revolution_circles:
        heights = subject.outline.hull_vertices @ circle.axis
        low, high = float(heights.min()), float(heights.max())
        yield _solid_of_revolution("cylinder", circle, circle.radius, low, high)
        low, high = _balanced_ends(subject.outline, circle.axis, low, high)
        yield _solid_of_revolution("cylinder", circle, (circle.radius + circle.median_radius) / 2, low, high)


def _capsules(subject: FitSubject) -> Iterator[Primitive]:
    """Yields two capsules for each circle: one around the part, and a thinner capsule of the same length."""
    for circle in subject.revolution_circles:
        offsets = subject.outline.hull_vertices - circle.centre
        heights = offsets @ circle.axis
        axis_distances = np.linalg.norm(offsets - np.outer(heights, circle.axis), axis=1)
        # Each vertex may be at most `radius` from the segment between the centres of the caps.
        cap_heights = np.sqrt(np.maximum(circle.radius**2 - axis_distances**2, 0.0))
        low, high = float((heights + cap_heights).min()), float((heights - cap_heights).max())
        min_length = _MIN_CAPSULE_LENGTH * circle.radius
        if high - low < min_length:
            middle = float(heights.min() + heights.max()) / 2
            low, high = middle - min_length / 2, middle + min_length / 2
        yield _solid_of_revolution("capsule", circle, circle.radius, low, high)
        yield _solid_of_revolution("capsule", circle, (circle.radius + circle.median_radius) / 2, low, high)


def _spheres(subject: FitSubject) -> Iterator[Primitive]:
    """Yields two spheres for each centre: one around the part, and a smaller sphere. The centres are that of
    the smallest ball, and that of the surface's normals, if they have a common centre."""
    corners = subject.outline.hull_vertices
    ball_centre, ball_radius = smallest_ball(corners)
    normal_centre = levels.revolution_centre(subject.outline, None, ball_centre, ball_radius)
    for centre in [ball_centre] if normal_centre is None else [ball_centre, normal_centre]:
        radius = float(np.linalg.norm(corners - centre, axis=1).max())
        median_radius = levels.median_radius(subject.outline, centre, None, radius)
        yield _primitive("sphere", [radius], np.eye(3), centre)
        yield _primitive("sphere", [(radius + median_radius) / 2], np.eye(3), centre)


def _solid_of_revolution(
    kind: PrimitiveKind, circle: RevolutionCircle, radius: float, low: float, high: float
) -> Primitive:
    """Returns a cylinder or capsule around a circle's axis. `low`, `high`: its ends along the axis [m], from
    the circle's centre; of a capsule, the centres of its caps."""
    frame = np.stack([*axes_across(circle.axis), circle.axis], axis=1)
    return _primitive(kind, [radius, high - low], frame, circle.centre + circle.axis * (low + high) / 2)


def _primitive(
    kind: PrimitiveKind, size: Sequence[float] | Floats, frame: npt.NDArray[np.float64], centre: Floats
) -> Primitive:
    """Returns a primitive with rounded size and position. `frame`: its axes as columns (3, 3)."""
    lengths = tuple(round(float(length), _LENGTH_DECIMALS) for length in size)
    # Adding 0 turns -0 into 0.
    position = np.round(centre, _LENGTH_DECIMALS) + 0.0
    return Primitive(kind, lengths, frozen(from_parts(frame, position)))


_CANDIDATES: Mapping[PrimitiveKind, Callable[[FitSubject], Iterator[Primitive]]] = {
    "sphere": _spheres,
    "capsule": _capsules,
    "box": _boxes,
    "cylinder": _cylinders,
}
"""Kind of primitive → function that yields the candidates among which the best fit is chosen."""
