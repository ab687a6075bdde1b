"""The colliders of each link are where its visual shapes are, and of their size.

What is measured: how far the colliders reach beyond all that is seen, in many directions; and how far points
of what is seen are outside every collider. A collider that was judged when it was made says how far it may be
off in either way; of others that is a share of the link's size.
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
POINTS = 600

AWAY = 1.0
"""Share of a link's size: a collider that is further off belongs to another place, or has other units."""

UNITS = 300.0
"""Nothing is so many times as large as its collider, or as small, but for millimetres taken for metres."""

OFF = 0.1
"""The same of a collider of which nothing is known, to be looked at; `MOVED` where it is off in both ways, as
one is that was moved, turned or mirrored."""
MOVED = 0.04

LEAST = 1e-3
"""Errors below this [m] are none, of a collider of which nothing is known."""

SPARE = 0.01
"""Share of a link's size beyond what a collider was judged to be off by: other points are looked at."""


@dataclass(frozen=True, slots=True)
class Fit:
    """How the colliders of a body are off from what is seen of it. `size` [m]: the diagonal of what is seen,
    and `solid` that of the colliders; `beyond`: how far these reach beyond what is seen, `furthest` the
    collider that does; `bare`: how far a point of what is seen is outside them."""

    size: float
    solid: float
    beyond: float
    bare: float
    furthest: int


def fit(model: Any, seen: Sequence[int], solid: Sequence[int]) -> Fit:
    """How the colliders `solid` of a body are off from the geoms `seen` of it."""
    along = np.concatenate([np.eye(3), -np.eye(3), directions(DIRECTIONS)])
    own, others = reach(model, seen, along), np.array([reach(model, [one], along) for one in solid])
    beyond = others - own
    furthest = solid[int(np.unravel_index(beyond.argmax(), beyond.shape)[0])]
    bare = outside(model, solid, surface_points(model, seen, POINTS))
    size, solids = (float(np.linalg.norm(one[:3] + one[3:6])) for one in (own, others.max(axis=0)))
    return Fit(size, solids, max(0.0, float(beyond.max())), float(bare.max(initial=0.0)), furthest)


@dataclass(frozen=True, slots=True)
class Allowed:
    """How far [m] a body's colliders may be off; None where any error is meant. `known`: whether they were
    judged when they were made, `spare` [m] what may be added to that."""

    beyond: float | None
    bare: float | None
    known: bool
    spare: float


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Two results: what is far off, an error; and what is worth a look."""
    wrong, doubtful, worst, bodies = [], [], 0.0, 0
    for body, (seen, solid) in seen_and_solid(compiled.model).items():
        if not seen or not solid:
            continue
        found, name = fit(compiled.model, seen, solid), compiled.model.body(body).name
        bodies += 1
        limits = allowed(compiled, name, found.size)
        beyond, bare = _over(found.beyond, limits.beyond), _over(found.bare, limits.bare)
        off = max(beyond, bare)
        worst = max(worst, off)
        # A part that is left undrawn has a collider all the same, which then is beyond what is seen.
        finding = _finding(compiled.model, name, found, limits)
        if (limits.known and bare > 2.0 * limits.spare) or _is_elsewhere(found, off):
            wrong.append((off, finding))
        elif off > 0.0 or _is_moved(found, limits):
            doubtful.append((off, finding))
    if not bodies:
        return
    yield _result(compiled, "colliders", "error", wrong, worst, bodies)
    yield _result(compiled, "fit of the colliders", "warning", doubtful, worst, bodies)


def _result(
    compiled: CompiledModel,
    name: str,
    level: CheckLevel,
    found: Sequence[tuple[float, Finding]],
    worst: float,
    bodies: int,
) -> Check:
    findings = [one for _, one in sorted(found, key=lambda one: -one[0])]
    detail = f"the colliders of {count(bodies, 'link')} are where their visual shapes are"
    if findings:
        detail = f"{count(len(findings), 'link')} of {bodies} with colliders that are off what is seen"
    return compiled.result(name, not findings, detail, worst, None, findings, level)


def _over(found: float, limit: float | None) -> float:
    return 0.0 if limit is None else max(0.0, found - limit)


def _is_elsewhere(found: Fit, off: float) -> bool:
    """Whether a collider belongs to another place, or has other units than what is seen."""
    small, large = sorted((found.size, found.solid))
    return off > AWAY * found.size or (off > 0.0 and large > UNITS * small)


def _is_moved(found: Fit, limits: Allowed) -> bool:
    """Whether a collider of which nothing is known is off in both ways."""
    unknown = not limits.known and limits.beyond is not None and limits.bare is not None
    return unknown and min(found.beyond, found.bare) > max(LEAST, MOVED * found.size)


def _finding(model: Any, body: str, found: Fit, limits: Allowed) -> Finding:
    """Names the collider that reaches furthest where that is what is wrong, else the body."""
    known = "judged to be within" if limits.known else "expected within"
    said = []
    if limits.beyond is not None:
        said.append(f"reaches {_mm(found.beyond)} beyond what is seen ({known} {_mm(limits.beyond)})")
    if limits.bare is not None:
        said.append(f"leaves {_mm(found.bare)} of it bare ({known} {_mm(limits.bare)})")
    message = f"the collider of {body} {' and '.join(said)}"
    if _is_moved(found, limits):
        message += ": both, as where it was moved, turned or mirrored"
    name = model.geom(found.furthest).name
    reaches = limits.beyond is not None and found.beyond > min(limits.beyond, found.bare)
    if name and reaches:
        return Finding(named("geom", name), "pos", message)
    return Finding(named("body", body), "geom", message)


def _mm(length: float) -> str:
    return f"{1e3 * length:.3g} mm"


def allowed(compiled: CompiledModel, body: str, size: float) -> Allowed:
    """How far the colliders of a body may be off, by what is known of the links that it holds."""
    names = {name for name, (holder, _) in compiled.held.items() if holder == body} or {body}
    links = [link for link in compiled.robot.links if link.name in names]
    parts = [part for link in links for part in link.parts if part.mesh is not None]
    shapes = [shape for link in links for shape in link.shapes]
    figures = compiled.geometry.colliders if compiled.geometry else ()
    own = [one for one in figures if one.link in names]
    made = [one for one in own if one.rung != "none"]
    # What is seen and does not collide is bare; what collides and is not seen is beyond, and so is a geom
    # that does both. A file that has what is only seen and what only collides is to have them in one place.
    seen = any(not one.collides for one in parts) or any(not one.collision for one in shapes)
    solid = any(not one.seen for one in parts) or any(not one.visual for one in shapes)
    both = any(one.visual and one.collision for one in shapes)
    apart = seen and solid and not both
    covered = sum(len(one.parts) for one in made) >= len(parts)
    # A collider by contact is measured where it can be reached alone.
    measures = [one.measures for one in made if one.measures is not None and not one.reason]
    spare = max([LEAST, SPARE * size, *(one.tolerance for one in made if one.tolerance is not None)])
    if made and len(measures) == len(made) and not solid and not shapes:
        beyond = spare + max(one.protrusion_max for one in measures)
        bare = spare + max(one.bareness_max for one in measures)
        return Allowed(beyond, bare if covered and not seen else None, True, spare)
    off = max(LEAST, OFF * size)
    uncovered = seen or (bool(own) and not covered)
    return Allowed(
        None if (solid or both) and not apart else off,
        None if uncovered and not apart else off,
        False,
        spare,
    )
