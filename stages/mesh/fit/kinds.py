"""Finds the best fit of each kind of primitive."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.fit import levels
from linkwright.stages.mesh.fit.circles import smallest_ball
from linkwright.stages.mesh.fit.directions import Silhouette, across, frames, silhouettes
from linkwright.stages.mesh.fit.outline import Floats, Outline, outline_of
from linkwright.stages.mesh.fit.refine import refined, refined_below
from linkwright.stages.mesh.fit.score import error, least_error
from linkwright.stages.robot.model.poses import from_parts
from linkwright.stages.robot.model.robot import Primitive, PrimitiveKind, frozen

_EQUAL_ERRORS = 1e-3
"""Errors count as equal if the larger exceeds the smaller by at most this share of the smaller, plus the
square of this number times the part's size."""

_MAX_AXES = 3
"""Largest number of axes of cylinders and capsules: those of the smallest cylinders."""

_MAX_CLOSE_FITS = 3
"""Largest number of fits of a kind that are measured finely: from many sample points."""

_MAX_CLOSE_ERROR = 4.0
"""Best coarse error, in default tolerances, from which on only the best fit is measured finely."""

_DECIMALS = 12
"""Decimals [m] of sizes and positions, so that they do not depend on how a processor rounds."""

_MIN_CAPSULE_LENGTH = 0.02
"""Smallest length of a capsule without its caps, in radii."""


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """A primitive, and its error [m]: the smallest tolerance that it meets."""

    primitive: Primitive
    error: float


@dataclass(frozen=True, slots=True, eq=False)
class RevolutionCircle:
    """A circle around a part, from which cylinders and capsules are made."""

    axis: Floats
    """Unit vector (3,)."""
    centre: Floats
    """Point on the axis (3,) [m]."""
    radius: float
    """Distance of the farthest vertex from the axis [m]."""
    median_radius: float
    """Area-weighted median radius of the outward-facing surface [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """A part, with the frames and circles that several kinds of primitives share."""

    outline: Outline
    frames: Sequence[npt.NDArray[np.float64]]
    revolution_circles: Sequence[RevolutionCircle]


def subject_of(surface: Surface) -> Subject | None:
    """Returns the subject of a surface; None if it is flat."""
    outline = outline_of(surface)
    if outline is None:
        return None
    outlines_across = silhouettes(outline)
    return Subject(
        outline, frames(outline, outlines_across), tuple(_revolution_circles(outline, outlines_across))
    )


def best_fit(kind: PrimitiveKind, subject: Subject) -> Fitted:
    """Returns the fit of a kind with the smallest error."""
    return _refined_best(list(_CANDIDATES[kind](subject)), subject.outline)


def best_within(kind: PrimitiveKind, subject: Subject, max_error: float) -> Fitted | None:
    """Returns the best fit of a kind if its error is at most `max_error` [m], else None. Shapes that
    certainly have a larger error are skipped."""
    max_coarse_error = max(max_error, refined_below(subject.outline))
    shapes = [
        shape
        for shape in _CANDIDATES[kind](subject)
        if least_error(shape, subject.outline) <= max_coarse_error
    ]
    fit = _refined_best(shapes, subject.outline) if shapes else None
    return fit if fit and fit.error <= max_error else None


def _refined_best(shapes: Sequence[Primitive], outline: Outline) -> Fitted:
    """Returns the best of at least one shape, refined. Only the best by the coarse error are measured
    finely."""
    fits = [Fitted(shape, error(shape, outline, fine=False)) for shape in shapes]
    fits.sort(key=lambda fit: fit.error)
    measured_count = _MAX_CLOSE_FITS if fits[0].error < _MAX_CLOSE_ERROR * outline.tolerance else 1
    measured_fits = [Fitted(fit.primitive, error(fit.primitive, outline)) for fit in fits[:measured_count]]
    first = first_best(measured_fits, outline)
    return Fitted(*refined(first.primitive, first.error, outline))


def first_best(fits: Sequence[Fitted], outline: Outline) -> Fitted:
    """Returns the first fit whose error equals the smallest error, as `_EQUAL_ERRORS` counts it."""
    limit = min(fit.error for fit in fits) * (1 + _EQUAL_ERRORS) + _EQUAL_ERRORS**2 * outline.size
    return next(fit for fit in fits if fit.error <= limit)


def fit_with_size(kind: PrimitiveKind, subject: Subject, size: Sequence[float | None]) -> Primitive:
    """Returns a primitive with the lengths `size`; where a length is None, that of the best fit is used. A
    box is aligned with the part's frame."""
    fitted = _box(subject.outline, np.eye(3)) if kind == "box" else best_fit(kind, subject).primitive
    return replace(
        fitted,
        size=tuple(
            fitted_length if given_length is None else given_length
            for fitted_length, given_length in zip(fitted.size, size, strict=True)
        ),
    )


def _boxes(subject: Subject) -> Iterator[Primitive]:
    for frame in subject.frames:
        yield _box(subject.outline, frame)
        yield _box(subject.outline, frame, balanced=True)


def _box(outline: Outline, frame: npt.NDArray[np.float64], balanced: bool = False) -> Primitive:
    """Returns the box of a part with these axes. `balanced`: whether it protrudes from the part as far as it
    leaves the part bare."""
    heights = outline.corners @ frame
    sides = np.array([heights.min(axis=0), heights.max(axis=0)])
    if balanced:
        ends = [_ends(outline, frame[:, axis], sides[0, axis], sides[1, axis]) for axis in range(3)]
        sides = np.transpose(ends)
    return _primitive("box", sides[1] - sides[0], frame, frame @ sides.mean(axis=0))


def _ends(outline: Outline, axis: Floats, low: float, high: float) -> tuple[float, float]:
    """Returns the two ends along `axis` of a primitive that protrudes from the part as far as it leaves the
    part bare. Each end is half-way between the outermost point (`low`, `high`) and the median height of the
    faces on that side."""
    depth = high - low
    below = (levels.face_height(outline, -axis, -low, depth) - low) / 2
    above = (levels.face_height(outline, axis, high, depth) + high) / 2
    return -below, above


def _revolution_circles(
    outline: Outline, outlines_across: Sequence[Silhouette]
) -> Iterator[RevolutionCircle]:
    """Yields circles around the axes of the smallest cylinders: the smallest circle, and the circle by the
    normals."""
    smallest_circles = []
    for silhouette in outlines_across:
        centre, radius = smallest_ball(silhouette.ring)
        volume = radius * radius * (silhouette.high - silhouette.low)
        smallest_circles.append((volume, silhouette, centre, radius))
    smallest_circles.sort(key=lambda row: row[0])
    for _, silhouette, centre, radius in smallest_circles[:_MAX_AXES]:
        point = centre[0] * silhouette.u + centre[1] * silhouette.v
        yield RevolutionCircle(
            silhouette.axis, point, radius, levels.median_radius(outline, point, silhouette.axis, radius)
        )
        normal_circle = _circle_by_normals(outline, silhouette, point, radius)
        if normal_circle is not None:
            yield normal_circle


def _circle_by_normals(
    outline: Outline, silhouette: Silhouette, point: Floats, radius: float
) -> RevolutionCircle | None:
    """Returns the circle around the centre to which the surface's normals point; None if they have no common
    centre. `point`, `radius`: the smallest circle."""
    axis = silhouette.axis
    centre = levels.revolution_centre(outline, axis, point, radius)
    if centre is None:
        return None
    centre = centre - axis * float(centre @ axis)
    farthest = float(
        np.hypot(
            silhouette.ring[:, 0] - centre @ silhouette.u, silhouette.ring[:, 1] - centre @ silhouette.v
        ).max()
    )
    return RevolutionCircle(axis, centre, farthest, levels.median_radius(outline, centre, axis, farthest))


def _cylinders(subject: Subject) -> Iterator[Primitive]:
    for circle in subject.revolution_circles:
        heights = subject.outline.corners @ circle.axis
        low, high = float(heights.min()), float(heights.max())
        yield _solid_of_revolution("cylinder", circle, circle.radius, low, high)
        low, high = _ends(subject.outline, circle.axis, low, high)
        yield _solid_of_revolution("cylinder", circle, (circle.radius + circle.median_radius) / 2, low, high)


def _capsules(subject: Subject) -> Iterator[Primitive]:
    for circle in subject.revolution_circles:
        offsets = subject.outline.corners - circle.centre
        heights = offsets @ circle.axis
        widths = np.linalg.norm(offsets - np.outer(heights, circle.axis), axis=1)
        # Each vertex may be at most `radius` from the segment between the centres of the caps.
        caps = np.sqrt(np.maximum(circle.radius**2 - widths**2, 0.0))
        low, high = float((heights + caps).min()), float((heights - caps).max())
        if high - low < _MIN_CAPSULE_LENGTH * circle.radius:
            middle, half = float(heights.min() + heights.max()) / 2, _MIN_CAPSULE_LENGTH * circle.radius / 2
            low, high = middle - half, middle + half
        yield _solid_of_revolution("capsule", circle, circle.radius, low, high)
        yield _solid_of_revolution("capsule", circle, (circle.radius + circle.median_radius) / 2, low, high)


def _spheres(subject: Subject) -> Iterator[Primitive]:
    corners = subject.outline.corners
    centre, radius = smallest_ball(corners)
    second_centre = levels.revolution_centre(subject.outline, None, centre, radius)
    for point in [centre] if second_centre is None else [centre, second_centre]:
        farthest = float(np.linalg.norm(corners - point, axis=1).max())
        median_radius = levels.median_radius(subject.outline, point, None, farthest)
        yield _primitive("sphere", [farthest], np.eye(3), point)
        yield _primitive("sphere", [(farthest + median_radius) / 2], np.eye(3), point)


def _solid_of_revolution(
    kind: PrimitiveKind, circle: RevolutionCircle, radius: float, low: float, high: float
) -> Primitive:
    """Returns a cylinder or capsule between two heights along its axis."""
    frame = np.stack([*across(circle.axis), circle.axis], axis=1)
    return _primitive(kind, [radius, high - low], frame, circle.centre + circle.axis * (low + high) / 2)


def _primitive(
    kind: PrimitiveKind, size: Sequence[float] | Floats, frame: npt.NDArray[np.float64], centre: Floats
) -> Primitive:
    lengths = tuple(round(float(length), _DECIMALS) for length in size)
    return Primitive(kind, lengths, frozen(from_parts(frame, np.round(centre, _DECIMALS) + 0.0)))


_CANDIDATES: Mapping[PrimitiveKind, Callable[[Subject], Iterator[Primitive]]] = {
    "sphere": _spheres,
    "capsule": _capsules,
    "box": _boxes,
    "cylinder": _cylinders,
}
"""Kind of primitive → a function that yields shapes, of which the best is chosen."""
