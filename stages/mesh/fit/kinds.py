"""The best fit of each kind of primitive."""

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

_ALIKE = 1e-3
"""Errors that differ by less than this share, or by a thousandth of it of the part's size, are alike."""

_AXES = 3
_LOOKED_AT = 3
_WORTH_IT = 4.0
"""Of an error of more than so many times the usual tolerance no second fit is looked at closely."""
_DECIMALS = 12
_SHORTEST = 0.02


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """A primitive and its error [m]: the least tolerance that it meets."""

    primitive: Primitive
    error: float


@dataclass(frozen=True, slots=True, eq=False)
class Turned:
    """A circle around a part: its axis, a point on it, the radius of the farthest vertex, and that of the
    bulk of the surface around it [m]."""

    axis: Floats
    centre: Floats
    radius: float
    bulk: float


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """A part, and what several kinds of primitives ask about it."""

    outline: Outline
    frames: Sequence[npt.NDArray[np.float64]]
    turned: Sequence[Turned]


def subject_of(surface: Surface) -> Subject | None:
    """None of what lies in a plane."""
    outline = outline_of(surface)
    if outline is None:
        return None
    seen = silhouettes(outline)
    return Subject(outline, frames(outline, seen), tuple(_turned(outline, seen)))


def best(kind: PrimitiveKind, subject: Subject) -> Fitted:
    """The fit of one kind with the least error."""
    return _best(list(_MAKERS[kind](subject)), subject.outline)


def best_within(kind: PrimitiveKind, subject: Subject, within: float) -> Fitted | None:
    """The same, if its error is at most `within` [m], else None; what is certainly farther off is not looked
    at."""
    near = max(within, refined_below(subject.outline))
    shapes = [shape for shape in _MAKERS[kind](subject) if least_error(shape, subject.outline) <= near]
    fit = _best(shapes, subject.outline) if shapes else None
    return fit if fit and fit.error <= within else None


def _best(shapes: Sequence[Primitive], outline: Outline) -> Fitted:
    found = [Fitted(shape, error(shape, outline, fine=False)) for shape in shapes]
    found.sort(key=lambda one: one.error)
    closer = _LOOKED_AT if found[0].error < _WORTH_IT * outline.tolerance else 1
    looked = [Fitted(one.primitive, error(one.primitive, outline)) for one in found[:closer]]
    first = least(looked, outline)
    return Fitted(*refined(first.primitive, first.error, outline))


def least(found: Sequence[Fitted], outline: Outline) -> Fitted:
    """The first of those whose error is not larger than the least, or hardly."""
    limit = min(one.error for one in found) * (1 + _ALIKE) + _ALIKE**2 * outline.size
    return next(one for one in found if one.error <= limit)


def given(kind: PrimitiveKind, subject: Subject, size: Sequence[float | None]) -> Primitive:
    """The best fit of one kind with these sizes; None in `size` is free. A box stands along x, y and z."""
    fitted = _box(subject.outline, np.eye(3)) if kind == "box" else best(kind, subject).primitive
    return replace(
        fitted,
        size=tuple(free if said is None else said for free, said in zip(fitted.size, size, strict=True)),
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
    """Between the outermost points and the bulk of the faces that face along `axis`, on either side."""
    depth = high - low
    below = (levels.flat(outline, -axis, -low, depth) - low) / 2
    above = (levels.flat(outline, axis, high, depth) + high) / 2
    return -below, above


def _turned(outline: Outline, seen: Sequence[Silhouette]) -> Iterator[Turned]:
    """Circles around the axes of the smallest cylinders: the smallest circle, and that of the normals."""
    found = []
    for one in seen:
        centre, radius = smallest_ball(one.ring)
        found.append((radius * radius * (one.high - one.low), one, centre, radius))
    found.sort(key=lambda row: row[0])
    for _, one, centre, radius in found[:_AXES]:
        point = centre[0] * one.u + centre[1] * one.v
        yield Turned(one.axis, point, radius, levels.around(outline, point, one.axis, radius))
        other = levels.centre_of_turn(outline, one.axis, point, radius)
        if other is not None:
            other = other - one.axis * float(other @ one.axis)
            farthest = float(np.hypot(one.ring[:, 0] - other @ one.u, one.ring[:, 1] - other @ one.v).max())
            yield Turned(one.axis, other, farthest, levels.around(outline, other, one.axis, farthest))


def _cylinders(subject: Subject) -> Iterator[Primitive]:
    for one in subject.turned:
        heights = subject.outline.corners @ one.axis
        low, high = float(heights.min()), float(heights.max())
        yield _along("cylinder", one, one.radius, low, high)
        low, high = _ends(subject.outline, one.axis, low, high)
        yield _along("cylinder", one, (one.radius + one.bulk) / 2, low, high)


def _capsules(subject: Subject) -> Iterator[Primitive]:
    for one in subject.turned:
        apart = subject.outline.corners - one.centre
        heights = apart @ one.axis
        widths = np.linalg.norm(apart - np.outer(heights, one.axis), axis=1)
        # Every vertex is within the farthest one's distance of the segment.
        caps = np.sqrt(np.maximum(one.radius**2 - widths**2, 0.0))
        low, high = float((heights + caps).min()), float((heights - caps).max())
        if high - low < _SHORTEST * one.radius:
            middle, half = float(heights.min() + heights.max()) / 2, _SHORTEST * one.radius / 2
            low, high = middle - half, middle + half
        yield _along("capsule", one, one.radius, low, high)
        yield _along("capsule", one, (one.radius + one.bulk) / 2, low, high)


def _spheres(subject: Subject) -> Iterator[Primitive]:
    corners = subject.outline.corners
    centre, radius = smallest_ball(corners)
    other = levels.centre_of_turn(subject.outline, None, centre, radius)
    for point in [centre] if other is None else [centre, other]:
        farthest = float(np.linalg.norm(corners - point, axis=1).max())
        bulk = levels.around(subject.outline, point, None, farthest)
        yield _primitive("sphere", [farthest], np.eye(3), point)
        yield _primitive("sphere", [(farthest + bulk) / 2], np.eye(3), point)


def _along(kind: PrimitiveKind, turned: Turned, radius: float, low: float, high: float) -> Primitive:
    """A cylinder or capsule between two heights along its axis."""
    frame = np.stack([*across(turned.axis), turned.axis], axis=1)
    return _primitive(kind, [radius, high - low], frame, turned.centre + turned.axis * (low + high) / 2)


def _primitive(
    kind: PrimitiveKind, size: Sequence[float] | Floats, frame: npt.NDArray[np.float64], centre: Floats
) -> Primitive:
    lengths = tuple(round(float(length), _DECIMALS) for length in size)
    return Primitive(kind, lengths, frozen(from_parts(frame, np.round(centre, _DECIMALS) + 0.0)))


_MAKERS: Mapping[PrimitiveKind, Callable[[Subject], Iterator[Primitive]]] = {
    "sphere": _spheres,
    "capsule": _capsules,
    "box": _boxes,
    "cylinder": _cylinders,
}
