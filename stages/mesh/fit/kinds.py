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
"""Errors count as equal if they differ by less than this share of the error, or by less than a thousandth of
this share of the part's size."""

_MAX_AXES = 3
"""Largest number of axes of cylinders and capsules: those of the smallest cylinders."""

_MAX_CLOSE_FITS = 3
"""Largest number of fits of a kind whose error is computed by many points."""

_MAX_CLOSE_ERROR = 4.0
"""If the best coarse error exceeds this many default tolerances, only one fit is computed by many points."""

_DECIMALS = 12
"""Decimals [m] of sizes and places, so that they do not depend on how a processor rounds."""

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
    bulk: float
    """Radius of most of the surface around the axis [m]."""


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


def best(kind: PrimitiveKind, subject: Subject) -> Fitted:
    """Returns the fit of a kind with the least error."""
    return _best(list(_CANDIDATES[kind](subject)), subject.outline)


def best_within(kind: PrimitiveKind, subject: Subject, max_error: float) -> Fitted | None:
    """Returns the best fit of a kind if its error is at most `max_error` [m], else None. Shapes that
    certainly have a larger error are skipped."""
    max_coarse_error = max(max_error, refined_below(subject.outline))
    shapes = [
        shape
        for shape in _CANDIDATES[kind](subject)
        if least_error(shape, subject.outline) <= max_coarse_error
    ]
    fit = _best(shapes, subject.outline) if shapes else None
    return fit if fit and fit.error <= max_error else None


def _best(shapes: Sequence[Primitive], outline: Outline) -> Fitted:
    fits = [Fitted(shape, error(shape, outline, fine=False)) for shape in shapes]
    fits.sort(key=lambda fit: fit.error)
    measured_count = _MAX_CLOSE_FITS if fits[0].error < _MAX_CLOSE_ERROR * outline.tolerance else 1
    measured_fits = [Fitted(fit.primitive, error(fit.primitive, outline)) for fit in fits[:measured_count]]
    first = least(measured_fits, outline)
    return Fitted(*refined(first.primitive, first.error, outline))


def least(fits: Sequence[Fitted], outline: Outline) -> Fitted:
    """Returns the first fit whose error equals the least error."""
    limit = min(fit.error for fit in fits) * (1 + _EQUAL_ERRORS) + _EQUAL_ERRORS**2 * outline.size
    return next(fit for fit in fits if fit.error <= limit)


def sized(kind: PrimitiveKind, subject: Subject, size: Sequence[float | None]) -> Primitive:
    """Returns the best fit of a kind with these lengths; None in `size` is fitted. A box is not rotated."""
    fitted = _box(subject.outline, np.eye(3)) if kind == "box" else best(kind, subject).primitive
    return replace(
        fitted,
        size=tuple(
            fitted_length if chosen_length is None else chosen_length
            for fitted_length, chosen_length in zip(fitted.size, size, strict=True)
        ),
    )


def _boxes(subject: Subject) -> Iterator[Primitive]:
    for frame in subject.frames:
        yield _box(subject.outline, frame)
        yield _box(subject.outline, frame, balanced=True)


def _box(outline: Outline, frame: npt.NDArray[np.float64], balanced: bool = False) -> Primitive:
    heights = outline.corners @ frame
    sides = np.array([heights.min(axis=0), heights.max(axis=0)])
    if balanced:
        ends = [_ends(outline, frame[:, axis], sides[0, axis], sides[1, axis]) for axis in range(3)]
        sides = np.transpose(ends)
    return _primitive("box", sides[1] - sides[0], frame, frame @ sides.mean(axis=0))


def _ends(outline: Outline, axis: Floats, low: float, high: float) -> tuple[float, float]:
    """Returns the lowest and the highest end along `axis`, each half-way between the outermost point and most
    of the faces on that side, so that the primitive protrudes as much as it leaves bare."""
    depth = high - low
    below = (levels.face_height(outline, -axis, -low, depth) - low) / 2
    above = (levels.face_height(outline, axis, high, depth) + high) / 2
    return -below, above


def _revolution_circles(
    outline: Outline, outlines_across: Sequence[Silhouette]
) -> Iterator[RevolutionCircle]:
    """Yields circles around the axes of the smallest cylinders: the smallest circle, and one by the
    normals."""
    circles = []
    for silhouette in outlines_across:
        centre, radius = smallest_ball(silhouette.ring)
        circles.append((radius * radius * (silhouette.high - silhouette.low), silhouette, centre, radius))
    circles.sort(key=lambda row: row[0])
    for _, silhouette, centre, radius in circles[:_MAX_AXES]:
        point = centre[0] * silhouette.u + centre[1] * silhouette.v
        yield RevolutionCircle(
            silhouette.axis, point, radius, levels.median_radius(outline, point, silhouette.axis, radius)
        )
        second_centre = levels.revolution_centre(outline, silhouette.axis, point, radius)
        if second_centre is not None:
            second_centre = second_centre - silhouette.axis * float(second_centre @ silhouette.axis)
            farthest = float(
                np.hypot(
                    silhouette.ring[:, 0] - second_centre @ silhouette.u,
                    silhouette.ring[:, 1] - second_centre @ silhouette.v,
                ).max()
            )
            yield RevolutionCircle(
                silhouette.axis,
                second_centre,
                farthest,
                levels.median_radius(outline, second_centre, silhouette.axis, farthest),
            )


def _cylinders(subject: Subject) -> Iterator[Primitive]:
    for circle in subject.revolution_circles:
        heights = subject.outline.corners @ circle.axis
        low, high = float(heights.min()), float(heights.max())
        yield _along("cylinder", circle, circle.radius, low, high)
        low, high = _ends(subject.outline, circle.axis, low, high)
        yield _along("cylinder", circle, (circle.radius + circle.bulk) / 2, low, high)


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
        yield _along("capsule", circle, circle.radius, low, high)
        yield _along("capsule", circle, (circle.radius + circle.bulk) / 2, low, high)


def _spheres(subject: Subject) -> Iterator[Primitive]:
    corners = subject.outline.corners
    centre, radius = smallest_ball(corners)
    second_centre = levels.revolution_centre(subject.outline, None, centre, radius)
    for point in [centre] if second_centre is None else [centre, second_centre]:
        farthest = float(np.linalg.norm(corners - point, axis=1).max())
        bulk = levels.median_radius(subject.outline, point, None, farthest)
        yield _primitive("sphere", [farthest], np.eye(3), point)
        yield _primitive("sphere", [(farthest + bulk) / 2], np.eye(3), point)


def _along(
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
