"""Convex pieces as CoACD makes them: it crashes on some meshes, and never ends on others, so only guest
processes come here.

CoACD takes minutes for a mesh as CAD gives it and seconds for the same shape of some thousand triangles; it
needs it closed, so the simplification is that of manifold3d, which keeps it so. Bubbles inside a body are
filled: nothing gets there. A body that lies across itself CoACD cuts without end.

The only module that imports `coacd`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.configuration.decompose_options import Search
from linkwright.stages.mesh.decompose.seams import grown
from linkwright.stages.mesh.surfaces.booleans import body_of, surface_of_body
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.inside import Inside
from linkwright.stages.mesh.surfaces.snapping import grid, on_grid, snapped

_CONVEX = 1.002
"""A body whose hull has at most so many times its volume is one piece; so is one smaller than the
tolerance."""

_OVERLAP_OF_SIZE = 4e-5
"""How far each piece is grown, as a share of the part's diagonal: as far apart CoACD leaves pieces that touch
along a cut."""


def decomposed(surface: Surface, tolerance: float, search: Search) -> tuple[Surface, ...] | str:
    """The convex pieces of a surface for a tolerance [m], more than are wanted; where there are none, the
    reason in words."""
    surface, arguments = snapped(surface), search.arguments(tolerance)
    bodies = prepared(surface, tolerance)
    if bodies == NOT_CLOSED and arguments["preprocess_mode"] == "on":
        bodies = (surface,)
    if isinstance(bodies, str):
        return bodies
    pitch = grid(surface.diagonal)
    parts = [piece for body in bodies for piece in _pieces(body, tolerance, arguments)]
    hulls = [hull for part in parts if (hull := convex_hull(on_grid(part, pitch)))]
    hulls.sort(key=lambda hull: hull.vertices.tobytes())
    return tuple(hulls) or "the mesh is flat"


def _pieces(body: Surface, tolerance: float, arguments: dict[str, Any]) -> list[Points]:
    """The corners of the convex pieces of one closed body."""
    hull = convex_hull(body.vertices)
    if hull is None:
        return []
    if body.diagonal < tolerance or hull.volume() <= _CONVEX * body.volume():
        return [hull.vertices]
    # Late: only what planes do not cut needs CoACD.
    import coacd

    coacd.set_log_level("error")
    parts = coacd.run_coacd(coacd.Mesh(body.vertices, body.triangles), **arguments)
    hulls = [convex_hull(np.asarray(vertices, dtype=np.float64)) for vertices, _ in parts]
    overlap = _OVERLAP_OF_SIZE * body.diagonal
    return [grown(hull, overlap) for hull in hulls if hull]


_PASSES = (0.1, 0.1, 0.1, 0.1)
"""How far each pass of simplification may move the surface, in tolerances."""

_FEW_FACES = 2500
"""So few triangles need no further pass. Two short passes leave fewer of them than a long one."""

_ACROSS = 0.005
"""The share of a body that it may go round more often than once."""

_ALONG = 16
"""Points along each side of a body's box that tell how often it goes round them."""

NOT_CLOSED = "the mesh is not closed, or lies across itself"


def prepared(surface: Surface, tolerance: float) -> tuple[Surface, ...] | str:
    """The bodies of a part, in the order of their size; where CoACD cannot have them, the reason in words."""
    if convex_hull(surface.vertices) is None:
        return "the mesh is flat"
    solid = body_of(surface)
    if solid is not None and solid.volume() < 0:
        solid = body_of(surface.flipped())
    if solid is None:
        return NOT_CLOSED
    for share in _PASSES:
        solid = solid.simplify(share * tolerance)
        if solid.num_tri() <= _FEW_FACES:
            break
    bodies = [surface_of_body(body) for body in solid.decompose() if body.volume() > 0]
    if any(map(_lies_across_itself, bodies)):
        return NOT_CLOSED
    bodies.sort(key=lambda body: (-len(body.triangles), body.vertices.tobytes()))
    return tuple(bodies) or "the mesh has no inside"


def _lies_across_itself(body: Surface) -> bool:
    low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
    places = (np.indices((_ALONG,) * 3).reshape(3, -1).T + 0.5) / _ALONG
    times = Inside.of(body).times_around(low + (high - low) * places)
    return int((times > 1).sum() + (times < 0).sum()) > _ACROSS * int((times != 0).sum())
