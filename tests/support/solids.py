"""Surfaces of known shape."""

import numpy as np
import trimesh

from stages.mesh import surface
from stages.mesh.surface import Surface, weld


def of_mesh(mesh: trimesh.Trimesh) -> Surface:
    """A mesh of trimesh as a welded surface."""
    welded, _ = weld(np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int64))
    return welded


def box(*sizes: float, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Surface:
    """A box about a point."""
    mesh = trimesh.creation.box(sizes)
    mesh.apply_translation(at)
    return of_mesh(mesh)


def joined(*surfaces: Surface) -> Surface:
    """Several surfaces as one, each with its own vertices."""
    return surface.joined(surfaces)
