"""What CoACD gets: closed manifold surfaces, simplified within a share of the tolerance, one for each body.

CoACD takes minutes for a mesh as CAD gives it and seconds for the same shape of some thousand triangles; it
needs it closed, so the simplification is that of manifold3d, which keeps it so. Bubbles inside a body are
filled: nothing gets there. A body that lies across itself CoACD cuts without end.
"""

from __future__ import annotations

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.surfaces.booleans import body_of, surface_of_body
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.inside import Inside

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
