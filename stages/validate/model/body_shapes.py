"""The shapes of a compiled model's bodies: points whose hull contains them, and what that hull measures."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.robot.model.robot import Array
from linkwright.stages.validate.model.poses import rotation
from linkwright.stages.validate.model.shapes import vertices

_CORNERS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))

MOST = 20_000
"""Vertices of a mesh that are looked at: of a finer one an even part, which misses next to nothing."""

WAYS = 64
"""Directions in which a body is measured, beside its axes."""


@dataclass(frozen=True, slots=True, eq=False)
class BodyExtents:
    """How far a body's shapes reach. `points` (n, 3) [m], in the body's axes: the outermost ones in many
    directions. `size` [m]: the diagonal of their box. `volume` [m³] of a box that holds them all. `meshes`:
    whether a mesh is among them."""

    points: Array
    size: float
    volume: float
    meshes: bool


def extents(model: Any, body: int) -> BodyExtents | None:
    """Of all geoms of a body, seen or colliding; None where it has none that ends somewhere, as a plane does
    not."""
    first = int(model.body_geomadr[body])
    geoms = range(first, first + int(model.body_geomnum[body]))
    meshes = bool((model.geom_type[first : geoms.stop] == mujoco.mjtGeom.mjGEOM_MESH).any())
    return extents_of([geom_points(model, geom) for geom in geoms], meshes)


def extents_of(points: Sequence[Array], meshes: bool) -> BodyExtents | None:
    """Of points (n, 3) of several shapes; None without points. `meshes`: whether a mesh is among these."""
    if not sum(map(len, points)):
        return None
    outermost = outermost_of(np.concatenate(points))
    return BodyExtents(outermost, math.hypot(*np.ptp(outermost, axis=0)), _volume(outermost), meshes)


def outermost_of(points: Array) -> Array:
    """Those (m, 3) of points (n, 3) that are the outermost ones in some direction."""
    along = points @ directions().T
    found: Array = points[np.unique(np.concatenate([along.argmax(axis=0), along.argmin(axis=0)]))]
    return found


def geom_points(model: Any, geom: int) -> Array:
    """Points (n, 3) [m] in the body's frame whose hull contains a geom; none of what has no end."""
    kind = mujoco.mjtGeom(model.geom_type[geom])
    if kind in (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_HFIELD):
        return np.zeros((0, 3))
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        local = vertices(model, geom)
        local = local[:: 1 + len(local) // MOST]
    else:
        # The box of a round shape: what is judged here is off by ten times, or a thousand.
        centre, half = model.geom_aabb[geom][:3], model.geom_aabb[geom][3:]
        local = centre + _CORNERS * half
    points: Array = local @ rotation(model.geom_quat[geom]).T + model.geom_pos[geom]
    return points


def directions() -> Array:
    """Unit vectors (n, 3) spread evenly over a half of the sphere (Fibonacci's lattice), and the axes."""
    turn = math.pi * (3.0 - math.sqrt(5.0))
    up = (np.arange(WAYS) + 0.5) / WAYS
    wide = np.sqrt(1.0 - up * up)
    angle = turn * np.arange(WAYS)
    spread = np.column_stack([wide * np.cos(angle), wide * np.sin(angle), up])
    return np.concatenate([np.eye(3), spread])


def _volume(points: Array) -> float:
    """Of the smaller of two boxes: along the body's axes, and along the directions in which the points
    spread."""
    axes = np.linalg.eigh(np.cov(points.T))[1]
    boxes = (np.ptp(points, axis=0), np.ptp(points @ axes, axis=0))
    return min(float(np.prod(sides)) for sides in boxes)


def outside(shape: BodyExtents, point: Array) -> float:
    """How far [m] a point (3,) is outside the hull, at least; 0 within it."""
    ways = directions()
    along, own = shape.points @ ways.T, ways @ point
    beyond = np.maximum(own - along.max(axis=0), along.min(axis=0) - own)
    return max(0.0, float(beyond.max()))


def reaches(shape: BodyExtents, centre: Array, axes: Array) -> Array:
    """How far (3,) [m] the shape reaches from each of three lines through `centre` (3,), along the columns of
    `axes` (3, 3)."""
    local = (shape.points - centre) @ axes
    squares = local**2
    found: Array = np.sqrt((squares.sum(axis=1)[:, None] - squares).max(axis=0))
    return found
