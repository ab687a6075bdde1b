"""Measures the shapes of a compiled model's bodies by points whose hull contains them."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.robot.model.robot import Array
from linkwright.stages.validate.findings import largest_error
from linkwright.stages.validate.model.poses import rotation
from linkwright.stages.validate.model.shapes import vertices

_CORNERS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))

MAX_VERTICES = 20_000
"""Largest number of vertices of a mesh that are measured. A finer mesh is sampled evenly, which misses next
to nothing."""

DIRECTIONS = 64
"""Number of directions in which a body is measured, in addition to its axes."""


@dataclass(frozen=True, slots=True, eq=False)
class BodyExtents:
    """The extent of a body's shapes."""

    points: Array
    """The outermost points (n, 3) [m] in many directions, in the body's frame."""

    size: float
    """The diagonal [m] of the box of the points."""

    volume: float
    """The volume [m³] of a box that holds all points."""

    has_mesh: bool
    """Whether a mesh is among the shapes."""


def extents(model: Any, body: int) -> BodyExtents | None:
    """Returns the extents of all geoms of a body, visual or colliding. Returns None if the body has no geoms,
    or only infinite geoms such as planes."""
    first = int(model.body_geomadr[body])
    geoms = range(first, first + int(model.body_geomnum[body]))
    has_mesh = bool((model.geom_type[first : geoms.stop] == mujoco.mjtGeom.mjGEOM_MESH).any())
    return extents_of([geom_points(model, geom) for geom in geoms], has_mesh)


def extents_of(points: Sequence[Array], has_mesh: bool) -> BodyExtents | None:
    """Returns the extents of the points (n, 3) of several shapes; None without points. `has_mesh`: whether a
    mesh is among the shapes."""
    if not sum(map(len, points)):
        return None
    outermost = outermost_of(np.concatenate(points))
    return BodyExtents(outermost, math.hypot(*np.ptp(outermost, axis=0)), _volume(outermost), has_mesh)


def outermost_of(points: Array) -> Array:
    """Returns those of the `points` (n, 3) that are the outermost in some direction, as (m, 3)."""
    along = points @ measured_directions().T
    outermost: Array = points[np.unique(np.concatenate([along.argmax(axis=0), along.argmin(axis=0)]))]
    return outermost


def geom_points(model: Any, geom: int) -> Array:
    """Returns points (n, 3) [m] in the body's frame whose hull contains a geom; empty for infinite geoms."""
    geom_type = mujoco.mjtGeom(model.geom_type[geom])
    if geom_type in (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_HFIELD):
        return np.zeros((0, 3))
    if geom_type == mujoco.mjtGeom.mjGEOM_MESH:
        local = vertices(model, geom)
        local = local[:: 1 + len(local) // MAX_VERTICES]
    else:
        # The box is good enough for a round shape: mistakes in units are factors of ten or a thousand.
        centre, half = model.geom_aabb[geom][:3], model.geom_aabb[geom][3:]
        local = centre + _CORNERS * half
    points: Array = local @ rotation(model.geom_quat[geom]).T + model.geom_pos[geom]
    return points


def measured_directions() -> Array:
    """Returns unit vectors (n, 3) spread evenly over a half of the sphere (Fibonacci's lattice), and the
    axes."""
    # Half of the sphere is enough, since the reach is measured in both senses of a direction.
    turn = math.pi * (3.0 - math.sqrt(5.0))
    up = (np.arange(DIRECTIONS) + 0.5) / DIRECTIONS
    wide = np.sqrt(1.0 - up * up)
    angle = turn * np.arange(DIRECTIONS)
    spread = np.column_stack([wide * np.cos(angle), wide * np.sin(angle), up])
    return np.concatenate([np.eye(3), spread])


def _volume(points: Array) -> float:
    """Returns the volume of the smaller of two boxes: along the body's axes, and along the principal
    directions of the points."""
    # The body's axes may be oblique to the shape, and principal directions of points may be so too.
    axes = np.linalg.eigh(np.cov(points.T))[1]
    boxes = (np.ptp(points, axis=0), np.ptp(points @ axes, axis=0))
    return min(float(np.prod(sides)) for sides in boxes)


def outside(shape: BodyExtents, point: Array) -> float:
    """Returns a lower bound of the distance [m] of a point (3,) from the hull; 0 within the hull, infinity
    for a NaN."""
    axes = measured_directions()
    along, point_along = shape.points @ axes.T, axes @ point
    beyond = np.maximum(point_along - along.max(axis=0), along.min(axis=0) - point_along)
    return largest_error((0.0, float(beyond.max())))


def reaches(shape: BodyExtents, centre: Array, axes: Array) -> Array:
    """Returns the shape's reach (3,) [m] from each of three lines through `centre` (3,). The lines are along
    the columns of `axes` (3, 3)."""
    local = (shape.points - centre) @ axes
    # The square of a point's distance from a line is that from the centre less the part along the line.
    squares = local**2
    distances: Array = np.sqrt((squares.sum(axis=1)[:, None] - squares).max(axis=0))
    return distances
