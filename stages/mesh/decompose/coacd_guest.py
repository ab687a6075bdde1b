"""Guest process in which CoACD decomposes a mesh: it crashes on some, and never ends on others.

The only module that imports `coacd`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stages.mesh.convex_hull import convex_hull
from stages.mesh.decompose import wire
from stages.mesh.decompose.joining import joinings
from stages.mesh.decompose.overhang import Overhang
from stages.mesh.decompose.prepare import Prepared, prepared
from stages.mesh.decompose.seams import OVERLAP_OF_SIZE, grown
from stages.mesh.decompose.sectors import Hole, hole, sectors
from stages.mesh.decompose.tighten import tightened
from stages.mesh.decompose.wire import Decomposition, refusal
from stages.mesh.inside import Inside
from stages.mesh.snapping import grid, on_grid
from stages.mesh.surface import Points, Surface, joined

_CONVEX = 1.002
"""A body whose hull has at most so many times its volume is one piece; so is one smaller than the
tolerance."""


def answer(request: bytes) -> bytes:
    """To a `wire.request` with the `tolerance` [m], CoACD's `arguments` and whether to cut into `sectors`
    first: a `wire.Decomposition`."""
    head, vertices, triangles = wire.read_request(request)
    surface, tolerance = Surface(vertices, triangles), head["tolerance"]
    through = hole(surface, tolerance) if head["sectors"] else None
    return wire.write(_decomposition(surface, tolerance, head["arguments"], through))


def _decomposition(
    surface: Surface, tolerance: float, arguments: dict[str, Any], through: Hole | None
) -> Decomposition:
    if convex_hull(surface.vertices) is None:
        return refusal("the mesh is flat")
    made = prepared(surface, tolerance)
    if isinstance(made, str):
        return refusal(made)
    bodies = made.bodies
    if through is not None:
        bodies = tuple(sector for body in bodies for sector in sectors(body, through))
    parts = [piece for body in bodies for piece in _pieces(body, tolerance, arguments)]
    if made.around:
        parts = tightened(parts, surface, made.around, tolerance)
    pitch = grid(_size(surface))
    hulls = [hull.vertices for part in parts if (hull := convex_hull(on_grid(part, pitch)))]
    hulls.sort(key=lambda hull: hull.tobytes())
    return _finished(made, hulls, Overhang.quick(surface, tolerance, Inside.of(joined(made.bodies))))


def _finished(made: Prepared, hulls: list[Points], overhang: Overhang) -> Decomposition:
    if not hulls:
        return refusal("the mesh is flat")
    faces = sum(len(body.triangles) for body in made.bodies)
    volume = sum(body.volume() for body in made.bodies)
    return Decomposition(tuple(hulls), joinings(hulls, overhang), made.way, faces, volume)


def _pieces(body: Surface, tolerance: float, arguments: dict[str, Any]) -> list[Points]:
    """The corners of the convex pieces of one closed body."""
    hull = convex_hull(body.vertices)
    if hull is None:
        return []
    if _size(body) < tolerance or hull.volume() <= _CONVEX * body.volume():
        return [hull.vertices]
    import coacd

    coacd.set_log_level("error")
    parts = coacd.run_coacd(coacd.Mesh(body.vertices, body.triangles), **arguments)
    hulls = [convex_hull(np.asarray(vertices, dtype=np.float64)) for vertices, _ in parts]
    overlap = OVERLAP_OF_SIZE * _size(body)
    return [grown(hull, overlap) for hull in hulls if hull]


def _size(surface: Surface) -> float:
    """The diagonal [m]."""
    return float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
