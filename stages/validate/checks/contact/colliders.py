"""Checks that the colliders of each link are where its visual shapes are, and of their size.

The check measures how far the colliders reach beyond the visual shapes, in many directions, and how far
points of the visual shapes are outside every collider. Both errors may be as large as was found when the
collider was made; for colliders that were not judged then, they may be a share of the link's size.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from linkwright.stages.robot.check import Check, CheckLevel, Finding
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.model.shapes import directions, outside, reach, seen_and_solid, surface_points

DIRECTIONS = 48
"""Number of directions in which the reach is measured, in addition to the axes."""

POINTS = 600
"""Largest number of points of the visual shapes that are measured."""

MAX_SHARE = 1.0
"""Error, as a share of the link's size, above which a collider belongs elsewhere or has other units."""

MAX_SIZE_RATIO = 300.0
"""Ratio of the sizes of visual shape and collider that is exceeded only if millimetres are taken for
metres."""

MAX_UNJUDGED_SHARE = 0.1
"""Error, as a share of the link's size, up to which an unjudged collider is accepted."""

MIN_MOVED_SHARE = 0.04
"""Share of the link's size above which both errors together are reported: the collider may have been moved,
turned or mirrored."""

MIN_ERROR = 1e-3
"""Error [m] up to which every collider is accepted, however small its link is."""

SPARE_SHARE = 0.01
"""Share of a link's size that is added to the error found when the collider was made, since this check
samples other points."""


@dataclass(frozen=True, slots=True)
class Fit:
    """The errors of the colliders of a body against its visual shapes."""

    size: float
    """The diagonal [m] of the visual shapes."""

    collider_size: float
    """The diagonal [m] of the colliders."""

    beyond: float
    """The distance [m] by which the colliders reach beyond the visual shapes."""

    bare: float
    """The largest distance [m] of a point of the visual shapes from the colliders."""

    furthest: int
    """The index of the geom that reaches furthest beyond the visual shapes."""


def measured_fit(model: Any, seen: Sequence[int], solid: Sequence[int]) -> Fit:
    """Measures the errors of the colliders `solid` of a body against its visual geoms `seen`."""
    along = np.concatenate([np.eye(3), -np.eye(3), directions(DIRECTIONS)])
    visual, collider_reaches = (
        reach(model, seen, along),
        np.array([reach(model, [geom], along) for geom in solid]),
    )
    beyond = collider_reaches - visual
    furthest = solid[int(np.unravel_index(beyond.argmax(), beyond.shape)[0])]
    bare = outside(model, solid, surface_points(model, seen, POINTS))
    size, solid_size = (
        float(np.linalg.norm(ends[:3] + ends[3:6])) for ends in (visual, collider_reaches.max(axis=0))
    )
    return Fit(size, solid_size, max(0.0, float(beyond.max())), float(bare.max(initial=0.0)), furthest)


@dataclass(frozen=True, slots=True)
class AllowedErrors:
    """The errors that a body's colliders may have."""

    beyond: float | None
    """The largest `Fit.beyond` [m]; None if any is intended."""

    bare: float | None
    """The largest `Fit.bare` [m]; None if any is intended."""

    judged: bool
    """Whether the colliders were judged when they were made."""

    spare: float
    """Length [m] that is added to both."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Yields two results: an error for colliders that are far off, and a warning for doubtful colliders."""
    wrong, doubtful, worst, body_count = [], [], 0.0, 0
    for body, (seen, solid) in seen_and_solid(compiled.model).items():
        if not seen or not solid:
            continue
        body_fit, name = measured_fit(compiled.model, seen, solid), compiled.model.body(body).name
        body_count += 1
        limits = allowed_errors(compiled, name, body_fit.size)
        beyond, bare = _excess(body_fit.beyond, limits.beyond), _excess(body_fit.bare, limits.bare)
        error = max(beyond, bare)
        worst = max(worst, error)
        # The collider of a part that is not drawn reaches beyond the visual shapes.
        finding = _finding(compiled.model, name, body_fit, limits)
        if (limits.judged and bare > 2.0 * limits.spare) or _is_elsewhere(body_fit, error):
            wrong.append((error, finding))
        elif error > 0.0 or _is_moved(body_fit, limits):
            doubtful.append((error, finding))
    if not body_count:
        return
    yield _result(compiled, "colliders", "error", wrong, worst, body_count)
    yield _result(compiled, "fit of the colliders", "warning", doubtful, worst, body_count)


def _result(
    compiled: CompiledModel,
    name: str,
    level: CheckLevel,
    errors: Sequence[tuple[float, Finding]],
    worst: float,
    body_count: int,
) -> Check:
    findings = [finding for _, finding in sorted(errors, key=lambda row: -row[0])]
    detail = f"the colliders of {count(body_count, 'link')} are where their visual shapes are"
    if findings:
        detail = (
            f"{count(len(findings), 'link')} of {body_count} with colliders that are off the visual shapes"
        )
    return compiled.result(name, not findings, detail, worst, None, findings, level)


def _excess(error: float, limit: float | None) -> float:
    """Returns the length [m] by which an error is more than is allowed; 0 if any error is intended."""
    return 0.0 if limit is None else max(0.0, error - limit)


def _is_elsewhere(fit: Fit, excess: float) -> bool:
    """Tells whether a collider belongs to another place, or has other units than the visual shapes. `excess`:
    the length [m] by which its error is more than is allowed."""
    small, large = sorted((fit.size, fit.collider_size))
    return excess > MAX_SHARE * fit.size or (excess > 0.0 and large > MAX_SIZE_RATIO * small)


def _is_moved(fit: Fit, limits: AllowedErrors) -> bool:
    """Tells whether an unjudged collider has both errors, although neither of them is intended."""
    unjudged = not limits.judged and limits.beyond is not None and limits.bare is not None
    return unjudged and min(fit.beyond, fit.bare) > max(MIN_ERROR, MIN_MOVED_SHARE * fit.size)


def _finding(model: Any, body: str, fit: Fit, limits: AllowedErrors) -> Finding:
    """Returns a finding at the collider that reaches furthest if that is the error, else at the body."""
    bound = "recorded as within" if limits.judged else "expected within"
    texts = []
    if limits.beyond is not None:
        texts.append(f"reaches {_mm(fit.beyond)} beyond the visual shapes ({bound} {_mm(limits.beyond)})")
    if limits.bare is not None:
        texts.append(f"leaves {_mm(fit.bare)} of them bare ({bound} {_mm(limits.bare)})")
    message = f"the collider of {body} {' and '.join(texts)}"
    if _is_moved(fit, limits):
        message += ": both, as if it had been moved, turned or mirrored"
    name = model.geom(fit.furthest).name
    reaches = limits.beyond is not None and fit.beyond > min(limits.beyond, fit.bare)
    if name and reaches:
        return Finding(named("geom", name), "pos", message)
    return Finding(named("body", body), "geom", message)


def _mm(length: float) -> str:
    return f"{1e3 * length:.3g} mm"


def allowed_errors(compiled: CompiledModel, body: str, size: float) -> AllowedErrors:
    """Returns the errors that the colliders of a body may have, from the robot's links."""
    names = {name for name, (holder, _) in compiled.held.items() if holder == body} or {body}
    links = [link for link in compiled.robot.links if link.name in names]
    parts = [part for link in links for part in link.parts if part.mesh is not None]
    shapes = [shape for link in links for shape in link.shapes]
    figures = compiled.geometry.colliders if compiled.geometry else ()
    figures_of_body = [figure for figure in figures if figure.link in names]
    judged = [figure for figure in figures_of_body if figure.rung != "none"]
    # A visual shape without contact is bare, and an invisible collider is beyond, as is a geom that is both
    # seen and solid. In a file with purely visual and purely colliding shapes these must be in one place.
    seen = any(not part.collides for part in parts) or any(not shape.collision for shape in shapes)
    solid = any(not part.seen for part in parts) or any(not shape.visual for shape in shapes)
    has_shared_shape = any(shape.visual and shape.collision for shape in shapes)
    separate = seen and solid and not has_shared_shape
    covered = sum(len(figure.parts) for figure in judged) >= len(parts)
    # A collider that was fitted by contact was measured only where it can be touched.
    measures = [figure.measures for figure in judged if figure.measures is not None and not figure.reason]
    tolerances = (figure.tolerance for figure in judged if figure.tolerance is not None)
    spare = max([MIN_ERROR, SPARE_SHARE * size, *tolerances])
    if judged and len(measures) == len(judged) and not solid and not shapes:
        beyond = spare + max(measure.protrusion_max for measure in measures)
        bare = spare + max(measure.bareness_max for measure in measures)
        return AllowedErrors(beyond, bare if covered and not seen else None, True, spare)
    max_error = max(MIN_ERROR, MAX_UNJUDGED_SHARE * size)
    uncovered = seen or (bool(figures_of_body) and not covered)
    return AllowedErrors(
        None if (solid or has_shared_shape) and not separate else max_error,
        None if uncovered and not separate else max_error,
        False,
        spare,
    )
