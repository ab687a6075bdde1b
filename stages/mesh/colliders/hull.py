"""One convex hull of all."""

from collections.abc import Sequence

import numpy as np

from stages.mesh.collider_settings import ColliderSettings
from stages.mesh.collision import Collision
from stages.mesh.fit import capped_hull
from stages.mesh.surface import Surface, joined
from stages.mesh.verdict import measured


def make(surfaces: Sequence[Surface], settings: ColliderSettings) -> Collision:
    """One mesh; none where the surfaces lie in a plane."""
    return measured(whole(surfaces, settings), surfaces, settings)


def whole(surfaces: Sequence[Surface], settings: ColliderSettings) -> Collision:
    """The same without its measures."""
    every = joined(surfaces)
    finite = bool(np.isfinite(every.vertices).all())
    hull = capped_hull(every, settings.max_vertices) if finite else None
    return Collision(note="it is flat") if hull is None else Collision((hull,), rung="hull")
