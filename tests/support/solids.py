"""Surfaces of known shape."""

from collections.abc import Mapping

import numpy as np
import trimesh

from linkwright.stages.formats import triangles
from linkwright.stages.formats.meshes import surface
from linkwright.stages.formats.meshes.surface import Surface, weld


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


def bodies_of(meshes: Mapping[str, trimesh.Trimesh]) -> bytes:
    """Meshes by part id, grey, as a reply in the compact form."""
    grey = [(0.7, 0.7, 0.7, 1.0)]
    return triangles.encode(
        [
            triangles.merged(
                name,
                np.asarray(mesh.vertices, dtype=float),
                np.asarray(mesh.faces, dtype=np.int64),
                grey,
                np.zeros(len(mesh.faces), dtype=np.int64),
            )
            for name, mesh in meshes.items()
        ]
    )
