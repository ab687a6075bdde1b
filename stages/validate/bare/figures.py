"""What a body of a bare file weighs and how large it is, in whatever format it is written."""

import itertools
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from stages.robot.model import Array
from stages.validate.findings import MARK

CORNERS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))


@dataclass(frozen=True, slots=True, eq=False)
class ShapeFigures:
    """A shape of a body. `corners` (8, 3) [m]: of a box around it, in the body's frame; `mesh`: whether it is
    one. `element`, `attribute`: what the file says its size by; `placed_by`: where it is."""

    corners: Array
    collides: bool
    mesh: bool
    element: str
    attribute: str
    placed_by: tuple[str, str]

    @property
    def extent(self) -> float:
        """The diagonal of its box [m]."""
        return float(np.linalg.norm(self.corners[7] - self.corners[0]))


@dataclass(frozen=True, slots=True, eq=False)
class WeighedBody:
    """A body. `world` (3,) [m]: its origin at the start; `com` (3,) and `inertia` (3, 3) about it, in its own
    frame; `parent`: the name of the body above, "" for none; `fixed`: whether it is fixed to it; `whole`:
    whether all its shapes could be read. `mass_at`, `inertia_at`, `com_at`: the element and the attribute
    that say so."""

    name: str
    parent: str
    fixed: bool
    world: Array
    mass: float
    com: Array
    inertia: Array
    shapes: tuple[ShapeFigures, ...]
    whole: bool
    mass_at: tuple[str, str]
    inertia_at: tuple[str, str]
    com_at: tuple[str, str]

    @property
    def marked(self) -> bool:
        """Whether a shape of it is a mark and not its form: many files have a box or a ball of a few
        millimetres where a link has no mesh."""
        seen = [shape for shape in self.shapes if not shape.collides] or self.shapes
        return bool(seen) and all(not shape.mesh and shape.extent < MARK for shape in seen)

    def box(self, *, collides: bool | None = None) -> tuple[Array, Array] | None:
        """The least and greatest corner of all shapes, of the seen or of those that collide; None without."""
        corners = [one.corners for one in self.shapes if collides is None or one.collides == collides]
        if not corners:
            return None
        points = np.concatenate(corners)
        return points.min(axis=0), points.max(axis=0)


def box_corners(centre: Array, half: Array, body_from_shape: Array) -> Array:
    """The corners (8, 3) of a box, in the body's frame."""
    local = centre + CORNERS * half
    corners: Array = local @ body_from_shape[:3, :3].T + body_from_shape[:3, 3]
    return corners


def reach(bodies: Iterable[WeighedBody]) -> float:
    """The diagonal [m] of the box around the origins of the bodies that are on joints: 0 for one body."""
    origins = np.array([one.world for one in bodies]).reshape(-1, 3)
    return float(np.linalg.norm(np.ptp(origins, axis=0))) if len(origins) else 0.0
