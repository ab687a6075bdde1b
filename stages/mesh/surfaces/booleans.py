"""Converts closed surfaces to bodies of the boolean library, and back."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface

if TYPE_CHECKING:
    from manifold3d import Manifold


def body_of(surface: Surface) -> Manifold | None:
    """Returns a surface as a body; a surface that is inside out stays so. None if the library finds it empty
    or not manifold."""
    # Late: a part from the cache needs no library that makes colliders or decimates.
    from manifold3d import Error, Manifold, Mesh64

    points = np.ascontiguousarray(surface.vertices, dtype=np.float64)
    body = Manifold(Mesh64(points, np.ascontiguousarray(surface.triangles, dtype=np.uint64)))
    return None if body.status() != Error.NoError or body.is_empty() else body


def surface_of_body(body: Manifold) -> Surface:
    """Returns the surface of a body."""
    mesh = body.to_mesh64()
    vertices = np.array(mesh.vert_properties, dtype=np.float64)[:, :3]
    return Surface(vertices, np.array(mesh.tri_verts).astype(np.int64))
