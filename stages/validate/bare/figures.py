"""Defines the masses and sizes of the bodies of a bare file, whatever its format."""

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from linkwright.stages.robot.dynamics.inertia import merged, moved
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array, Inertial
from linkwright.stages.validate.model.body_shapes import extents_of
from linkwright.stages.validate.model.inertials import Quantity, ShapedInertial

UNIT_CORNERS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
"""The corners (8, 3) of the cube from -1 to 1."""


@dataclass(frozen=True, slots=True, eq=False)
class ShapeFigures:
    """A shape of a body."""

    points: Array
    """The outermost points (n, 3) [m], in the body's frame."""

    collides: bool
    seen: bool
    """Whether the shape is drawn."""

    mesh: bool
    """Whether the shape is a mesh."""

    element: str
    """The element of the file that gives the size."""

    attribute: str
    """The attribute of that element."""

    placed_by: tuple[str, str]
    """The element and the attribute that give the place."""

    group: int = 0
    """The group of shapes that is drawn together."""

    @property
    def extent(self) -> float:
        """The diagonal [m] of the shape's box."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))


@dataclass(frozen=True, slots=True, eq=False)
class BareBody:
    """A body with its mass and its shapes."""

    name: str
    parent: str
    """The name of the body above; "" without such a body."""

    fixed: bool
    """Whether the body is fixed to its parent."""

    world_from_body: Array
    """The pose (4, 4) at the start."""

    inertial: Inertial
    """The inertial in the body's frame."""

    shapes: tuple[ShapeFigures, ...]
    whole: bool
    """Whether all shapes of the file could be read."""

    places: Mapping[Quantity, tuple[str, str]]
    """The element and the attribute that give each quantity."""


@dataclass(frozen=True, slots=True, eq=False)
class Lump:
    """A body with all bodies that are fixed to it. A body that is fixed to the world is a separate lump."""

    members: tuple[tuple[BareBody, Array], ...]
    """The bodies with their poses lump_from_body (4, 4), the lump's main body first."""

    moves: bool
    """Whether the lump can move."""

    @property
    def body(self) -> BareBody:
        return self.members[0][0]

    @property
    def mass(self) -> float:
        return sum(body.inertial.mass for body, _ in self.members)

    def points(self, shape: ShapeFigures, lump_from_body: Array) -> Array:
        """Returns the points (n, 3) [m] of a member's shape in the lump's frame."""
        points: Array = shape.points @ lump_from_body[:3, :3].T + lump_from_body[:3, 3]
        return points

    @property
    def shapes(self) -> Iterator[tuple[ShapeFigures, Array]]:
        """Yields the shapes, each with its points (n, 3) [m] in the lump's frame."""
        return ((shape, self.points(shape, pose)) for body, pose in self.members for shape in body.shapes)

    @property
    def inertial(self) -> ShapedInertial | None:
        """Returns the inertial with the shapes. Returns None without shapes, if a shape cannot be read, or if
        a number is not finite."""
        points = [points for _, points in self.shapes]
        parts = [(body, moved(body.inertial, pose)) for body, pose in self.members]
        total = merged([inertial for _, inertial in parts])
        numbers = (total.com, total.inertia, *points)
        if not all(body.whole for body, _ in self.members) or not all(
            np.isfinite(number).all() for number in numbers
        ):
            return None
        extents = extents_of(points, any(shape.mesh for shape, _ in self.shapes))
        if extents is None:
            return None
        moments, axes = np.linalg.eigh(total.inertia)
        places = _contributors(parts, total)
        return ShapedInertial(total.mass, total.com, moments, axes, extents, self.moves, places)


def _contributors(
    parts: Sequence[tuple[BareBody, Inertial]], whole: Inertial
) -> dict[Quantity, tuple[str, str]]:
    """Maps each quantity to the place in the file of the part that contributes most to it. `parts`: the
    members, with their inertials in the lump's frame; `whole`: the inertial of all."""

    def share(quantity: Quantity, part: Inertial) -> float:
        """Returns the part's share: of the trace of the inertia [kg m²], of the shift of the centre of mass
        [kg m], or of the mass [kg]."""
        arm = float(np.linalg.norm(part.com - whole.com))
        if quantity == "inertia":
            return float(np.trace(part.inertia)) + 2.0 * part.mass * arm**2
        return part.mass * arm if quantity == "centre" and len(parts) > 1 else part.mass

    quantities: tuple[Quantity, ...] = ("inertia", "centre", "mass", "shape")
    return {
        quantity: max(parts, key=lambda part: share(quantity, part[1]))[0].places[quantity]
        for quantity in quantities
    }


def grouped_lumps(bodies: Sequence[BareBody]) -> list[Lump]:
    """Returns the lumps of bodies that are fixed together, in the order of the bodies."""
    by_name = {body.name: body for body in bodies}
    groups: dict[str, list[BareBody]] = {}
    moves = {}
    for body in bodies:
        holder, held = _holder(body, by_name)
        # Bodies that are fixed to the world need not be near each other.
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


def _holder(body: BareBody, by_name: Mapping[str, BareBody]) -> tuple[BareBody, bool]:
    """Follows fixed joints upwards from `body`. Returns the last body, which is `body` itself if it can move,
    and whether it is fixed to the world."""
    visited = {body.name}
    while body.fixed and body.parent in by_name and body.parent not in visited:
        body = by_name[body.parent]
        visited.add(body.name)
    return body, body.fixed and not body.parent


def box_corners(centre: Array, half: Array, body_from_shape: Array) -> Array:
    """Returns the corners (8, 3) [m] of a box, in the body's frame. `centre` (3,) and `half` (3,), half the
    sides, are in the shape's frame."""
    local = centre + UNIT_CORNERS * half
    corners: Array = local @ body_from_shape[:3, :3].T + body_from_shape[:3, 3]
    return corners


def origin_span(bodies: Iterable[BareBody]) -> float:
    """Returns the diagonal [m] of the box around the origins of the bodies; 0 for a single body and without
    bodies."""
    origins = np.array([body.world_from_body[:3, 3] for body in bodies]).reshape(-1, 3)
    return float(np.linalg.norm(np.ptp(origins, axis=0))) if len(origins) else 0.0
