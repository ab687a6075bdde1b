"""Makes one convex hull of all parts."""

from collections.abc import Sequence

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface, join_surfaces
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.configuration.collider_settings import HullSettings
from linkwright.stages.mesh.fit import capped_hull


def make(surfaces: Sequence[Surface], settings: HullSettings) -> Collision:
    """Makes one hull, and does not judge it, since that would take longer; no pieces for flat parts."""
    surface = join_surfaces(surfaces)
    finite = bool(np.isfinite(surface.vertices).all())
    hull = capped_hull(surface, settings.max_vertices) if finite else None
    return (
        Collision(note="it is flat")
        if hull is None
        else Collision((hull,), len(surface.triangles), rung="hull")
    )
