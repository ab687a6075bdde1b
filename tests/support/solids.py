"""Surfaces of known shape."""

import numpy as np
import trimesh

from linkwright.stages.formats.meshes import body_arrays, surface
from linkwright.stages.formats.meshes.surface import weld


def of_mesh(mesh):
    """A mesh of trimesh as a welded surface."""
    welded, _ = weld(np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int64))
    return welded


def box(*sizes, at=(0.0, 0.0, 0.0)):
    """A box about a point."""
    mesh = trimesh.creation.box(sizes)
    mesh.apply_translation(at)
    return of_mesh(mesh)


def joined(*surfaces):
    """Several surfaces as one, each with its own vertices."""
    return surface.join_surfaces(surfaces)


def bodies_of(meshes):
    """Meshes by part id, grey, as a reply in the compact form."""
    grey = [(0.7, 0.7, 0.7, 1.0)]
    return body_arrays.encode(
        [
            body_arrays.merged(
                name,
                np.asarray(mesh.vertices, dtype=float),
                np.asarray(mesh.faces, dtype=np.int64),
                grey,
                np.zeros(len(mesh.faces), dtype=np.int64),
            )
            for name, mesh in meshes.items()
        ]
    )
