"""Surfaces of known shape."""

import numpy as np
import trimesh

from stages.mesh.surface import Surface, weld


def of_mesh(mesh: trimesh.Trimesh) -> Surface:
    """A mesh of trimesh as a welded surface."""
    surface, _ = weld(np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int64))
    return surface


def box(*sizes: float, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Surface:
    """A box about a point."""
    mesh = trimesh.creation.box(sizes)
    mesh.apply_translation(at)
    return of_mesh(mesh)


def joined(*surfaces: Surface) -> Surface:
    """Several surfaces as one, each with its own vertices."""
    offsets = np.cumsum([0, *(len(surface.vertices) for surface in surfaces)])
    triangles = [surface.triangles + offset for surface, offset in zip(surfaces, offsets, strict=False)]
    return Surface(np.concatenate([surface.vertices for surface in surfaces]), np.concatenate(triangles))
