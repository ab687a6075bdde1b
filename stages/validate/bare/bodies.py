"""Compares the bodies of a bare file with their shapes and each other, under the codes of a build."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from linkwright.stages.robot.check import CheckLevel, Finding
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.validate.bare.figures import Lump, ShapeFigures
from linkwright.stages.validate.bare.findings import CodedFinding
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.model.body_shapes import measured_directions
from linkwright.stages.validate.model.inertials import MAX_DUMMY_MASS, MAX_MARKER_SIZE, ShapedInertial

MAX_MASS_RATIO = 1000.0
"""Mass ratio of neighbours above which solvers struggle."""

MIN_DOUBTFUL_DISTANCE, MIN_WRONG_DISTANCE = 0.1, 1.0
"""Distances of a collider from the visual shapes, as shares of their size: above the first the collider is
worth a look, above the second it belongs elsewhere."""

MIN_DOUBTFUL_WIDTH = 5.0
"""Width of a collider, in widths of the visual shapes, above which it is worth a look."""


def inertials(lumps: Sequence[Lump]) -> list[ShapedInertial]:
    """Returns the inertials of the lumps whose shapes are known."""
    inertials = (lump.inertial for lump in lumps)
    return [inertial for inertial in inertials if inertial is not None]


def colliders(lumps: Sequence[Lump]) -> tuple[CheckLevel, list[Finding]]:
    """Returns findings on colliders that are far from the visual shapes of their lump, or many times their
    size, with the level: an error if a collider is certainly wrong, which then comes first."""
    misplaced = [row for lump in lumps for row in _misplaced(lump)]
    level: CheckLevel = "error" if any(wrong for wrong, _ in misplaced) else "warning"
    return level, [finding for _, finding in sorted(misplaced, key=lambda row: not row[0])]


def weightless(lumps: Sequence[Lump]) -> Iterator[CodedFinding]:
    """Yields the bodies of a URDF that move although neither they nor the bodies that they carry have a mass:
    no engine can move these."""
    holders = {body.name: lump.body.name for lump in lumps for body, _ in lump.members}
    above = {lump.body.name: holders.get(lump.body.parent, "") for lump in lumps}
    heavy = {""}
    for lump in lumps:
        name = lump.body.name if lump.mass else ""
        while name not in heavy:
            heavy.add(name)
            name = above[name]
    moving = {lump.body.name for lump in lumps if lump.moves}
    for name in sorted(moving - heavy):
        if above[name]:
            message = "it moves, and neither it nor what it carries has a mass"
            yield "C-SOLID", Finding(named("link", name), "inertial", message)


def _misplaced(lump: Lump) -> Iterator[tuple[bool, Finding]]:
    """Yields colliders that are far from the visual shapes, or many times their size, each with whether it is
    certainly wrong."""
    shapes = list(lump.shapes)
    drawn = {shape.group for shape, _ in shapes if shape.seen and not shape.collides}
    # A collider that is drawn together with purely visual shapes belongs to the picture.
    drawn_shapes = [(shape, points) for shape, points in shapes if shape.seen and shape.group in drawn]
    seen = _form(drawn_shapes)
    if seen is None or not all(body.whole for body, _ in lump.members):
        return
    low, high = seen.min(axis=0), seen.max(axis=0)
    name, size = lump.body.name, float(np.linalg.norm(high - low))
    solid = [
        (shape, points)
        for shape, points in shapes
        if shape.collides and not (shape.seen and shape.group in drawn)
    ]
    elsewhere = (
        _surface_distance([points for _, points in solid], seen)
        > (MIN_WRONG_DISTANCE + MIN_DOUBTFUL_DISTANCE) * size
    )
    for shape, points in solid:
        gap = np.maximum(0.0, np.maximum(low - points.max(axis=0), points.min(axis=0) - high))
        distance = float(np.linalg.norm(gap))
        if distance > MIN_DOUBTFUL_DISTANCE * size:
            message = (
                f'a collider of "{name}" is {distance:.3g} m beside the visual shapes, {size:.2g} m wide'
            )
            yield elsewhere, Finding(*shape.placed_by, message)
        elif shape.extent > MIN_DOUBTFUL_WIDTH * size > 0.0:
            message = f'a collider of "{name}" is {shape.extent:.3g} m wide, the visual shapes {size:.2g} m'
            yield elsewhere, Finding(shape.element, shape.attribute, message)


def _surface_distance(solid: Sequence[Array], seen: Array) -> float:
    """Returns the distance [m] by which colliders reach beyond the visual shapes, or leave them uncovered.
    `solid`: the points (n, 3) of each collider; `seen`: the points (m, 3) of the visual shapes."""
    axes = measured_directions()
    along = seen @ axes.T
    ends = [((points @ axes.T).max(axis=0), (points @ axes.T).min(axis=0)) for points in solid]
    beyond = max(
        (max((high - along.max(axis=0)).max(), (along.min(axis=0) - low).max()) for high, low in ends),
        default=0.0,
    )
    outside = [np.maximum(along - high, low - along).max(axis=1) for high, low in ends]
    bare = np.min(outside, axis=0).max() if outside else 0.0
    return float(max(beyond, bare))


def _form(drawn_shapes: Sequence[tuple[ShapeFigures, Array]]) -> Array | None:
    """Returns the points (n, 3) of the drawn shapes. Returns None without shapes, or if they are a mere mark:
    many files have a box or a ball of a few millimetres for a link without a mesh."""
    if all(not shape.mesh and shape.extent < MAX_MARKER_SIZE for shape, _ in drawn_shapes):
        return None
    return np.concatenate([points for _, points in drawn_shapes])


def neighbours(lumps: Sequence[Lump]) -> Iterator[Finding]:
    """Yields lumps whose mass differs too much from the mass of the lump that they move on."""
    holders = {body.name: lump for lump in lumps for body, _ in lump.members}
    for lump in lumps:
        above = _above(lump, holders)
        if above is None or not lump.mass > MAX_DUMMY_MASS < above.mass:
            continue
        ratio = max(lump.mass / above.mass, above.mass / lump.mass)
        if ratio > MAX_MASS_RATIO:
            message = (
                f'{lump.mass:g} kg beside the {above.mass:g} kg of "{above.body.name}", {ratio:.2g} to 1'
            )
            yield Finding(*lump.body.places["mass"], message)


def _above(lump: Lump, holders: Mapping[str, Lump]) -> Lump | None:
    """Returns the lump that a lump moves on; None if that is the world."""
    above = holders.get(lump.body.parent)
    return above if lump.moves and above is not None and above.moves else None
