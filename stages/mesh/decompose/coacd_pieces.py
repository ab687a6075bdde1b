"""Convex pieces as CoACD makes them: it crashes on some meshes, and never ends on others, so only guest
processes come here.

The only module that imports `coacd`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from linkwright.stages.formats.meshes.surface import Points, Surface
from linkwright.stages.mesh.configuration.decompose_options import DecomposeOptions
from linkwright.stages.mesh.decompose.prepare import NOT_CLOSED, prepared
from linkwright.stages.mesh.decompose.seams import grown
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.snapping import grid, on_grid, snapped

_CONVEX = 1.002
"""A body whose hull has at most so many times its volume is one piece; so is one smaller than the
tolerance."""

_OVERLAP_OF_SIZE = 4e-5
"""How far each piece is grown, as a share of the part's diagonal: as far apart CoACD leaves pieces that touch
along a cut."""


def decomposed(surface: Surface, options: DecomposeOptions) -> tuple[Surface, ...] | str:
    """The convex pieces of a surface, more than are wanted; where there are none, the reason in words."""
    surface, arguments = snapped(surface), options.arguments
    bodies = prepared(surface, options.tolerance)
    if bodies == NOT_CLOSED and arguments["preprocess_mode"] == "on":
        bodies = (surface,)
    if isinstance(bodies, str):
        return bodies
    pitch = grid(surface.diagonal)
    parts = [piece for body in bodies for piece in _pieces(body, options.tolerance, arguments)]
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
    import coacd

    coacd.set_log_level("error")
    parts = coacd.run_coacd(coacd.Mesh(body.vertices, body.triangles), **arguments)
    hulls = [convex_hull(np.asarray(vertices, dtype=np.float64)) for vertices, _ in parts]
    overlap = _OVERLAP_OF_SIZE * body.diagonal
    return [grown(hull, overlap) for hull in hulls if hull]
