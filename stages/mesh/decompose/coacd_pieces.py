"""Makes convex pieces with CoACD. Only guest processes call it, since it crashes on some meshes, and does not
terminate on others.

CoACD takes minutes for a mesh from CAD, and seconds for the same shape with some thousand triangles. It needs
a closed mesh, so manifold3d simplifies it, which keeps it closed. Bubbles inside a body are filled, since
nothing reaches them. CoACD does not terminate on self-intersecting bodies.

The only module that imports `coacd`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.configuration.decompose_options import CoacdParameters
from linkwright.stages.mesh.decompose.seams import expanded_corners
from linkwright.stages.mesh.surfaces.booleans import body_of, surface_of_body
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.inside import InsideTest
from linkwright.stages.mesh.surfaces.snapping import grid, on_grid, snapped

_MAX_HULL_RATIO = 1.002
"""A body stays a single piece if its hull has at most this many times its volume, or if it is smaller than
the tolerance."""

_OVERLAP_SHARE = 4e-5
"""Distance by which each piece is grown, as a share of the part's diagonal: CoACD leaves such a gap between
pieces that touch along a cut."""


def convex_pieces(
    surface: Surface, tolerance: float, parameters: CoacdParameters
) -> tuple[Surface, ...] | str:
    """Returns the convex pieces of a surface for a tolerance [m], more than necessary; or the reason in words
    why there are none."""
    surface, arguments = snapped(surface), parameters.arguments(tolerance)
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
    """Returns the corners of each convex piece of a closed body."""
    hull = convex_hull(body.vertices)
    if hull is None:
        return []
    if body.diagonal < tolerance or hull.volume() <= _MAX_HULL_RATIO * body.volume():
        return [hull.vertices]
    # Late: only the maker `coacd` needs it.
    import coacd

    coacd.set_log_level("error")
    parts = coacd.run_coacd(coacd.Mesh(body.vertices, body.triangles), **arguments)
    hulls = [convex_hull(np.asarray(vertices, dtype=np.float64)) for vertices, _ in parts]
    overlap = _OVERLAP_SHARE * body.diagonal
    return [expanded_corners(hull, overlap) for hull in hulls if hull]


_SIMPLIFICATION_STEPS = (0.1, 0.1, 0.1, 0.1)
"""Distance, in tolerances, by which each pass of simplification may move the surface."""

_MAX_FACES = 2500
"""Number of triangles at which no further pass is made. Two short passes leave fewer triangles than a long
one."""

_MAX_SELF_OVERLAP = 0.005
"""Largest share of a body in which its winding number may be above 1 or below 0: there it overlaps itself."""

_POINTS_PER_SIDE = 16
"""Number of points along each side of a body's box at which the winding number is computed."""

NOT_CLOSED = "the mesh is not closed, or intersects itself"
"""Reason in words why CoACD cannot take a mesh; planes cut it instead."""


def prepared(surface: Surface, tolerance: float) -> tuple[Surface, ...] | str:
    """Returns the bodies of a part, the largest first; or the reason in words why CoACD cannot take them."""
    if convex_hull(surface.vertices) is None:
        return "the mesh is flat"
    solid = body_of(surface)
    if solid is not None and solid.volume() < 0:
        solid = body_of(surface.flipped())
    if solid is None:
        return NOT_CLOSED
    for share in _SIMPLIFICATION_STEPS:
        solid = solid.simplify(share * tolerance)
        if solid.num_tri() <= _MAX_FACES:
            break
    bodies = [surface_of_body(body) for body in solid.decompose() if body.volume() > 0]
    if any(map(_intersects_itself, bodies)):
        return NOT_CLOSED
    bodies.sort(key=lambda body: (-len(body.triangles), body.vertices.tobytes()))
    return tuple(bodies) or "the mesh has no inside"


def _intersects_itself(body: Surface) -> bool:
    low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
    shares = (np.indices((_POINTS_PER_SIDE,) * 3).reshape(3, -1).T + 0.5) / _POINTS_PER_SIDE
    winding_numbers = InsideTest.of(body).closed_winding(low + (high - low) * shares)
    return int((winding_numbers > 1).sum() + (winding_numbers < 0).sum()) > _MAX_SELF_OVERLAP * int(
        (winding_numbers != 0).sum()
    )
