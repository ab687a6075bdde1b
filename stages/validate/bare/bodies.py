"""Compares the bodies of a bare file with their shapes and with each other, under the codes of a build."""

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
"""Ratio of the masses of neighbouring bodies above which solvers converge slowly."""

MIN_DOUBTFUL_DISTANCE, MIN_WRONG_DISTANCE = 0.1, 1.0
"""Distances as shares of the size of the visual shapes. A collider whose box is farther than the first from
theirs is reported. If the colliders miss the visual shapes by more than the sum of both, that is an error."""

MIN_DOUBTFUL_WIDTH = 5.0
"""Width of a collider, in widths of the visual shapes, above which it is worth a look."""


def lump_inertials(lumps: Sequence[Lump]) -> list[ShapedInertial]:
    """Returns the inertials of the lumps whose shapes are known."""
    return [inertial for lump in lumps if (inertial := lump.inertial) is not None]


def collider_findings(lumps: Sequence[Lump]) -> tuple[CheckLevel, list[Finding]]:
    """Returns findings on colliders that are far from the visual shapes of their lump, or many times their
    size, with the level: an error if a collider is certainly wrong, which then comes first."""
    rows = [row for lump in lumps for row in _misplaced_colliders(lump)]
    level: CheckLevel = "error" if any(is_certain for is_certain, _ in rows) else "warning"
    return level, [finding for _, finding in sorted(rows, key=lambda row: not row[0])]


def massless_findings(lumps: Sequence[Lump]) -> Iterator[CodedFinding]:
    """Yields the bodies of a URDF that move although neither they nor the bodies that they carry have a mass:
    no engine can simulate these."""
    lump_by_body = {body.name: lump.body.name for lump in lumps for body, _ in lump.members}
    parents = {lump.body.name: lump_by_body.get(lump.body.parent, "") for lump in lumps}
    # "" stands for the world, at which each walk towards the root ends.
    carrying_mass = {""}
    for lump in lumps:
        name = lump.body.name if lump.mass else ""
        while name not in carrying_mass:
            carrying_mass.add(name)
            name = parents[name]
    moving = {lump.body.name for lump in lumps if lump.moves}
    for name in sorted(moving - carrying_mass):
        if parents[name]:
            message = "it moves, and neither it nor what it carries has a mass"
            yield "C-SOLID", Finding(named("link", name), "inertial", message)


def _misplaced_colliders(lump: Lump) -> Iterator[tuple[bool, Finding]]:
    """Yields (whether the lump's colliders are certainly wrong, finding) for each collider that is far from
    the visual shapes, or many times their size. Yields nothing without visual shapes, or if a shape cannot be
    read."""
    shapes = list(lump.shapes)
    visual_groups = {shape.group for shape, _ in shapes if shape.seen and not shape.collides}
    # A collider that is drawn together with purely visual shapes belongs to the picture.
    visuals = [(shape, points) for shape, points in shapes if shape.seen and shape.group in visual_groups]
    visual_points = _visual_points(visuals)
    if visual_points is None or not all(body.whole for body, _ in lump.members):
        return
    low, high = visual_points.min(axis=0), visual_points.max(axis=0)
    name, size = lump.body.name, float(np.linalg.norm(high - low))
    colliders = [
        (shape, points)
        for shape, points in shapes
        if shape.collides and not (shape.seen and shape.group in visual_groups)
    ]
    is_certain = (
        _surface_distance([points for _, points in colliders], visual_points)
        > (MIN_WRONG_DISTANCE + MIN_DOUBTFUL_DISTANCE) * size
    )
    for shape, points in colliders:
        gap = np.maximum(0.0, np.maximum(low - points.max(axis=0), points.min(axis=0) - high))
        distance = float(np.linalg.norm(gap))
        if distance > MIN_DOUBTFUL_DISTANCE * size:
            message = (
                f'a collider of "{name}" is {distance:.3g} m beside the visual shapes, {size:.2g} m wide'
            )
            yield is_certain, Finding(*shape.placed_by, message)
        elif shape.extent > MIN_DOUBTFUL_WIDTH * size > 0.0:
            message = f'a collider of "{name}" is {shape.extent:.3g} m wide, the visual shapes {size:.2g} m'
            yield is_certain, Finding(shape.element, shape.attribute, message)


def _surface_distance(colliders: Sequence[Array], visual_points: Array) -> float:
    """Returns the distance [m] by which colliders reach beyond the visual shapes, or by which points of the
    visual shapes are outside every collider, whichever is larger. `colliders`: the points (n, 3) of each
    collider; `visual_points` (m, 3)."""
    axes = measured_directions()
    along = visual_points @ axes.T
    ends = [((points @ axes.T).max(axis=0), (points @ axes.T).min(axis=0)) for points in colliders]
    beyond = max(
        (max((high - along.max(axis=0)).max(), (along.min(axis=0) - low).max()) for high, low in ends),
        default=0.0,
    )
    outside = [np.maximum(along - high, low - along).max(axis=1) for high, low in ends]
    uncovered = np.min(outside, axis=0).max() if outside else 0.0
    return float(max(beyond, uncovered))


def _visual_points(visuals: Sequence[tuple[ShapeFigures, Array]]) -> Array | None:
    """Returns the points (n, 3) of the visual shapes. Returns None without shapes, or if they only mark a
    place: many files have a box or a ball of a few millimetres for a link without a mesh."""
    if all(not shape.mesh and shape.extent < MAX_MARKER_SIZE for shape, _ in visuals):
        return None
    return np.concatenate([points for _, points in visuals])


def mass_ratio_findings(lumps: Sequence[Lump]) -> Iterator[Finding]:
    """Yields a finding for each lump whose mass differs too much from that of the lump that it moves on."""
    lump_by_body = {body.name: lump for lump in lumps for body, _ in lump.members}
    for lump in lumps:
        support = _supporting_lump(lump, lump_by_body)
        if support is None or min(lump.mass, support.mass) <= MAX_DUMMY_MASS:
            continue
        ratio = max(lump.mass / support.mass, support.mass / lump.mass)
        if ratio > MAX_MASS_RATIO:
            message = (
                f'{lump.mass:g} kg beside the {support.mass:g} kg of "{support.body.name}", {ratio:.2g} to 1'
            )
            yield Finding(*lump.body.places["mass"], message)


def _supporting_lump(lump: Lump, lump_by_body: Mapping[str, Lump]) -> Lump | None:
    """Returns the lump that a lump moves on; None if the lump cannot move, or moves on the world or on a lump
    that cannot move."""
    support = lump_by_body.get(lump.body.parent)
    return support if lump.moves and support is not None and support.moves else None
