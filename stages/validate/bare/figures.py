"""What a body of a bare file weighs and how large it is, in whatever format it is written."""

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from linkwright.stages.robot.dynamics.inertia import merged, moved
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array, Inertial
from linkwright.stages.validate.model.body_shapes import extents_of
from linkwright.stages.validate.model.inertials import Quantity, ShapedInertial

CORNERS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))


@dataclass(frozen=True, slots=True, eq=False)
class ShapeFigures:
    """A shape of a body. `points` (n, 3) [m]: its outermost points, in the body's frame; `collides`, `seen`:
    whether others touch it, and whether it is drawn, with those of its `group`; `mesh`: whether it is a mesh.
    `element` and `attribute` give its size in the file, `placed_by` its place."""

    points: Array
    collides: bool
    seen: bool
    mesh: bool
    element: str
    attribute: str
    placed_by: tuple[str, str]
    group: int = 0

    @property
    def extent(self) -> float:
        """The diagonal of its box [m]."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))


@dataclass(frozen=True, slots=True, eq=False)
class WeighedBody:
    """A body. `parent`: the name of the body above, "" for the world or none; `fixed`: whether it is fixed to
    that; `world_from_body` (4, 4): where it is at the start; `inertial`: in its own frame; `whole`: whether
    all its shapes could be read; `places`: the element and the attribute that give each quantity."""

    name: str
    parent: str
    fixed: bool
    world_from_body: Array
    inertial: Inertial
    shapes: tuple[ShapeFigures, ...]
    whole: bool
    places: Mapping[Quantity, tuple[str, str]]


@dataclass(frozen=True, slots=True, eq=False)
class Lump:
    """A body with all that is fixed to it, each with lump_from_body (4, 4), itself first. `moves`: whether it
    can move; what is fixed to the world is a lump each."""

    members: tuple[tuple[WeighedBody, Array], ...]
    moves: bool

    @property
    def body(self) -> WeighedBody:
        return self.members[0][0]

    @property
    def mass(self) -> float:
        return sum(body.inertial.mass for body, _ in self.members)

    def points(self, shape: ShapeFigures, lump_from_body: Array) -> Array:
        """(n, 3) [m]: the points of a member's shape in the lump's frame."""
        found: Array = shape.points @ lump_from_body[:3, :3].T + lump_from_body[:3, 3]
        return found

    @property
    def shapes(self) -> Iterator[tuple[ShapeFigures, Array]]:
        """The shapes, each with its points (n, 3) in the lump's frame."""
        return ((shape, self.points(shape, pose)) for body, pose in self.members for shape in body.shapes)

    @property
    def inertial(self) -> ShapedInertial | None:
        """None where it has no shapes, some that could not be read, or numbers that are not finite."""
        points = [points for _, points in self.shapes]
        parts = [(body, moved(body.inertial, pose)) for body, pose in self.members]
        whole = merged([inertial for _, inertial in parts])
        numbers = (whole.com, whole.inertia, *points)
        if not all(body.whole for body, _ in self.members) or not all(
            np.isfinite(one).all() for one in numbers
        ):
            return None
        extents = extents_of(points, any(shape.mesh for shape, _ in self.shapes))
        if extents is None:
            return None
        moments, axes = np.linalg.eigh(whole.inertia)
        places = _blamed(parts, whole)
        return ShapedInertial(whole.mass, whole.com, moments, axes, extents, self.moves, places)


def _blamed(
    parts: Sequence[tuple[WeighedBody, Inertial]], whole: Inertial
) -> dict[Quantity, tuple[str, str]]:
    """By quantity, the place in the file of the part that contributes most to it."""

    def share(quantity: Quantity, part: Inertial) -> float:
        arm = float(np.linalg.norm(part.com - whole.com))
        if quantity == "inertia":
            return float(np.trace(part.inertia)) + 2.0 * part.mass * arm**2
        return part.mass * arm if quantity == "center" and len(parts) > 1 else part.mass

    quantities: tuple[Quantity, ...] = ("inertia", "center", "mass", "shape")
    return {
        quantity: max(parts, key=lambda part: share(quantity, part[1]))[0].places[quantity]
        for quantity in quantities
    }


def lumps(bodies: Sequence[WeighedBody]) -> list[Lump]:
    """The bodies by what is fixed together, in their order."""
    by_name = {body.name: body for body in bodies}
    groups: dict[str, list[WeighedBody]] = {}
    moves = {}
    for body in bodies:
        holder, held = _holder(body, by_name)
        # All that is fixed to the world need not be near each other.
        holder = body if held else holder
        groups.setdefault(holder.name, []).append(body)
        moves[holder.name] = not held
    return [
        Lump(
            tuple(
                (body, inverse(by_name[name].world_from_body) @ body.world_from_body)
                for body in sorted(group, key=lambda body: body.name != name)
            ),
            moves[name],
        )
        for name, group in groups.items()
    ]


def _holder(body: WeighedBody, by_name: Mapping[str, WeighedBody]) -> tuple[WeighedBody, bool]:
    """The body that one is fixed to in the end, itself if to none, and whether that is fixed to the world."""
    seen = {body.name}
    while body.fixed and body.parent in by_name and body.parent not in seen:
        body = by_name[body.parent]
        seen.add(body.name)
    return body, body.fixed and not body.parent


def box_corners(centre: Array, half: Array, body_from_shape: Array) -> Array:
    """The corners (8, 3) of a box, in the body's frame."""
    local = centre + CORNERS * half
    corners: Array = local @ body_from_shape[:3, :3].T + body_from_shape[:3, 3]
    return corners


def reach(bodies: Iterable[WeighedBody]) -> float:
    """The diagonal [m] of the box around the origins of the bodies: 0 for one body."""
    origins = np.array([body.world_from_body[:3, 3] for body in bodies]).reshape(-1, 3)
    return float(np.linalg.norm(np.ptp(origins, axis=0))) if len(origins) else 0.0
