"""No collider: the link is seen, and touches nothing."""

from collections.abc import Sequence

from stages.mesh.collider_settings import ColliderSettings
from stages.mesh.collision import Collision
from stages.mesh.surface import Surface


def make(surfaces: Sequence[Surface], settings: ColliderSettings) -> Collision:
    """None."""
    return Collision()
