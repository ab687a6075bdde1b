"""The bodies of a bare file against their shapes and each other, by the codes that a build has for them."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from linkwright.stages.robot.check import CheckLevel, Finding
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.validate.bare.figures import Lump, ShapeFigures
from linkwright.stages.validate.bare.findings import Coded
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.model.body_shapes import directions
from linkwright.stages.validate.model.inertials import MARK, STAND_IN, ShapedInertial

RATIO = 1000.0
"""Masses of neighbours above this ratio are hard to solve for."""

BESIDE, AWAY = 0.1, 1.0
"""How far a collider is beside what is seen, as a share of the size of that: worth a look, and of another
place."""

WIDE = 5.0
"""A collider this many times as wide as what is seen is worth a look."""


def inertials(lumps: Sequence[Lump]) -> list[ShapedInertial]:
    """Those of lumps whose shapes are known."""
    found = (lump.inertial for lump in lumps)
    return [inertial for inertial in found if inertial is not None]


def colliders(lumps: Sequence[Lump]) -> tuple[CheckLevel, list[Finding]]:
    """Colliders that are beside what is seen of their lump, or many times its size; an error where one is
    certainly wrong, which is named first."""
    apart = [finding for lump in lumps for finding in _apart(lump)]
    level: CheckLevel = "error" if any(wrong for wrong, _ in apart) else "warning"
    return level, [finding for _, finding in sorted(apart, key=lambda pair: not pair[0])]


def weightless(lumps: Sequence[Lump]) -> Iterator[Coded]:
    """Bodies of a URDF that move without any mass, of their own or beyond: no engine can move them."""
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


def _apart(lump: Lump) -> Iterator[tuple[bool, Finding]]:
    """Colliders that are beside what is seen, or many times its size; and whether each is certainly wrong."""
    shapes = list(lump.shapes)
    drawn = {shape.group for shape, _ in shapes if shape.seen and not shape.collides}
    # What collides and is drawn with what does not is a part of the picture, and no second form of it.
    dress = [(shape, points) for shape, points in shapes if shape.seen and shape.group in drawn]
    seen = _form(dress)
    if seen is None or not all(body.whole for body, _ in lump.members):
        return
    low, high = seen.min(axis=0), seen.max(axis=0)
    name, size = lump.body.name, float(np.linalg.norm(high - low))
    solid = [
        (shape, points)
        for shape, points in shapes
        if shape.collides and not (shape.seen and shape.group in drawn)
    ]
    elsewhere = _off([points for _, points in solid], seen) > (AWAY + BESIDE) * size
    for shape, points in solid:
        gap = np.maximum(0.0, np.maximum(low - points.max(axis=0), points.min(axis=0) - high))
        off = float(np.linalg.norm(gap))
        if off > BESIDE * size:
            message = f'a collider of "{name}" is {off:.3g} m beside what is seen, {size:.2g} m wide'
            yield elsewhere, Finding(*shape.placed_by, message)
        elif shape.extent > WIDE * size > 0.0:
            message = f'a collider of "{name}" is {shape.extent:.3g} m wide, what is seen {size:.2g} m'
            yield elsewhere, Finding(shape.element, shape.attribute, message)


def _off(solid: Sequence[Array], seen: Array) -> float:
    """How far [m] colliders with the points `solid` (each n, 3) reach beyond what is seen, with the points
    `seen` (m, 3), or leave of it bare."""
    ways = directions()
    along = seen @ ways.T
    ends = [((points @ ways.T).max(axis=0), (points @ ways.T).min(axis=0)) for points in solid]
    beyond = max(
        (max((high - along.max(axis=0)).max(), (along.min(axis=0) - low).max()) for high, low in ends),
        default=0.0,
    )
    outside = [np.maximum(along - high, low - along).max(axis=1) for high, low in ends]
    bare = np.min(outside, axis=0).max() if outside else 0.0
    return float(max(beyond, bare))


def _form(dress: Sequence[tuple[ShapeFigures, Array]]) -> Array | None:
    """Points (n, 3) of what is drawn; None without, or where a mark stands for it: many files have a box or a
    ball of a few millimetres where a link has no mesh."""
    if all(not shape.mesh and shape.extent < MARK for shape, _ in dress):
        return None
    return np.concatenate([points for _, points in dress])


def neighbours(lumps: Sequence[Lump]) -> Iterator[Finding]:
    """Lumps whose mass and that of what they move on differ by more than `RATIO`."""
    holders = {body.name: lump for lump in lumps for body, _ in lump.members}
    for lump in lumps:
        above = _above(lump, holders)
        if above is None or not lump.mass > STAND_IN < above.mass:
            continue
        ratio = max(lump.mass / above.mass, above.mass / lump.mass)
        if ratio > RATIO:
            message = (
                f'{lump.mass:g} kg beside the {above.mass:g} kg of "{above.body.name}", {ratio:.2g} to 1'
            )
            yield Finding(*lump.body.places["mass"], message)


def _above(lump: Lump, holders: Mapping[str, Lump]) -> Lump | None:
    """What a lump moves on; None for what is on the world."""
    above = holders.get(lump.body.parent)
    return above if lump.moves and above is not None and above.moves else None
