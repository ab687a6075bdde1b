"""A part around a hole, cut into sectors: a tube, a ring, a wheel.

CoACD cuts along x, y and z, and needs dozens of pieces for what is round. Eight sectors of a ring reach into
its hole by 8 % of the radius.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stages.mesh.decompose.prepare import solid_of, surface_of
from stages.mesh.surface import Points, Surface

COUNT = 8
"""How many sectors: into a hole that is 26 tolerances across they reach by one."""

_ROOM = 2.0
"""The radius of the smallest hole that counts, in tolerances."""

_TURNS = 16
"""Directions in which the part has to be seen from within the hole."""

Hole = tuple[Points, int]
"""A point (3,) in its middle, and the axis along which it goes: 0, 1 or 2."""


def hole(surface: Surface, tolerance: float) -> Hole | None:
    """The widest hole right through the middle of a part along x, y or z; None where there is none.

    No triangle comes nearer to the line through it than two tolerances [m], and there are some all around.
    """
    middle = (surface.vertices.min(axis=0) + surface.vertices.max(axis=0)) / 2
    radius, axis = max((_radius(surface, middle, axis), -axis) for axis in range(3))
    return (middle, -axis) if radius >= _ROOM * tolerance else None


def sectors(body: Surface, through: Hole) -> list[Surface]:
    """The closed bodies that are left of a closed body after cuts from the middle of a hole outwards."""
    middle, axis = through
    first, second = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
    turns = 2 * np.pi * np.arange(COUNT) / COUNT
    inwards = [-np.sin(turn) * first + np.cos(turn) * second for turn in turns]
    solid = solid_of(body.vertices, body.triangles)
    found: list[Any] = []
    for one, following in zip(inwards, [*inwards[1:], inwards[0]], strict=True):
        part = solid.trim_by_plane(one, float(one @ middle))
        found += part.trim_by_plane(-following, -float(following @ middle)).decompose()
    return [surface_of(part) for part in found if part.volume() > 0]


def _radius(surface: Surface, middle: Points, axis: int) -> float:
    """How far [m] the surface is at least from the line through the middle along an axis; 0 where it crosses
    the line, or does not go all around it."""
    corners = (surface.corners - middle)[:, :, [(axis + 1) % 3, (axis + 2) % 3]]
    ends = np.roll(corners, -1, axis=1)
    turning = corners[..., 0] * ends[..., 1] - corners[..., 1] * ends[..., 0]
    if ((turning > 0).all(axis=1) | (turning < 0).all(axis=1)).any():
        return 0.0
    edges = ends - corners
    squares = (edges * edges).sum(axis=2)
    share = np.divide(-(corners * edges).sum(axis=2), squares, out=np.zeros_like(squares), where=squares > 0)
    least = np.linalg.norm(corners + np.clip(share, 0.0, 1.0)[..., None] * edges, axis=2).min()
    return float(least) if _all_around(corners, edges) else 0.0


def _all_around(corners: npt.NDArray[np.float64], edges: npt.NDArray[np.float64]) -> bool:
    """Whether edges, from corners (n, 3, 2) on, are seen from the origin in all directions."""
    steps = np.linspace(0.0, 1.0, _TURNS)[:, None, None, None]
    seen = corners + steps * edges
    turns = np.arctan2(seen[..., 1], seen[..., 0]) / (2 * np.pi) % 1
    return len(np.unique(np.floor(turns * _TURNS) % _TURNS)) == _TURNS
