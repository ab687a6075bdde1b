"""What CoACD gets: closed manifold surfaces, simplified within a share of the tolerance, one for each body.

CoACD takes minutes for a mesh as CAD gives it and seconds for the same shape of some thousand triangles; it
needs it closed, so the simplification is that of manifold3d, which keeps it so. Bubbles inside a body are
filled: nothing gets there. A body that lies across itself CoACD cuts without end: it is closed round anew.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stages.mesh.decompose.remesh import closed_around
from stages.mesh.inside import Inside
from stages.mesh.surface import Points, Surface, Triangles

_PASSES = {"as it is": (0.1, 0.1, 0.1, 0.1), "remeshed": (0.1, 0.15, 0.2, 0.2)}
"""How far each pass of simplification may move the surface, in tolerances. Around a mesh it may be further,
since its pieces are drawn in again."""

_FEW_FACES = 2500
"""So few triangles need no further pass. Two short passes leave fewer of them than a long one."""

_PITCH_OF_TOLERANCE = 0.75
_FINEST_OF_SIZE = 1 / 128

_ACROSS = 0.005
"""The share of a body that it may go round more often than once."""

_ALONG = 16
"""Points along each side of a body's box that tell how often it goes round them."""


@dataclass(frozen=True, slots=True, eq=False)
class Prepared:
    """A part as closed bodies, in the order of their size, and how they were made.

    `around` [m]: how far the bodies reach beyond the part, where they were made around it.
    """

    bodies: tuple[Surface, ...]
    way: str
    around: float


def prepared(surface: Surface, tolerance: float) -> Prepared | str:
    """The bodies of a part; where it has none, the reason in words."""
    bodies = _bodies(surface, tolerance, "as it is")
    if bodies is not None and not any(map(_lies_across_itself, bodies)):
        return Prepared(bodies, "as it is", 0.0) if bodies else "the mesh has no inside"
    size = float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
    around = max(_PITCH_OF_TOLERANCE * tolerance, _FINEST_OF_SIZE * size)
    bodies = _bodies(closed_around(surface, around), tolerance, "remeshed")
    if bodies is None:
        return "the mesh is not closed, and no closed surface around it could be made"
    return Prepared(bodies, "remeshed", around) if bodies else "the mesh has no inside"


def _bodies(surface: Surface, tolerance: float, way: str) -> tuple[Surface, ...] | None:
    """The simplified bodies of a surface; None where it is not manifold."""
    solid = solid_of(surface.vertices, surface.triangles)
    if solid is None:
        return None
    bodies = [
        surface_of(body) for body in _simplified(solid, tolerance, way).decompose() if body.volume() > 0
    ]
    return tuple(sorted(bodies, key=lambda body: (-len(body.triangles), body.vertices.tobytes())))


def _lies_across_itself(body: Surface) -> bool:
    low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
    places = (np.indices((_ALONG,) * 3).reshape(3, -1).T + 0.5) / _ALONG
    times = Inside.of(body).times_around(low + (high - low) * places)
    return int((times > 1).sum() + (times < 0).sum()) > _ACROSS * int((times != 0).sum())


def solid_of(vertices: Points, triangles: Triangles) -> Any:
    """The manifold3d body of a mesh, turned outside out; None where it is not manifold, or is empty."""
    import manifold3d

    mesh = manifold3d.Mesh64(np.ascontiguousarray(vertices), np.ascontiguousarray(triangles, dtype=np.uint64))
    solid = manifold3d.Manifold(mesh)
    if solid.status() != manifold3d.Error.NoError or solid.is_empty():
        return None
    if solid.volume() < 0:
        return solid_of(vertices, triangles[:, ::-1])
    return solid


def _simplified(solid: Any, tolerance: float, way: str) -> Any:
    """The body with fewer triangles."""
    for share in _PASSES[way]:
        solid = solid.simplify(share * tolerance)
        if solid.num_tri() <= _FEW_FACES:
            break
    return solid


def surface_of(body: Any) -> Surface:
    """The surface of a body of manifold3d."""
    mesh = body.to_mesh64()
    vertices = np.array(mesh.vert_properties, dtype=np.float64)[:, :3]
    return Surface(vertices, np.array(mesh.tri_verts).astype(np.int64))
