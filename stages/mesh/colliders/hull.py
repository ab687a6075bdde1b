"""One convex hull of all."""

from collections.abc import Sequence

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface, joined
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.configuration.collider_settings import HullSettings
from linkwright.stages.mesh.fit import capped_hull


def make(surfaces: Sequence[Surface], settings: HullSettings) -> Collision:
    """One mesh, which is not judged: that would take longer than to make it. None of what lies in a plane."""
    every = joined(surfaces)
    finite = bool(np.isfinite(every.vertices).all())
    hull = capped_hull(every, settings.max_vertices) if finite else None
    return (
        Collision(note="it is flat")
        if hull is None
        else Collision((hull,), len(every.triangles), rung="hull")
    )
