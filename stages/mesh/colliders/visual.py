"""No collider: the link is seen, and touches nothing."""

from collections.abc import Sequence

from linkwright.stages.mesh.collider_settings import ColliderSettings
from linkwright.stages.mesh.collision import Collision
from linkwright.stages.mesh.surface import Surface


def make(surfaces: Sequence[Surface], settings: ColliderSettings) -> Collision:
    """None."""
    return Collision()
