"""The convex hull of the whole link."""

from collections.abc import Sequence

import numpy as np

from stages.mesh import mesh_file
from stages.mesh.collider_settings import ColliderSettings
from stages.mesh.convex_hull import convex_hull
from stages.mesh.link_mesh import Collider
from stages.mesh.surface import Surface


def make(surfaces: Sequence[Surface], settings: ColliderSettings) -> tuple[Collider, ...]:
    """One mesh; none where the surfaces lie in a plane."""
    hull = convex_hull(np.concatenate([surface.vertices for surface in surfaces]))
    return () if hull is None else (mesh_file.collider(hull),)
